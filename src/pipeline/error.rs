//! Why a run of the pipeline cannot begin.

use std::path::PathBuf;

use crate::support::error::{Failure, Status};

/// A run asks for what its scene does not allow.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// An option of recipes for a placed scene.
    #[error("{}: {option} needs a recipe; this scene is already placed ({has})", scene.display())]
    Placed {
        /// The scene file.
        scene: PathBuf,
        /// The option.
        option: &'static str,
        /// What the placed scene has instead.
        has: &'static str,
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
            Self::Placed { option: "--field", .. } => {
                r#"write "sides": {"field": {"particles": N}} into its geometry.placed.domain"#
                    .into()
            }
            Self::Placed { option, .. } => {
                format!("name the recipe that it was dropped from, or leave out {option}")
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
