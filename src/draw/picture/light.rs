//! The light of sun and sky on each piece of surface.
//!
//! The sky is many directions evenly over the upper hemisphere, the sun one more. Depth buffers
//! tell what each direction lights, as they do for the camera.

use glam::{Affine3A, DVec3, Vec3, Vec3A};
use rayon::prelude::*;

use super::camera::{Camera, corners};
use super::stage::{Piece, Stage};
use super::visible::{Body, Scratch, Window};
use crate::support::math;
use crate::support::monitor::{Interrupted, Monitor};

/// Shares of the light on a horizontal surface in the open.
const SUN: f64 = 0.52;
const SKY: f64 = 0.45;
/// A lower sun is not made stronger; a cosine.
const LOWEST_SUN: f64 = 0.6;
/// Light reflected by other surfaces, equal everywhere.
const STRAY: f32 = 0.06;
/// Pixels of the picture in one of the sky's depth buffers: many shadows blur each other.
const SKY_DETAIL: f64 = 3.0;
/// Depth buffers held at a time.
const AT_A_TIME: usize = 8;
/// Most pixels of a side of a depth buffer.
const LONGEST: f64 = 2048.0;

/// All directions of light.
pub(crate) struct Lights(Vec<Light>);

struct Light {
    towards: DVec3,
    strength: f64,
    /// Pixels of the picture in one of its depth buffer.
    detail: f64,
}

impl Lights {
    /// A sun to the upper left behind the camera, and `sky` directions about a zenith.
    pub fn new(camera: &Camera, zenith: DVec3, sky: usize) -> Self {
        let (right, up) = (camera.right.normalize(), camera.up.normalize());
        let sun = (-0.55 * right + 0.35 * up + 0.75 * camera.to_eye).normalize();
        let sun =
            Light { towards: sun, strength: SUN / sun.dot(zenith).max(LOWEST_SUN), detail: 1.0 };
        // The golden section spreads points evenly.
        let golden = (5f64.sqrt() - 1.0) / 2.0;
        let (east, north) = zenith.any_orthonormal_pair();
        let sky_light = |i: usize| {
            let z = (i as f64 + 0.5) / sky as f64;
            let (sin, cos) = math::sin_cos(std::f64::consts::TAU * golden * i as f64);
            let r = (1.0 - z * z).sqrt();
            let towards = r * cos * east + r * sin * north + z * zenith;
            Light { towards, strength: 2.0 * SKY / sky as f64, detail: SKY_DETAIL }
        };
        Self(std::iter::once(sun).chain((0..sky).map(sky_light)).collect())
    }

    /// Light on each piece, 1 on a horizontal surface in the open. Shadows are exact to `pixel_um`.
    pub fn on(
        &self,
        pieces: &[Piece],
        stage: &Stage,
        pixel_um: f64,
        monitor: &dyn Monitor,
    ) -> Result<Vec<f32>, Interrupted> {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for piece in pieces {
            (min, max) = (min.min(piece.point), max.max(piece.point));
        }
        let mut sums = vec![STRAY; pieces.len()];
        let bodies: Vec<&Body> = stage.bodies(f64::INFINITY).collect();
        for lights in self.0.chunks(AT_A_TIME) {
            let maps: Vec<Map> = lights
                .par_iter()
                .map(|light| {
                    monitor.check()?;
                    let camera = Camera::around(corners([min, max]).into_iter(), light.towards);
                    Ok(Map::new(light, camera, &bodies, light.detail * pixel_um))
                })
                .collect::<Result<_, _>>()?;
            pieces.par_iter().zip(&mut sums).with_min_len(1024).for_each(|(piece, sum)| {
                for map in &maps {
                    *sum += map.on(piece);
                }
            });
        }
        Ok(sums)
    }
}

/// The depth buffer of one direction of light.
struct Map {
    towards: Vec3,
    strength: f32,
    to_pixels: Affine3A,
    origin: DVec3,
    width: usize,
    height: usize,
    pixel_um: f32,
    depth: Vec<f32>,
}

impl Map {
    fn new(light: &Light, camera: Camera, bodies: &[&Body], pixel_um: f64) -> Self {
        let [w, h] = camera.size_um();
        let pixel_um = pixel_um.max(w / LONGEST).max(h / LONGEST);
        let camera = camera.widened(3.0 * pixel_um);
        let [w, h] = camera.size_um();
        let (width, height) = ((w / pixel_um).ceil() as usize, (h / pixel_um).ceil() as usize);
        let to_pixels = camera.to_pixels(width, height);
        let window = Window { width, rows: 0..height };
        let mut depth = vec![f32::INFINITY; width * height];
        let mut scratch = Scratch::new();
        for body in bodies {
            body.draw(&to_pixels, &window, &mut scratch, |span| {
                let pixels = &mut depth[span.first..span.first + span.pixels];
                for (i, depth) in pixels.iter_mut().enumerate() {
                    *depth = depth.min(span.depth + i as f32 * span.slope);
                }
            });
        }
        // Relative to the corner, single precision is enough.
        let origin = camera.corner;
        Self {
            towards: light.towards.as_vec3(),
            strength: light.strength as f32,
            to_pixels: Affine3A::from_mat3_translation(
                to_pixels.matrix3.as_mat3(),
                to_pixels.transform_point3(origin).as_vec3(),
            ),
            origin,
            width,
            height,
            pixel_um: pixel_um as f32,
            depth,
        }
    }

    fn on(&self, piece: &Piece) -> f32 {
        let cosine = piece.normal.dot(self.towards);
        if cosine <= 0.0 {
            return 0.0;
        }
        // An offset of a pixel keeps a facet from shading itself.
        let point = (piece.point - self.origin).as_vec3() + self.pixel_um * piece.normal;
        let at = self.to_pixels.transform_point3a(Vec3A::from(point));
        // The map is wide enough that this changes only the last bit.
        let inside = |at: f32, pixels: usize| (at - 0.5).clamp(0.0, pixels as f32 - 1.001);
        let (x, y) = (inside(at.x, self.width), inside(at.y, self.height));
        let (column, row) = (x as usize, y as usize);
        let (u, v) = (x - column as f32, y - row as f32);
        let depth = at.z - 0.5 * self.pixel_um;
        let first = row * self.width + column;
        let lit = |at: usize| f32::from(u8::from(depth <= self.depth[at]));
        let above = lit(first) * (1.0 - u) + lit(first + 1) * u;
        let below = lit(first + self.width) * (1.0 - u) + lit(first + self.width + 1) * u;
        self.strength * cosine * (above * (1.0 - v) + below * v)
    }
}
