//! Where the rays of the sensor start.

use glam::DVec3;

use crate::geometry::Domain;
use crate::scene::Sides;

/// The parallelogram from which the sensor's rays start; of a field the one over one patch.
pub(crate) struct Footprint {
    pub(crate) corner: DVec3,
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
}

impl Footprint {
    /// Where the bed goes on beyond its domain: the plan of the domain at its top. In the open: a
    /// rectangle across the line of sight that covers the domain's box, so that the whole target is
    /// seen from any side.
    pub(crate) fn new(domain: &Domain, to_sensor: DVec3) -> Self {
        let (min, max) = (domain.min_um, domain.max_um);
        let size = max - min;
        if domain.sides != Sides::Open {
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

    pub(crate) fn at(&self, [u, v]: [f64; 2]) -> DVec3 {
        self.corner + u * self.right + v * self.up
    }
}
