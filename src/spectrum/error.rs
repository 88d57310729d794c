//! Why a spectrum cannot be used.

use std::path::PathBuf;

use super::shipped::{POWDERS, QUARTZ_SETS};
use crate::support::error::Failure;
use crate::support::file_error::FileError;

/// A spectrum cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SpectrumError {
    /// The file cannot be read.
    #[error("cannot read the spectrum {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a spectrum.
    #[error("{}, line {line}: {problem}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong there.
        problem: String,
    },
    /// The file as a whole does not hold together.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
        /// What the user can do about it.
        hint: &'static str,
    },
    /// The file holds transmission, which tells no emissivity.
    #[error("{}: this is a transmission spectrum ({said:?})", path.display())]
    Transmission {
        /// The file.
        path: PathBuf,
        /// Where it says so.
        said: String,
    },
    /// Several spectra where one is wanted.
    #[error("{} holds {} spectra, and one is wanted", path.display(), names.len())]
    Several {
        /// The file.
        path: PathBuf,
        /// Their names.
        names: Vec<String>,
    },
    /// There is no shipped spectrum of that name.
    #[error("there is no shipped spectrum {0:?}")]
    Unknown(String),
    /// There is no shipped set of optical constants of that name.
    #[error("there are no shipped optical constants {0:?}")]
    UnknownConstants(String),
    /// The spectrum does not hold the wavelengths wanted.
    #[error(
        "the spectrum of {of} holds {}-{} um, and {} um is wanted",
        held_um[0], held_um[1], span(*wanted_um)
    )]
    Range {
        /// The file or the name of the spectrum.
        of: String,
        /// Least and greatest wavelength wanted, um.
        wanted_um: [f64; 2],
        /// Least and greatest wavelength held, um.
        held_um: [f64; 2],
    },
    /// A powder's emissivity that no facet can make.
    #[error(
        "no facet makes a bed have the emissivity {emissivity:.4} of {of} at {wavelength_um} um: with white facets the \
         pure bed still has {least:.4}"
    )]
    NoFacet {
        /// The powder's spectrum.
        of: String,
        /// Where, um.
        wavelength_um: f64,
        /// The powder's emissivity.
        emissivity: f64,
        /// The least that the pure bed can have.
        least: f64,
    },
    /// The channels at a wavelength wanted were deleted from the file.
    #[error(
        "the spectrum of {of} has no values between {} and {} um, and {wanted_um} um is wanted",
        gap_um[0], gap_um[1]
    )]
    Gap {
        /// The file.
        of: String,
        /// The wavelength wanted, um.
        wanted_um: f64,
        /// The last wavelength before the gap and the first after it, um.
        gap_um: [f64; 2],
    },
}

impl Failure for SpectrumError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Unknown(_) => format!("there are {}", POWDERS.map(|(name, _)| name).join(", ")),
            Self::UnknownConstants(_) => {
                format!("there are {}", QUARTZ_SETS.map(|(name, _)| name).join(", "))
            }
            Self::Form { .. } => "docs/spectra.md names the formats that are read; bad values at \
                                  wavelengths that are not wanted can be left out: `soilsig \
                                  spectra convert FILE --range FROM-TO --out FILE.csv`"
                .into(),
            Self::File { hint, .. } => (*hint).into(),
            Self::Transmission { .. } => "bring the reflectance of the same sample, or its \
                                          emissivity: of transmission alone neither follows"
                .into(),
            Self::Several { names, .. } => {
                let shown = names.iter().take(8).map(String::as_str).collect::<Vec<_>>().join(", ");
                format!(
                    "write the one to a file of its own: `soilsig spectra convert FILE --name NAME \
                     --out NAME.csv`; there are {shown}{}",
                    if names.len() > 8 { " and more" } else { "" }
                )
            }
            Self::Range { held_um, .. } => {
                format!("ask for a range within it: --range {}-{}", held_um[0], held_um[1])
            }
            Self::NoFacet { .. } => {
                "trace the pure bed with facets of a lower emissivity: paths are followed longer \
                                     then, and fewer are given up"
                    .into()
            }
            Self::Gap { .. } => "ask for a range on one side of it, with --range".into(),
            Self::Read { .. } => return None,
        })
    }
}

impl From<FileError> for SpectrumError {
    fn from(error: FileError) -> Self {
        match error {
            FileError::Read { path, source } => Self::Read { path, source },
            FileError::Wrong { path, problem, .. } => Self::Form { path, line: 1, problem },
        }
    }
}

fn span([from, to]: [f64; 2]) -> String {
    if from == to { from.to_string() } else { format!("{from}-{to}") }
}
