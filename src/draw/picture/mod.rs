//! Pictures of beds and grains, drawn without a graphics card.
//!
//! | part | module |
//! |---|---|
//! | parallel projections | `camera` |
//! | which triangle is seen where | `visible` |
//! | what stands before the camera, what it sees of it | `stage` |
//! | sun, sky and shadows | `light` |
//! | pixels, writing and scale bars | `canvas` |
//! | from a stage to pixels | `render` |
//! | earlier results, and the recorded drop | `source`, `frames` |
//! | the pictures | [`patch`](patch()), [`grain`](grain()), [`drop`](drop()), [`coverages`](coverages()) |
//!
//! The same input gives the same bytes on any number of threads.

mod camera;
pub(crate) mod canvas;
mod coverages;
mod drop;
mod error;
mod frames;
mod grain;
mod light;
mod patch;
pub(crate) mod render;
mod source;
mod stage;
mod tray;
mod visible;

pub use coverages::coverages;
pub use drop::drop;
pub use error::FORMAT;
pub use error::PictureError;
pub use frames::MOST_PANELS;
pub use grain::grain;
pub use patch::{patch, sensor_view};
pub use source::placed_scene;

/// What a picture shows, and how large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// From where; straight from above at 0. Beyond 90 the bed is seen from below, without its floor.
    pub zenith_deg: f64,
    /// Angle of the eye's place from +x towards +y.
    pub azimuth_deg: f64,
    /// Width of the picture, pixels.
    pub width_px: usize,
}

impl Look {
    fn to_eye(self) -> glam::DVec3 {
        let Self { zenith_deg, azimuth_deg, .. } = self;
        crate::geometry::to_sensor(crate::scene::View { zenith_deg, azimuth_deg })
    }
}
