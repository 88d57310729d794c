//! From a stage to pixels.

use glam::DVec3;

use super::camera::Camera;
use super::canvas::{Canvas, linear};
use super::light::Lights;
use super::stage::Stage;
use crate::support::error::Error;
use crate::support::monitor::Monitor;

/// Colours of the materials in their order, and again from the first: pale dust, amber grain, grey
/// floor first, since shipped scenes have them so. Levels of sRGB.
const COLOURS: [[f32; 3]; 6] = [
    [0.92, 0.88, 0.79],
    [0.76, 0.48, 0.20],
    [0.40, 0.42, 0.46],
    [0.45, 0.62, 0.55],
    [0.55, 0.50, 0.72],
    [0.80, 0.45, 0.45],
];

/// How a picture is drawn.
pub(super) struct Style<'a> {
    /// Rays along each side of a pixel.
    pub rays: usize,
    /// Directions from which the sky shines.
    pub sky: usize,
    /// Middle of the sky.
    pub zenith: DVec3,
    /// Where nothing is; levels of sRGB, 0 to 1.
    pub background: [f32; 3],
    /// Whoever may stop it.
    pub monitor: &'a dyn Monitor,
}

/// Pixels, and what they show.
pub(super) struct Rendered {
    pub canvas: Canvas,
    pub pixel_um: f64,
    /// Share of the picture that each material fills.
    pub shares: Vec<f64>,
}

/// The colour of a material, levels of sRGB, 0 to 1.
pub(crate) fn colour(material: usize) -> [f32; 3] {
    COLOURS[material % COLOURS.len()]
}

/// A picture is at most so many times as high as it may be wide.
const HIGHEST: f64 = 4.0;

/// Draws a stage, so many pixels wide; narrower what is very high.
pub(super) fn render(
    stage: &Stage,
    camera: &Camera,
    width: usize,
    style: &Style,
) -> Result<Rendered, Error> {
    let [width_um, height_um] = camera.size_um();
    let pixel_um = width_um.max(height_um / HIGHEST) / width as f64;
    let [width, height] = [width_um, height_um].map(|um| ((um / pixel_um).round() as usize).max(1));
    let pieces = stage.look(camera, [width, height], style.rays, style.monitor)?;
    let lights = Lights::new(camera, style.zenith, style.sky);
    let light = lights.on(&pieces, stage, pixel_um, style.monitor)?;
    let background = style.background.map(linear);
    let mut pixels = vec![background; width * height];
    let mut shares: Vec<f64> = Vec::new();
    for (piece, light) in pieces.iter().zip(light) {
        let material = usize::from(piece.material);
        let colour = colour(material).map(|level| (light * linear(level)).min(1.0));
        let pixel = &mut pixels[piece.pixel];
        for ((sum, colour), background) in pixel.iter_mut().zip(colour).zip(background) {
            *sum += piece.share * (colour - background);
        }
        if shares.len() <= material {
            shares.resize(material + 1, 0.0);
        }
        shares[material] += f64::from(piece.share) / (width * height) as f64;
    }
    Ok(Rendered { canvas: Canvas::of_light(width, height, &pixels), pixel_um, shares })
}
