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
/// Longest side of the image, pixels: with margins and caption the longest picture that can be made.
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
        let (least, most) = stretch(values);
        let pixel = |value: &f32| {
            if value.is_nan() {
                UNKNOWN
            } else {
                ramp((f64::from(*value) - least) / (most - least))
            }
        };
        let pixels: Vec<[u8; 3]> = values.iter().map(pixel).collect();
        self.write(&pixels, path, |svg, [left, top, width]| {
            svg.text((left, top + 16.0), Anchor::Start, TEXT, &format!("{}: {what}", self.title));
            let steps = 128;
            for step in 0..steps {
                let share = f64::from(step) / f64::from(steps);
                let [r, g, b] = ramp(share);
                let style = format!("fill='rgb({r},{g},{b})'");
                let x = left + share * width;
                svg.rectangle((x, top + 24.0), (width / f64::from(steps) + 0.5, 10.0), &style);
            }
            for (share, anchor) in [(0.0, Anchor::Start), (0.5, Anchor::Middle), (1.0, Anchor::End)]
            {
                let text = format!("{:.digits$} {unit}", least + share * (most - least));
                svg.text((left + share * width, top + 50.0), anchor, TEXT, &text);
            }
        })
    }

    /// Apparent emissivity in three bands as red, green and blue, each with its own scale.
    pub(super) fn false_colour(
        &self,
        channels: &[Vec<f32>; 3],
        names: &[String; 3],
        path: &Path,
    ) -> Result<(), Error> {
        let scales = [0, 1, 2].map(|i| stretch(&channels[i]));
        let pixels: Vec<[u8; 3]> = (0..channels[0].len())
            .map(|at| {
                if channels.iter().any(|channel| channel[at].is_nan()) {
                    return UNKNOWN;
                }
                [0, 1, 2].map(|i| {
                    let (least, most) = scales[i];
                    let share = (f64::from(channels[i][at]) - least) / (most - least);
                    (255.0 * share.clamp(0.0, 1.0)).round() as u8
                })
            })
            .collect();
        self.write(&pixels, path, |svg, [left, top, width]| {
            let text =
                format!("{}: apparent emissivity (Eq. 3), each colour stretched", self.title);
            svg.text((left, top + 16.0), Anchor::Start, TEXT, &text);
            let colours = ["#b01515", "#137a1b", "#1c36c4"];
            for (i, ((name, (least, most)), colour)) in
                names.iter().zip(scales).zip(colours).enumerate()
            {
                let x = left + width * i as f64 / 3.0;
                let style = format!("fill='{colour}'");
                svg.styled_text((x, top + 36.0), Anchor::Start, TEXT, name, &style);
                let text = format!("{least:.3} to {most:.3}");
                svg.styled_text((x, top + 52.0), Anchor::Start, TEXT, &text, &style);
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
        let pixels: Vec<[u8; 3]> = values.iter().map(pixel).collect();
        self.write(&pixels, path, |svg, [left, top, width]| {
            let text = format!("{}: the material that fills most of each pixel", self.title);
            svg.text((left, top + 16.0), Anchor::Start, TEXT, &text);
            for (i, name) in names.iter().enumerate() {
                let [r, g, b] = of(i);
                let x = left + width * i as f64 / names.len() as f64;
                let style = format!("fill='rgb({r},{g},{b})' stroke='#1a1a1a'");
                svg.rectangle((x, top + 30.0), (14.0, 14.0), &style);
                svg.text((x + 20.0, top + 43.0), Anchor::Start, TEXT, name);
            }
        })
    }

    /// Writes the pixels enlarged by a whole factor, with a caption below. The caption gets its left,
    /// its top and its width.
    fn write(
        &self,
        pixels: &[[u8; 3]],
        path: &Path,
        caption: impl FnOnce(&mut Svg, [f64; 3]),
    ) -> Result<(), Error> {
        let lines = pixels.len() / self.columns;
        // Of a larger image only every n-th pixel is drawn.
        let longest = lines.max(self.columns);
        let times = LEAST_WIDTH.div_ceil(self.columns).min(MOST_SIDE / longest).max(1);
        let coarser = longest.div_ceil(MOST_SIDE);
        let [width, height] = [self.columns, lines].map(|side| side.div_ceil(coarser) * times);
        let mut image = Canvas::new(width, height, UNKNOWN);
        for (at, rgb) in image.rgb.chunks_exact_mut(3).enumerate() {
            let [x, y] = [at % width, at / width].map(|at| at / times * coarser);
            rgb.copy_from_slice(&pixels[y * self.columns + x]);
        }
        let size = [image.width + 2 * MARGIN, image.height + 2 * MARGIN + CAPTION];
        let mut canvas = Canvas::new(size[0], size[1], [255; 3]);
        canvas.paste((MARGIN, MARGIN), &image);
        let room = [MARGIN, 2 * MARGIN + image.height, image.width].map(|px| px as f64);
        canvas.annotate(|svg| caption(svg, [room[0], room[1] - 6.0, room[2]]))?;
        Ok(output::bytes(path, &canvas.png(None))?)
    }
}

/// The ends of a scale.
fn stretch(values: &[f32]) -> (f64, f64) {
    let mut known: Vec<f32> = values.iter().copied().filter(|value| !value.is_nan()).collect();
    known.sort_by(f32::total_cmp);
    let Some(last) = known.len().checked_sub(1) else { return (0.0, 1.0) };
    let at = |share: f64| f64::from(known[(share * last as f64).round() as usize]);
    let (least, most) = (at(BEYOND), at(1.0 - BEYOND));
    if most > least { (least, most) } else { (least - 0.5, least + 0.5) }
}

fn ramp(share: f64) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let below = (at as usize).min(RAMP.len() - 2);
    [0, 1, 2].map(|i| {
        let (a, b) = (RAMP[below][i], RAMP[below + 1][i]);
        (a + (at - below as f64) * (b - a)).round() as u8
    })
}
