//! Why a file of radiances cannot be used.

use crate::support::error::Failure;
use crate::support::file_error::FileError;
use crate::support::linear::OutOfRange;

/// A file of radiances cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RadiometryError {
    /// The file cannot be read, or its content is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file does not hold the wavelengths needed.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// A method of separation cannot find the temperature.
    #[error("no temperature by {method}: {problem}")]
    Separation {
        /// The method.
        method: &'static str,
        /// What it lacks.
        problem: String,
    },
}

impl Failure for RadiometryError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::File(error) => {
                error.hint_or("docs/guide/retrieval.md shows the columns of each kind of file")
            }
            Self::Separation { .. } => Some(
                "try another method, or give the target's temperature; docs/physics/separation.md says \
                 what each method needs"
                    .into(),
            ),
            Self::Range(error) => Some(error.hint()),
        }
    }
}
