//! Parallel projections.

use glam::{BVec3, DAffine3, DMat3, DVec3};

/// Least side of a view, um.
const LEAST_UM: f64 = 1e-3;

/// Parallel rays through a parallelogram, which becomes the picture.
#[derive(Debug, Clone)]
pub(crate) struct Camera {
    /// Lower left corner of the picture in the scene, um.
    pub corner: DVec3,
    /// From there to the lower right corner, um.
    pub right: DVec3,
    /// From there to the upper left corner, um.
    pub up: DVec3,
    /// Unit vector from the scene to the eye.
    pub to_eye: DVec3,
}

/// The corners of a box. Bits 0 to 2 of a corner's number choose the greater x, y and z.
pub(super) fn corners([min, max]: [DVec3; 2]) -> [DVec3; 8] {
    std::array::from_fn(|i| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), max, min))
}

/// Unit vectors to the right and upwards across the line of sight. From straight above, up is
/// north.
pub(crate) fn level(to_eye: DVec3) -> (DVec3, DVec3) {
    let level = DVec3::Z.cross(to_eye);
    let right = if level.length() > 1e-9 { level.normalize() } else { DVec3::X };
    (right, to_eye.cross(right))
}

impl Camera {
    /// The smallest view that holds some points.
    pub fn around(points: impl Iterator<Item = DVec3>, to_eye: DVec3) -> Self {
        let (right, up) = level(to_eye);
        let axes = DMat3::from_cols(right, up, to_eye);
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in points {
            let p = axes.transpose() * point;
            (min, max) = (min.min(p), max.max(p));
        }
        let corner = axes * DVec3::new(min.x, min.y, max.z);
        // Something flat seen edge-on has a view, too.
        let size = (max - min).max(DVec3::splat(LEAST_UM));
        Self { corner, right: size.x * right, up: size.y * up, to_eye }
    }

    /// The same view with a margin on all sides, um.
    pub fn widened(mut self, margin_um: f64) -> Self {
        let (right, up) = (self.right.normalize() * margin_um, self.up.normalize() * margin_um);
        self.corner -= right + up;
        self.right += 2.0 * right;
        self.up += 2.0 * up;
        self
    }

    /// Width and height, um.
    pub fn size_um(&self) -> [f64; 2] {
        [self.right.length(), self.up.length()]
    }

    /// From the scene to a picture of that size: x to the right and y downwards in pixels, and the
    /// distance along the line of sight in um.
    pub fn to_pixels(&self, width: usize, height: usize) -> DAffine3 {
        let axes = DMat3::from_cols(self.right, self.up, -self.to_eye).inverse();
        let (w, h) = (width as f64, height as f64);
        let scale = DMat3::from_diagonal(DVec3::new(w, -h, 1.0));
        let translation = scale * (axes * -self.corner) + DVec3::new(0.0, h, 0.0);
        DAffine3 { matrix3: scale * axes, translation }
    }
}
