//! Why a run of the pipeline cannot begin.

use std::path::PathBuf;

use crate::support::error::{Failure, Status};

/// A run asks for what its scene does not allow.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// Several packings of a placed scene.
    #[error("{}: --packings needs a recipe; this scene is already placed (one bed)", scene.display())]
    OnePacking {
        /// The scene file.
        scene: PathBuf,
    },
    /// A field of a placed scene, which names its own sides.
    #[error("{}: --field needs a recipe; this scene is already placed, with its own sides", scene.display())]
    FieldOfPlaced {
        /// The scene file.
        scene: PathBuf,
    },
    /// Grains for a placed scene.
    #[error("{}: --grains needs a recipe; this scene is already placed, with its own grains", scene.display())]
    GrainsOfPlaced {
        /// The scene file.
        scene: PathBuf,
    },
    /// An unknown coverage.
    #[error("{wanted:?} is not a coverage")]
    Coverage {
        /// The name given.
        wanted: String,
        /// The known names.
        known: String,
    },
}

impl Failure for PipelineError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::OnePacking { .. } => {
                "name the recipe that it was dropped from, or leave out --packings".into()
            }
            Self::FieldOfPlaced { .. } => {
                r#"write "sides": {"field": {"particles": N}} into its geometry.placed.domain"#
                    .into()
            }
            Self::GrainsOfPlaced { .. } => {
                "name the recipe that it was dropped from, or leave out --grains".into()
            }
            Self::Coverage { known, .. } => {
                format!("known are {known}, all, and any share from 0 to 1")
            }
        })
    }

    fn status(&self) -> Status {
        Status::Usage
    }
}
