//! Why a run of the pipeline cannot begin.

use std::path::PathBuf;

use crate::support::error::{Failure, Status};

/// A run asks for what its scene does not allow.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// Several packings are wanted of a scene that is one.
    #[error("{}: several packings are wanted, but the scene is placed: it is one packing", scene.display())]
    OnePacking {
        /// The scene file.
        scene: PathBuf,
    },
    /// A field is wanted of a scene that says itself what is at its sides.
    #[error("{}: a field is wanted, but the scene is placed: it says itself what is at its sides", scene.display())]
    FieldOfPlaced {
        /// The scene file.
        scene: PathBuf,
    },
    /// Grains are given for a scene whose grains are placed already.
    #[error("{}: grains are given, but the scene is placed: it has its own", scene.display())]
    GrainsOfPlaced {
        /// The scene file.
        scene: PathBuf,
    },
    /// There is no such coverage.
    #[error("there is no coverage {wanted:?}")]
    Coverage {
        /// The coverage wanted.
        wanted: String,
        /// Those that there are.
        known: String,
    },
}

impl Failure for PipelineError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::OnePacking { .. } => {
                "give the recipe that it was dropped from, or leave --packings out".into()
            }
            Self::FieldOfPlaced { .. } => {
                r#"write "sides": {"field": {"particles": N}} into its geometry.placed.domain"#
                    .into()
            }
            Self::GrainsOfPlaced { .. } => {
                "give the recipe that it was dropped from, or leave --grains out".into()
            }
            Self::Coverage { known, .. } => {
                format!("there are {known}, all, and any share from 0 to 1")
            }
        })
    }

    fn status(&self) -> Status {
        Status::Usage
    }
}
