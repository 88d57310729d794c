//! Quick-looks of an image as PNG.

use std::path::Path;

use crate::draw::picture::canvas::Canvas;
use crate::draw::picture::render::colour;
use crate::draw::plot::svg::{Anchor, Svg};
use crate::support::error::Error;
use crate::support::output;

/// Least width of the image in a picture, pixels.
const LEAST_WIDTH: usize = 512;
/// White margin, pixels.
const MARGIN: usize = 12;
/// Height of the caption, pixels.
const CAPTION: usize = 58;
/// Longest side of the image, pixels. Margins and caption make it the longest possible picture.
const MOST_SIDE: usize = 16_200;
const TEXT: f64 = 14.0;
/// The scale leaves out this share of the numbers at each end.
const BEYOND: f64 = 0.01;
/// Colour of unknown numbers.
const UNKNOWN: [u8; 3] = [30, 38, 51];

/// From dark to bright: every 32nd colour of matplotlib's inferno (public domain, CC0).
const RAMP: [[f64; 3]; 9] = [
    [0.0, 0.0, 4.0],
    [31.0, 12.0, 72.0],
    [85.0, 15.0, 109.0],
    [136.0, 34.0, 106.0],
    [186.0, 54.0, 85.0],
    [227.0, 89.0, 51.0],
    [249.0, 140.0, 10.0],
    [249.0, 201.0, 50.0],
    [252.0, 255.0, 164.0],
];

/// The width and the title of an image.
pub(super) struct Look<'a> {
    pub columns: usize,
    pub title: &'a str,
}

