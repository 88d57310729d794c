//! Why there is no image.

use crate::support::error::Failure;

/// An image cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ImageError {
    /// The pinhole is where the bed is.
    #[error(
        "the sensor's pinhole, {distance_um} um from the middle of the domain, is {} um {} the top of the bed",
        height_um.abs(), if *height_um < 0.0 { "below" } else { "above" }
    )]
    Within {
        /// Its distance, um.
        distance_um: f64,
        /// Its height above the top, um.
        height_um: f64,
    },
    /// No pixel sees anything.
    #[error("no pixel sees anything: the sensor looks past the target")]
    Empty,
}

impl Failure for ImageError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Within { .. } => "give sensor.optics.pinhole a greater distance_um".into(),
            Self::Empty => "compare the sensor's optics with where the domain is".into(),
        })
    }
}
