//! SVG to PNG with the carried font.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{FontResolver, Options, Tree, fontdb};

use super::PlotError;

/// Beyond this a picture would take gigabytes.
const MOST_PIXELS: f32 = 16_384.0;

/// One face only, chosen whatever the text asks for: no font of the machine can change a picture.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    let face: Arc<&'static [u8]> = Arc::new(epaint_default_fonts::UBUNTU_LIGHT);
    fonts.load_font_source(fontdb::Source::Binary(face));
    Arc::new(fonts)
});

/// Renders SVG text as a PNG of `pixels_per_unit` pixels for every unit of the SVG.
///
/// # Errors
/// The text is no SVG, or the picture would be empty or larger than 16384 pixels a side.
pub fn png(svg: &str, pixels_per_unit: f32) -> Result<Vec<u8>, PlotError> {
    pack(&pixels(svg, pixels_per_unit, Color::WHITE)?)
}

/// Renders SVG text, a pixel for every unit, over nothing.
pub(crate) fn layer(svg: &str) -> Result<Pixmap, PlotError> {
    pixels(svg, 1.0, Color::TRANSPARENT)
}

fn pixels(svg: &str, pixels_per_unit: f32, background: Color) -> Result<Pixmap, PlotError> {
    let options = Options {
        fontdb: Arc::clone(&FONTS),
        font_resolver: FontResolver {
            select_font: Box::new(|_, fonts| fonts.faces().next().map(|face| face.id)),
            select_fallback: Box::new(|_, _, _| None),
        },
        ..Options::default()
    };
    let tree = Tree::from_str(svg, &options)?;
    let [width, height] =
        [tree.size().width(), tree.size().height()].map(|units| (units * pixels_per_unit).ceil());
    let size_error = PlotError::Size { width, height, most: MOST_PIXELS };
    // Written so that NaN fails too.
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

/// The pixels as RGB: on white nothing is transparent.
fn pack(pixels: &Pixmap) -> Result<Vec<u8>, PlotError> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(::png::ColorType::Rgb);
    let rgb: Vec<u8> =
        pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
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
