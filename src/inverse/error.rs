//! Why a spectrum cannot be matched.

use std::path::PathBuf;

use crate::support::error::Failure;

/// A spectrum cannot be matched.
#[derive(Debug, thiserror::Error)]
pub enum InverseError {
    /// The bed cannot be thinned.
    #[error("{}: {problem}", scene.display())]
    Bed {
        /// The scene file.
        scene: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// There are too few bands.
    #[error("{}: {bands} bands in the range are too few for {parameters} parameters; it takes {least}",
            spectrum.display())]
    Bands {
        /// The file.
        spectrum: PathBuf,
        /// Bands within the range.
        bands: usize,
        /// Parameters that are fitted.
        parameters: usize,
        /// The least number of bands.
        least: usize,
    },
    /// A prior names no parameter.
    #[error("there is no parameter {name:?}; the model has {known}")]
    Parameter {
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// A prior is not within the parameter's bounds.
    #[error("a prior of {prior} for {name} is not within {low:.3} to {high:.3}")]
    Prior {
        /// The parameter.
        name: String,
        /// The mean that was given.
        prior: f64,
        /// The bounds.
        low: f64,
        /// The bounds.
        high: f64,
    },
}

impl Failure for InverseError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Bed { .. } => {
                "give a recipe or a bed of dusty grains: each grain one mesh, its fines connected \
                 parts of their own material"
                    .into()
            }
            Self::Bands { .. } => "widen --range, or fix parameters with --prior NAME=VALUE".into(),
            Self::Parameter { .. } | Self::Prior { .. } => return None,
        })
    }
}
