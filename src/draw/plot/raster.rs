//! SVG to PNG with the contained font.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{FontResolver, Options, Tree, fontdb};

use super::PlotError;

/// Most pixels of a side. A larger picture would take gigabytes.
const MOST_PIXELS: f32 = 16_384.0;

/// The only font, whatever the text asks for: fonts of the machine cannot change a picture.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    let face: Arc<&'static [u8]> = Arc::new(epaint_default_fonts::UBUNTU_LIGHT);
    fonts.load_font_source(fontdb::Source::Binary(face));
    Arc::new(fonts)
});

/// Renders SVG text as a PNG of `pixels_per_unit` pixels for every unit of the SVG.
///
/// # Errors
/// The text is not SVG, or the picture would be empty or a side longer than 16384 pixels.
pub fn png(svg: &str, pixels_per_unit: f32) -> Result<Vec<u8>, PlotError> {
    // On white nothing is transparent.
    let pixels = pixels(svg, pixels_per_unit, Color::WHITE)?;
    let rgb: Vec<u8> =
        pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    Ok(pack([pixels.width(), pixels.height()], &rgb, None))
}

/// Renders SVG text on a transparent ground, a pixel for every unit.
pub(crate) fn layer(svg: &str) -> Result<Pixmap, PlotError> {
    pixels(svg, 1.0, Color::TRANSPARENT)
}

/// The shapes of SVG text, with the contained font.
pub(super) fn tree(svg: &str) -> Result<Tree, PlotError> {
    let options = Options {
        fontdb: Arc::clone(&FONTS),
        font_resolver: FontResolver {
            select_font: Box::new(|_, fonts| fonts.faces().next().map(|face| face.id)),
            select_fallback: Box::new(|_, _, _| None),
        },
        ..Options::default()
    };
    Ok(Tree::from_str(svg, &options)?)
}

fn pixels(svg: &str, pixels_per_unit: f32, background: Color) -> Result<Pixmap, PlotError> {
    let tree = tree(svg)?;
    let [width, height] =
        [tree.size().width(), tree.size().height()].map(|units| (units * pixels_per_unit).ceil());
    let size_error = PlotError::Size { width, height, most: MOST_PIXELS };
    // NaN fails, too.
    if ![width, height].iter().all(|side| (1.0..=MOST_PIXELS).contains(side)) {
        return Err(size_error);
    }
    let mut pixels = Pixmap::new(width as u32, height as u32).ok_or(size_error)?;
    pixels.fill(background);
    resvg::render(
        &tree,
        Transform::from_scale(pixels_per_unit, pixels_per_unit),
        &mut pixels.as_mut(),
    );
    Ok(pixels)
}

/// Packs RGB as PNG, with the size of a pixel in it, if there is one.
pub(crate) fn pack([width, height]: [u32; 2], rgb: &[u8], pixel_um: Option<f64>) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut file, width, height);
    encoder.set_color(::png::ColorType::Rgb);
    // Pictures of few colours are smaller without a filter.
    encoder.set_deflate_compression(::png::DeflateCompression::Level(3));
    encoder.set_filter(::png::Filter::NoFilter);
    let pixels_per_metre = pixel_um.map(|um| (1e6 / um) as u32);
    encoder.set_pixel_dims(pixels_per_metre.map(|per_metre| ::png::PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: ::png::Unit::Meter,
    }));
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(rgb));
    written.expect("writing to memory does not fail");
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(content: &str) -> Vec<u8> {
        let svg = format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='60' height='30'>{content}</svg>"
        );
        let bytes = png(&svg, 2.0).unwrap();
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().height), (120, 60));
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    }

    #[test]
    fn text_of_any_family_is_drawn_with_the_carried_font() {
        let text =
            |family| picture(&format!("<text x='5' y='20' font-family='{family}'>0.5 µm</text>"));
        assert!(text("Ubuntu").iter().any(|&p| p < 128), "no ink");
        assert_eq!(text("Ubuntu"), text("no such family"));
    }

    #[test]
    fn what_is_not_drawn_is_white() {
        assert!(picture("").iter().all(|&p| p == 255));
    }

    #[test]
    fn impossible_sizes_are_errors() {
        let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='60' height='30'/>";
        for pixels_per_unit in [0.0, -1.0, 1000.0, f32::NAN, f32::INFINITY] {
            let error = png(svg, pixels_per_unit).unwrap_err();
            assert!(matches!(error, PlotError::Size { .. }), "{pixels_per_unit}: {error}");
        }
        assert!(matches!(png("no svg", 1.0).unwrap_err(), PlotError::Svg(_)));
    }
}
