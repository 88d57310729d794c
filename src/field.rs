//! What becomes of a ray at the sides of the domain: how far the bed goes on beyond them.
//!
//! A ray is held in the coordinates of the domain's bed for its whole path. What changes at a side is
//! where in that bed it is and which way it goes.

use glam::DVec3;

use crate::geometry::{Bed, Domain};
use crate::scene::Sides;

/// Reflections at the domain's mirror sides between two hits after which a path is given up as
/// trapped: a level ray through an empty gap could go on for ever.
const MOST_MIRRORS: u32 = 10_000;

/// The bed as it goes on beyond the sides of its domain.
pub(crate) struct Field {
    domain: Domain,
    footprint: Footprint,
    to_sensor: DVec3,
}

/// A ray in the coordinates of the domain's bed.
pub(crate) struct Ray {
    pub(crate) origin: DVec3,
    /// Of length 1.
    pub(crate) direction: DVec3,
}

/// What a ray meets first; `H` is a hit on a mesh.
pub(crate) enum Meets<H> {
    Mesh(H),
    /// The floor. The normal is on the ray's side.
    Plane {
        material: u16,
        point: DVec3,
        normal: DVec3,
    },
    Sky {
        downward: bool,
    },
    Lost,
}

/// How a ray leaves the domain.
enum Exit {
    Sky,
    Floor(f64, u16),
    Mirror { axis: usize, at_um: f64 },
}

impl Field {
    pub(crate) fn new(bed: &Bed) -> Self {
        let footprint = Footprint::new(&bed.domain, bed.to_sensor);
        Self { domain: bed.domain.clone(), footprint, to_sensor: bed.to_sensor }
    }

    /// Width and height of the sensor's view, um.
    pub(crate) fn view_um(&self) -> [f64; 2] {
        [self.footprint.right.length(), self.footprint.up.length()]
    }

    /// The sensor's ray at a place of its view, 0 to 1 from the left and from below.
    pub(crate) fn start(&self, place: [f64; 2]) -> Ray {
        Ray { origin: self.footprint.at(place), direction: -self.to_sensor }
    }

    /// Follows a ray to what it meets first, through the mirrors at the domain's sides. `closest` gives
    /// the nearest hit on a mesh within a distance, um.
    pub(crate) fn follow<H>(
        &self,
        ray: &mut Ray,
        closest: impl Fn(&Ray, f64) -> Option<H>,
    ) -> Meets<H> {
        for _ in 0..MOST_MIRRORS {
            let (t_exit, exit) = self.exit(ray);
            if let Some(hit) = closest(ray, t_exit) {
                return Meets::Mesh(hit);
            }
            ray.origin += t_exit * ray.direction;
            match exit {
                Exit::Sky => return Meets::Sky { downward: ray.direction.z < 0.0 },
                Exit::Floor(z_um, material) => {
                    // The floor is above everything below it by decree: no lift is needed to stay off it.
                    let point = DVec3::new(ray.origin.x, ray.origin.y, z_um);
                    let normal = if ray.direction.z < 0.0 { DVec3::Z } else { -DVec3::Z };
                    return Meets::Plane { material, point, normal };
                }
                Exit::Mirror { axis, at_um } => {
                    ray.origin[axis] = at_um;
                    ray.direction[axis] = -ray.direction[axis];
                }
            }
        }
        Meets::Lost
    }

    /// Where a ray that meets no mesh leaves the domain.
    fn exit(&self, ray: &Ray) -> (f64, Exit) {
        let &Ray { origin, direction } = ray;
        let Domain { min_um: min, max_um: max, sides, floor } = self.domain;
        let mut nearest = (f64::INFINITY, Exit::Sky);
        if let Some((z_um, material)) = floor {
            let t = (z_um - origin.z) / direction.z;
            if t > 0.0 {
                nearest = (t, Exit::Floor(z_um, material));
            }
        }
        if sides == Sides::Mirror {
            for axis in 0..3 {
                if direction[axis] == 0.0 {
                    continue;
                }
                let at_um = if direction[axis] > 0.0 { max[axis] } else { min[axis] };
                let t = ((at_um - origin[axis]) / direction[axis]).max(0.0);
                if t < nearest.0 {
                    let exit = if axis == 2 { Exit::Sky } else { Exit::Mirror { axis, at_um } };
                    nearest = (t, exit);
                }
            }
        }
        nearest
    }
}

/// The parallelogram from which the sensor's rays start.
pub(crate) struct Footprint {
    pub(crate) corner: DVec3,
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
}

impl Footprint {
    /// Within mirror sides the plan of the domain at its top: the bed goes on beyond it, so any part of
    /// its plan sees the same. In the open a rectangle across the line of sight that covers all of
    /// the domain's box, so that the target is seen whole from any side.
    pub(crate) fn new(domain: &Domain, to_sensor: DVec3) -> Self {
        let (min, max) = (domain.min_um, domain.max_um);
        let size = max - min;
        if domain.sides == Sides::Mirror {
            let corner = DVec3::new(min.x, min.y, max.z);
            return Self { corner, right: size.x * DVec3::X, up: size.y * DVec3::Y };
        }
        let level = DVec3::Z.cross(to_sensor);
        let right = if level.length() > 1e-9 { level.normalize() } else { DVec3::X };
        let up = to_sensor.cross(right);
        let middle = (min + max) / 2.0;
        // Half the extent of the box along a unit vector.
        let reach = |axis: DVec3| (size.dot(axis.abs())) / 2.0;
        let corner = middle + reach(to_sensor) * to_sensor - reach(right) * right - reach(up) * up;
        Self { corner, right: 2.0 * reach(right) * right, up: 2.0 * reach(up) * up }
    }

    fn at(&self, [u, v]: [f64; 2]) -> DVec3 {
        self.corner + u * self.right + v * self.up
    }
}
