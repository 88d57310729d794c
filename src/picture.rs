//! The patch as the sensor sees it.

use std::path::Path;

use rayon::prelude::*;

use crate::error::Error;
use crate::interrupt;
use crate::output;
use crate::tracer::Tracer;

/// Pixels along the longer side.
const LONGER_SIDE: u32 = 640;
/// Rays along each side of a pixel.
const RAYS: u32 = 2;
/// Colours of the materials in their order, and again from the first: pale dust, amber grain, grey
/// floor first, since shipped scenes have them so.
const COLOURS: [[f64; 3]; 6] = [
    [0.93, 0.88, 0.78],
    [0.76, 0.52, 0.27],
    [0.35, 0.36, 0.40],
    [0.45, 0.62, 0.55],
    [0.55, 0.50, 0.72],
    [0.80, 0.45, 0.45],
];
const SKY: [f64; 3] = [0.12, 0.15, 0.20];

/// Draws what the sensor sees, each facet in its material's colour and shaded by its slope,
/// as PNG with a scale bar of a whole number of millimetres or tenths.
pub fn write(tracer: &Tracer, path: &Path) -> Result<(), Error> {
    let [dx, dy] = tracer.view_um();
    let pixel_um = dx.max(dy) / f64::from(LONGER_SIDE);
    let pixels = |um: f64| ((um / pixel_um).round() as u32).max(1);
    let (width, height) = (pixels(dx), pixels(dy));
    let mut rows = (0..height)
        .into_par_iter()
        .map(|row| {
            if interrupt::requested() {
                return Err(Error::Interrupted);
            }
            let mut pixels = Vec::with_capacity(3 * width as usize);
            for column in 0..width {
                let mut sum = [0.0; 3];
                for ray in 0..RAYS * RAYS {
                    let place = |i: u32, sub: u32, of: u32| {
                        (f64::from(i) + (f64::from(sub) + 0.5) / f64::from(RAYS)) / f64::from(of)
                    };
                    let x = place(column, ray % RAYS, width);
                    let y = 1.0 - place(row, ray / RAYS, height);
                    let (colour, light) = match tracer.look([x, y]) {
                        Some((material, cosine)) => {
                            (COLOURS[usize::from(material) % COLOURS.len()], 0.25 + 0.75 * cosine)
                        }
                        None => (SKY, 1.0),
                    };
                    for (sum, channel) in sum.iter_mut().zip(colour) {
                        *sum += channel * light / f64::from(RAYS * RAYS);
                    }
                }
                pixels.extend(sum.map(|channel| (255.0 * channel).round() as u8));
            }
            Ok(pixels)
        })
        .collect::<Result<Vec<_>, Error>>()?
        .concat();
    scale_bar(&mut rows, width, height, pixel_um);
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: (1e6 / pixel_um) as u32,
        yppu: (1e6 / pixel_um) as u32,
        unit: png::Unit::Meter,
    }));
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&rows));
    written.expect("writing to memory does not fail");
    output::bytes(path, &file)?;
    Ok(())
}

/// A white bar on black in the lower left corner: the greatest power of ten um that is not longer
/// than a third of the picture.
fn scale_bar(rows: &mut [u8], width: u32, height: u32, pixel_um: f64) {
    let length_um = 10f64.powf((f64::from(width) * pixel_um / 3.0).log10().floor());
    let length = (length_um / pixel_um).round() as u32;
    let (left, bottom, thick, edge) = (16, height.saturating_sub(16), 6, 2);
    for y in bottom.saturating_sub(thick + 2 * edge)..bottom {
        for x in left..(left + length + 2 * edge).min(width) {
            let inside = (left + edge..left + edge + length).contains(&x)
                && (bottom - thick - edge..bottom - edge).contains(&y);
            let at = 3 * (y * width + x) as usize;
            rows[at..at + 3].fill(if inside { 255 } else { 0 });
        }
    }
}
