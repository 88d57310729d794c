//! Why a file of radiances cannot be used.

use std::path::PathBuf;

use crate::support::error::Failure;

/// A file of radiances cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RadiometryError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line of the file is wrong.
    #[error("{}, line {line}: {problem}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong there.
        problem: String,
    },
    /// The file as a whole does not hold together, or not what is wanted of it.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
        /// What the user can do about it.
        hint: &'static str,
    },
    /// The file does not hold the wavelengths wanted.
    #[error(
        "{of} holds {}-{} um, and {} um is wanted",
        held_um[0], held_um[1], span(*wanted_um)
    )]
    Range {
        /// The file.
        of: String,
        /// Least and greatest wavelength wanted, um.
        wanted_um: [f64; 2],
        /// Least and greatest wavelength held, um.
        held_um: [f64; 2],
    },
    /// A method of separation has nothing to go by.
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
            Self::Read { .. } => None,
            Self::Form { .. } => {
                Some("docs/radiometry.md shows the columns of each kind of file".into())
            }
            Self::Separation { .. } => Some(
                "try another method, or give the target's temperature; docs/radiometry.md says what each needs"
                    .into(),
            ),
            Self::File { hint, .. } => Some((*hint).into()),
            Self::Range { held_um, .. } => {
                Some(format!("ask for a range within it: --range {}-{}", held_um[0], held_um[1]))
            }
        }
    }
}

/// A range of wavelengths in words, or the one that it is.
pub(super) fn span([from, to]: [f64; 2]) -> String {
    if from == to { from.to_string() } else { format!("{from}-{to}") }
}
