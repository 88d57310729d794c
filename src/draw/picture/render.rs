//! From a stage to pixels.

use glam::DVec3;

use super::camera::Camera;
use super::canvas::{Canvas, linear};
use super::light::Lights;
use super::stage::Stage;
use crate::support::error::Error;
use crate::support::monitor::Monitor;

/// Colours of the materials in their order, repeated: pale dust, amber grains and a grey floor in
/// shipped scenes. Levels of sRGB.
const COLOURS: [[f32; 3]; 6] = [
    [0.92, 0.88, 0.79],
    [0.76, 0.48, 0.20],
    [0.40, 0.42, 0.46],
    [0.45, 0.62, 0.55],
    [0.55, 0.50, 0.72],
    [0.80, 0.45, 0.45],
];

/// Behind a bed in the open; levels of sRGB, 0 to 1.
const PAPER: [f32; 3] = [1.0; 3];
/// Where the sensor meets nothing.
pub(super) const SPACE: [f32; 3] = [0.12, 0.15, 0.20];
/// Greatest ratio of a picture's height to its width.
const HIGHEST: f64 = 4.0;

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
    /// Colour of a material; levels of sRGB, 0 to 1.
    pub colour: fn(usize) -> [f32; 3],
    pub monitor: &'a dyn Monitor,
}

impl<'a> Style<'a> {
    /// On white paper.
    pub(super) fn new(monitor: &'a dyn Monitor) -> Self {
        Self { rays: 3, sky: 31, zenith: DVec3::Z, background: PAPER, colour, monitor }
    }
}

/// A picture and its scale.
pub(super) struct Rendered {
    pub canvas: Canvas,
    pub pixel_um: f64,
    /// Share of the picture that each material fills.
    pub shares: Vec<f64>,
}

/// The colour of a material; levels of sRGB, 0 to 1.
pub(crate) fn colour(material: usize) -> [f32; 3] {
    COLOURS[material % COLOURS.len()]
}

/// Draws a stage at that width; a very high one is narrower.
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
        let colour = (style.colour)(material).map(|level| (light * linear(level)).min(1.0));
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
