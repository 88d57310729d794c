//! The pixels of a picture.

use rayon::prelude::*;

use crate::draw::plot::axis::round_below;
use crate::draw::plot::svg::{Anchor, Svg, text_width};
use crate::draw::plot::{self, PlotError};
use crate::support::math;

/// Size of text, pixels.
pub(crate) const TEXT: f64 = 15.0;
/// Between panels, pixels.
pub(super) const GAP: usize = 8;
/// Levels of each colour. They look like 256, and the file is half as large.
const LEVELS: f32 = 48.0;

/// A picture: 8-bit red, green and blue, row by row from the top.
#[derive(Debug, Clone)]
pub(crate) struct Canvas {
    pub width: usize,
    pub height: usize,
    pub rgb: Vec<u8>,
}

impl Canvas {
    /// A picture of one colour.
    pub fn new(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, height, rgb: colour.repeat(width * height) }
    }

    /// From linear light, 1 for white.
    pub fn of_light(width: usize, height: usize, light: &[[f32; 3]]) -> Self {
        let level = |channel| {
            let level = ((LEVELS - 1.0) * encoded(channel)).round() / (LEVELS - 1.0);
            (255.0 * level).round() as u8
        };
        let rgb: Vec<[u8; 3]> = light.par_iter().map(|pixel| pixel.map(level)).collect();
        Self { width, height, rgb: rgb.into_flattened() }
    }

    /// Panels of one size side by side, with white below them.
    pub fn side_by_side(panels: &[&Self], below: usize) -> Self {
        let Self { width, height, .. } = *panels[0];
        let total = panels.len() * (width + GAP) - GAP;
        let mut all = Self::new(total, height + below, [255; 3]);
        for (i, panel) in panels.iter().enumerate() {
            all.paste((i * (width + GAP), 0), panel);
        }
        all
    }

    /// Lays a picture over this one with its upper left corner at (x, y). It must lie within.
    pub fn paste(&mut self, (x, y): (usize, usize), picture: &Self) {
        for (row, pixels) in picture.rgb.chunks(3 * picture.width).enumerate() {
            let at = 3 * ((y + row) * self.width + x);
            self.rgb[at..at + pixels.len()].copy_from_slice(pixels);
        }
    }

    /// Draws shapes and texts over the picture.
    pub fn annotate(&mut self, draw: impl FnOnce(&mut Svg)) -> Result<(), PlotError> {
        let mut svg = Svg::clear(self.width as f64, self.height as f64, "");
        draw(&mut svg);
        let layer = plot::layer(&svg.finish())?;
        for (under, over) in self.rgb.chunks_mut(3).zip(layer.pixels()) {
            let through = 255 - u16::from(over.alpha());
            for (under, over) in under.iter_mut().zip([over.red(), over.green(), over.blue()]) {
                *under = (u16::from(*under) * through / 255) as u8 + over;
            }
        }
        Ok(())
    }

    /// The PNG file, with the size of a pixel in it, if there is one.
    pub fn png(&self, pixel_um: Option<f64>) -> Vec<u8> {
        plot::pack([self.width as u32, self.height as u32], &self.rgb, pixel_um)
    }
}

/// Linear light as a level of sRGB, 0 to 1.
fn encoded(light: f32) -> f32 {
    let light = light.clamp(0.0, 1.0);
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * math::powf(light, 1.0 / 2.4) - 0.055 }
}

/// A level of sRGB, 0 to 1, as linear light.
pub(crate) fn linear(level: f32) -> f32 {
    if level <= 0.040_45 { level / 12.92 } else { math::powf((level + 0.055) / 1.055, 2.4) }
}

/// What a scale bar is drawn on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Ground {
    /// White.
    Paper,
    /// Any colours: the bar gets a dark plate.
    Picture,
}

/// A scale bar of at most a quarter of a width, with its length above it. Its lower left corner is
/// at (x, y).
pub(super) fn scale_bar(
    svg: &mut Svg,
    (x, y): (f64, f64),
    width_px: usize,
    pixel_um: f64,
    ground: Ground,
) {
    let um = round_below(width_px as f64 * pixel_um / 4.0);
    let length = um / pixel_um;
    let label = if um >= 1000.0 { format!("{} mm", um / 1000.0) } else { format!("{um} µm") };
    let wide = length.max(text_width(&label, TEXT));
    let (ink, left, bottom) = match ground {
        Ground::Paper => ("fill='#1a1a1a'", x, y),
        Ground::Picture => {
            let style = "rx='3' fill='#000000' fill-opacity='0.6'";
            svg.rectangle((x, y - 34.0), (wide + 16.0, 34.0), style);
            ("fill='#ffffff'", x + 8.0, y - 6.0)
        }
    };
    svg.rectangle((left + (wide - length) / 2.0, bottom - 4.0), (length, 4.0), ink);
    svg.styled_text((left + wide / 2.0, bottom - 10.0), Anchor::Middle, TEXT, &label, ink);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_paper_stays_white_and_colours_come_back() {
        let levels = [[1.0; 3], [0.0; 3], [0.92, 0.48, 0.2]];
        let canvas = Canvas::of_light(3, 1, &levels.map(|pixel| pixel.map(linear)));
        assert_eq!(canvas.rgb[..6], [255, 255, 255, 0, 0, 0]);
        for (&is, wanted) in canvas.rgb[6..].iter().zip(levels[2]) {
            assert!((f32::from(is) / 255.0 - wanted).abs() < 0.6 / LEVELS, "{is} {wanted}");
        }
    }
}
