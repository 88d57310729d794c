//! From a stage to pixels.

use glam::DVec3;

use super::camera::Camera;
use super::canvas::{Canvas, linear};
use super::light::Lights;
use super::stage::{Piece, Stage};
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
    Ok(Lit::new(stage, stage, camera, width, style)?.coloured(style.background, style.colour))
}

/// What a picture shows, and the light on it.
pub(super) struct Lit {
    width: usize,
    height: usize,
    pixel_um: f64,
    pieces: Vec<Piece>,
    /// On each piece.
    light: Vec<f32>,
}

impl Lit {
    /// Looks at a stage; `shades` is what throws shadows on it.
    pub(super) fn new(
        stage: &Stage,
        shades: &Stage,
        camera: &Camera,
        width: usize,
        style: &Style,
    ) -> Result<Self, Error> {
        let [width_um, height_um] = camera.size_um();
        let pixel_um = width_um.max(height_um / HIGHEST) / width as f64;
        let [width, height] =
            [width_um, height_um].map(|um| ((um / pixel_um).round() as usize).max(1));
        let pieces = stage.look(camera, [width, height], style.rays, style.monitor)?;
        let lights = Lights::new(camera, style.zenith, style.sky);
        let light = lights.on(&pieces, shades, pixel_um, style.monitor)?;
        Ok(Self { width, height, pixel_um, pieces, light })
    }

    /// The same in half as many pixels along each side.
    pub(super) fn halved(mut self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        for piece in &mut self.pieces {
            let (x, y) = (piece.pixel % self.width, piece.pixel / self.width);
            let pixels =
                [(x, self.width), (y, self.height)].map(|(at, of)| (of - at / 2 * 2).min(2));
            piece.pixel = y / 2 * width + x / 2;
            piece.share /= (pixels[0] * pixels[1]) as f32;
        }
        Self { width, height, pixel_um: 2.0 * self.pixel_um, ..self }
    }

    /// The picture with a colour for each material; levels of sRGB, 0 to 1.
    pub(super) fn coloured(
        &self,
        background: [f32; 3],
        colour: impl Fn(usize) -> [f32; 3],
    ) -> Rendered {
        let &Self { width, height, pixel_um, .. } = self;
        let background = background.map(linear);
        let mut pixels = vec![background; width * height];
        let mut shares: Vec<f64> = Vec::new();
        let mut colours: Vec<[f32; 3]> = Vec::new();
        for (piece, &light) in self.pieces.iter().zip(&self.light) {
            let material = usize::from(piece.material);
            while colours.len() <= material {
                colours.push(colour(colours.len()).map(linear));
                shares.push(0.0);
            }
            let pixel = &mut pixels[piece.pixel];
            for ((sum, colour), background) in
                pixel.iter_mut().zip(colours[material]).zip(background)
            {
                *sum += piece.share * ((light * colour).min(1.0) - background);
            }
            shares[material] += f64::from(piece.share) / (width * height) as f64;
        }
        Rendered { canvas: Canvas::of_light(width, height, &pixels), pixel_um, shares }
    }
}
