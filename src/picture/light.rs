//! Sun and sky: how much light reaches each piece of surface.
//!
//! The sky is many directions evenly over the upper hemisphere, the sun one more. What each of them
//! reaches is what it sees, found like what the camera sees: by a depth buffer.

use glam::{Affine3A, DVec3, Vec3, Vec3A};
use rayon::prelude::*;

use super::camera::Camera;
use super::stage::{Piece, Stage};
use super::visible::{Body, Scratch, Window};
use crate::error::Error;
use crate::interrupt;

/// Shares of the light on a level surface in the open.
const SUN: f64 = 0.55;
const SKY: f64 = 0.45;
/// What reaches every surface: light reflected by others.
const STRAY: f32 = 0.06;
/// Directions whose depth buffers are held at a time.
const AT_A_TIME: usize = 8;
/// Most pixels along a side of a depth buffer.
const LONGEST: f64 = 2048.0;

/// Where the light comes from.
pub(crate) struct Lights(Vec<Light>);

struct Light {
    towards: DVec3,
    strength: f64,
}

impl Lights {
    /// A sun and a sky of so many directions.
    pub fn new(sun: DVec3, sky: usize) -> Self {
        // The golden section spreads points evenly, and never two above each other.
        let golden = (5f64.sqrt() - 1.0) / 2.0;
        let sky_light = |i: usize| {
            let z = (i as f64 + 0.5) / sky as f64;
            let (sin, cos) = (std::f64::consts::TAU * golden * i as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Light { towards: DVec3::new(r * cos, r * sin, z), strength: 2.0 * SKY / sky as f64 }
        };
        let sun = Light { towards: sun, strength: SUN / sun.z };
        Self(std::iter::once(sun).chain((0..sky).map(sky_light)).collect())
    }

    /// Light on each piece, 1 on a level surface in the open. `pixel_um` is the detail that shadows have.
    pub fn on(&self, pieces: &[Piece], stage: &Stage, pixel_um: f64) -> Result<Vec<f32>, Error> {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for piece in pieces {
            (min, max) = (min.min(piece.point), max.max(piece.point));
        }
        let corners = |i: usize| {
            let high = glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0);
            DVec3::select(high, max, min)
        };
        let mut sums = vec![STRAY; pieces.len()];
        let bodies: Vec<&Body> = stage.bodies(f64::INFINITY).collect();
        for lights in self.0.chunks(AT_A_TIME) {
            let maps: Vec<Map> = lights
                .par_iter()
                .map(|light| {
                    if interrupt::requested() {
                        return Err(Error::Interrupted);
                    }
                    let camera = Camera::around((0..8).map(corners), light.towards);
                    Ok(Map::new(light, &camera.widened(2.0 * pixel_um), &bodies, pixel_um))
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

/// How far the light of one direction goes.
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
    fn new(light: &Light, camera: &Camera, bodies: &[&Body], pixel_um: f64) -> Self {
        let [w, h] = camera.size_um();
        let pixel_um = pixel_um.max(w / LONGEST).max(h / LONGEST);
        let (width, height) = ((w / pixel_um).ceil() as usize, (h / pixel_um).ceil() as usize);
        let to_pixels = camera.to_pixels(width, height);
        let window = Window { width, rows: 0..height };
        let mut depth = vec![f32::INFINITY; width * height];
        let mut scratch = Scratch::new();
        for body in bodies {
            body.draw(&to_pixels, &window, &mut scratch, |at, t, _| depth[at] = depth[at].min(t));
        }
        // Single precision holds places near the corner.
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
        // A pixel holds the depth of its middle: stand off the surface by as much as a facet rises in one.
        let point = (piece.point - self.origin).as_vec3() + self.pixel_um * piece.normal;
        let at = self.to_pixels.transform_point3a(Vec3A::from(point));
        let (x, y) = (at.x - 0.5, at.y - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let (u, v) = (x - column, y - row);
        let depth = at.z - 0.5 * self.pixel_um;
        let lit = |dx: f32, dy: f32| {
            let (x, y) = (column + dx, row + dy);
            let inside = x >= 0.0 && y >= 0.0 && x < self.width as f32 && y < self.height as f32;
            let free = !inside || depth <= self.depth[y as usize * self.width + x as usize];
            f32::from(u8::from(free))
        };
        let above = lit(0.0, 0.0) * (1.0 - u) + lit(1.0, 0.0) * u;
        let below = lit(0.0, 1.0) * (1.0 - u) + lit(1.0, 1.0) * u;
        self.strength * cosine * (above * (1.0 - v) + below * v)
    }
}
