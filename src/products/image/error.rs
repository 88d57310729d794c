//! Why an image cannot be made.

use crate::support::error::Failure;

/// An image cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ImageError {
    /// The pinhole is within the bed.
    #[error(
        "the sensor's pinhole is {distance_um} um from the middle of the domain and {} um {} the \
         top of the bed: it must be outside the bed",
        height_um.abs(), if *height_um < 0.0 { "below" } else { "above" }
    )]
    Within {
        /// Its distance from the middle of the domain, um.
        distance_um: f64,
        /// Its height above the top of the bed, um.
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
            Self::Empty => "compare the sensor's optics with the place of the domain".into(),
        })
    }
}
