//! Pictures of beds and grains, drawn without a graphics card. The same input gives the same bytes
//! on any number of threads.

pub(crate) mod camera;
pub(crate) mod canvas;
mod coverages;
mod drop;
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
pub use drop::{drop, small_drop};
pub use frames::MOST_PANELS;
pub use grain::grain;
pub use patch::{patch, sensor_view};
pub use source::{PictureError, placed_scene};

/// The viewpoint and size of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Angle of the viewpoint from straight above, degrees. Beyond 90 the bed is seen from below,
    /// without its floor.
    pub zenith_deg: f64,
    /// Angle of the viewpoint from +x towards +y, degrees.
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