impl Look<'_> {
    /// One number per pixel as a colour, with a scale below.
    pub(super) fn scaled(
        &self,
        values: &[f32],
        what: &str,
        unit: &str,
        digits: usize,
        path: &Path,
    ) -> Result<(), Error> {
        let scale = Scale::of(values);
        let pixel = |value: &f32| if value.is_nan() { UNKNOWN } else { ramp(scale.share(*value)) };
        self.write(
            &values.iter().map(pixel).collect::<Vec<_>>(),
            what,
            path,
            |svg, [left, top, width]| {
                let steps = 128;
                for step in 0..steps {
                    let share = f64::from(step) / f64::from(steps);
                    let x = left + share * width;
                    let style = fill(ramp(share));
                    svg.rectangle((x, top + 24.0), (width / f64::from(steps) + 0.5, 10.0), &style);
                }
                for (share, anchor) in
                    [(0.0, Anchor::Start), (0.5, Anchor::Middle), (1.0, Anchor::End)]
                {
                    let text = format!("{:.digits$} {unit}", scale.least + share * scale.range);
                    svg.text((left + share * width, top + 50.0), anchor, TEXT, &text);
                }
            },
        )
    }

    /// Apparent emissivity in three bands as red, green and blue, each with its own scale.
    pub(super) fn false_colour(
        &self,
        channels: &[Vec<f32>; 3],
        names: &[String; 3],
        path: &Path,
    ) -> Result<(), Error> {
        let scales = [0, 1, 2].map(|i| Scale::of(&channels[i]));
        let pixel = |at: usize| {
            let values = [0, 1, 2].map(|i| channels[i][at]);
            if values.iter().any(|value| value.is_nan()) {
                return UNKNOWN;
            }
            [0, 1, 2].map(|i| (255.0 * scales[i].share(values[i])).round() as u8)
        };
        let pixels: Vec<[u8; 3]> = (0..channels[0].len()).map(pixel).collect();
        let what = "apparent emissivity (Eq. 3), each colour stretched";
        self.write(&pixels, what, path, |svg, [left, top, width]| {
            let colours = ["#b01515", "#137a1b", "#1c36c4"].map(|ink| format!("fill='{ink}'"));
            for (i, (name, Scale { least, range })) in names.iter().zip(&scales).enumerate() {
                let x = left + width * i as f64 / 3.0;
                let text = format!("{least:.3} to {:.3}", least + range);
                for (y, text) in [(top + 36.0, name), (top + 52.0, &text)] {
                    svg.styled_text((x, y), Anchor::Start, TEXT, text, &colours[i]);
                }
            }
        })
    }

    /// The material of each pixel, in the colours of `soilsig picture`.
    pub(super) fn materials(
        &self,
        values: &[f32],
        names: &[String],
        path: &Path,
    ) -> Result<(), Error> {
        let of = |material: usize| colour(material).map(|level| (255.0 * level).round() as u8);
        let pixel = |value: &f32| if value.is_nan() { UNKNOWN } else { of(*value as usize) };
        let what = "the material that fills most of each pixel";
        self.write(
            &values.iter().map(pixel).collect::<Vec<_>>(),
            what,
            path,
            |svg, [left, top, width]| {
                for (i, name) in names.iter().enumerate() {
                    let x = left + width * i as f64 / names.len() as f64;
                    let style = fill(of(i)) + " stroke='#1a1a1a'";
                    svg.rectangle((x, top + 30.0), (14.0, 14.0), &style);
                    svg.text((x + 20.0, top + 43.0), Anchor::Start, TEXT, name);
                }
            },
        )
    }

    /// Writes the pixels enlarged by a whole factor, with a caption below: a line of text, and what
    /// `caption` draws below it. It gets left, top and width.
    fn write(
        &self,
        pixels: &[[u8; 3]],
        what: &str,
        path: &Path,
        caption: impl FnOnce(&mut Svg, [f64; 3]),
    ) -> Result<(), Error> {
        let lines = pixels.len() / self.columns;
        // Of a larger image only every n-th pixel is drawn.
        let longest = lines.max(self.columns);
        let times = LEAST_WIDTH.div_ceil(self.columns).min(MOST_SIDE / longest).max(1);
        let coarser = longest.div_ceil(MOST_SIDE);
        let [width, height] = [self.columns, lines].map(|side| side.div_ceil(coarser) * times);
        let mut canvas = Canvas::new(width + 2 * MARGIN, height + 2 * MARGIN + CAPTION, [255; 3]);
        let rows = canvas.rgb.chunks_exact_mut(3 * (width + 2 * MARGIN)).skip(MARGIN).take(height);
        for (y, row) in rows.enumerate() {
            let of_line = &pixels[y / times * coarser * self.columns..][..self.columns];
            for (x, rgb) in row.chunks_exact_mut(3).skip(MARGIN).take(width).enumerate() {
                rgb.copy_from_slice(&of_line[x / times * coarser]);
            }
        }
        let [left, top, width] = [MARGIN, 2 * MARGIN + height - 6, width].map(|px| px as f64);
        canvas.annotate(|svg| {
            let text = format!("{}: {what}", self.title);
            svg.text((left, top + 16.0), Anchor::Start, TEXT, &text);
            caption(svg, [left, top, width]);
        })?;
        Ok(output::bytes(path, &canvas.png(None))?)
    }
}

/// A scale from the least to the greatest number, without extremes.
struct Scale {
    least: f64,
    range: f64,
}

impl Scale {
    fn of(values: &[f32]) -> Self {
        let mut known: Vec<f32> = values.iter().copied().filter(|value| !value.is_nan()).collect();
        known.sort_by(f32::total_cmp);
        let Some(last) = known.len().checked_sub(1) else { return Self { least: 0.0, range: 1.0 } };
        let at = |share: f64| f64::from(known[(share * last as f64).round() as usize]);
        let (least, most) = (at(BEYOND), at(1.0 - BEYOND));
        if most > least {
            Self { least, range: most - least }
        } else {
            Self { least: least - 0.5, range: 1.0 }
        }
    }

    /// 0 to 1 from the least to the greatest number.
    fn share(&self, value: f32) -> f64 {
        ((f64::from(value) - self.least) / self.range).clamp(0.0, 1.0)
    }
}

fn fill([r, g, b]: [u8; 3]) -> String {
    format!("fill='rgb({r},{g},{b})'")
}

fn ramp(share: f64) -> [u8; 3] {
    let at = share * (RAMP.len() - 1) as f64;
    let below = (at as usize).min(RAMP.len() - 2);
    [0, 1, 2].map(|i| {
        let (a, b) = (RAMP[below][i], RAMP[below + 1][i]);
        (a + (at - below as f64) * (b - a)).round() as u8
    })
}
