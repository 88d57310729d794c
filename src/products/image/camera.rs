//! The rays of each pixel.

use glam::DVec3;

use super::ImageError;
use crate::draw::picture::camera::level;
use crate::geometry::Bed;
use crate::scene::{Optics, Sensor, Sides};
use crate::support::math;
use crate::tracer::footprint::Footprint;

/// Pixels of a line without a sensor.
const COLUMNS: f64 = 256.0;

/// A focal plane before the bed.
pub(super) struct Camera {
    /// Columns and lines.
    pub pixels: [usize; 2],
    rays: Rays,
    to_sensor: DVec3,
    /// Top of the bed, um.
    top_um: f64,
}

enum Rays {
    Parallel(Footprint),
    /// From a point through a rectangle, given by its lower left corner and its sides from `point`.
    Through {
        point: DVec3,
        corner: DVec3,
        right: DVec3,
        up: DVec3,
    },
}

impl Camera {
    /// The camera of a sensor, else one that sees the domain in square pixels.
    pub(super) fn new(bed: &Bed, sensor: Option<&Sensor>) -> Result<Self, ImageError> {
        let (domain, to_sensor) = (&bed.domain, bed.to_sensor);
        let view = Footprint::new(domain, to_sensor);
        let lines = (COLUMNS * view.up.length() / view.right.length()).round().clamp(1.0, 16_384.0);
        let pixels = sensor.map_or([COLUMNS as u32, lines as u32], |sensor| sensor.pixels);
        let middle = (domain.min_um + domain.max_um) / 2.0;
        let (right, up) = level(to_sensor);
        let aspect = f64::from(pixels[1]) / f64::from(pixels[0]);
        let rays = match sensor.and_then(|sensor| sensor.optics) {
            None => Rays::Parallel(view),
            Some(Optics::Orthographic { width_um }) => {
                let (right, up) = (width_um * right, width_um * aspect * up);
                Rays::Parallel(Footprint { corner: middle - (right + up) / 2.0, right, up })
            }
            Some(Optics::Pinhole { distance_um, field_of_view_deg }) => {
                let point = middle + distance_um * to_sensor;
                let within = if domain.sides == Sides::Open {
                    point.cmpgt(domain.min_um).all() && point.cmplt(domain.max_um).all()
                } else {
                    point.z <= domain.max_um.z
                };
                if within {
                    let height_um = point.z - domain.max_um.z;
                    return Err(ImageError::Within { distance_um, height_um });
                }
                let width = 2.0 * math::tan(field_of_view_deg.to_radians() / 2.0);
                let (right, up) = (width * right, width * aspect * up);
                Rays::Through { point, corner: -to_sensor - (right + up) / 2.0, right, up }
            }
        };
        let pixels = pixels.map(|side| side as usize);
        Ok(Self { pixels, rays, to_sensor, top_um: domain.max_um.z })
    }

    /// Origin and direction of a ray. `place` is in the pixel, 0 to 1 from its left and upper edge.
    pub(super) fn ray(&self, [sample, line]: [usize; 2], place: [f64; 2]) -> (DVec3, DVec3) {
        let [columns, lines] = self.pixels.map(|side| side as f64);
        let u = (sample as f64 + place[0]) / columns;
        let v = 1.0 - (line as f64 + place[1]) / lines;
        match &self.rays {
            Rays::Parallel(view) => {
                let direction = -self.to_sensor;
                let start = view.at([u, v]);
                // From above everything: grains beyond an open domain may hide a part of it.
                let below_um = (self.top_um - start.z).max(0.0);
                (start + below_um / direction.z * direction, direction)
            }
            Rays::Through { point, corner, right, up } => {
                (*point, (corner + u * right + v * up).normalize())
            }
        }
    }

    /// Width and height of a pixel: um, or for a pinhole the difference of the angle's tangent.
    pub(super) fn pixel_size(&self) -> [f64; 2] {
        let (right, up) = match &self.rays {
            Rays::Parallel(view) => (view.right, view.up),
            Rays::Through { right, up, .. } => (*right, *up),
        };
        let [columns, lines] = self.pixels.map(|side| side as f64);
        [right.length() / columns, up.length() / lines]
    }

    /// Whether rays are parallel, so that pixels have a size in um.
    pub(super) fn is_parallel(&self) -> bool {
        matches!(self.rays, Rays::Parallel(_))
    }
}
