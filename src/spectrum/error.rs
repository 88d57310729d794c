//! Why a spectrum cannot be used.

use std::path::PathBuf;

use crate::support::error::Failure;
use crate::support::file_error::FileError;
use crate::support::linear::OutOfRange;

/// A spectrum cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SpectrumError {
    /// The file cannot be read, or is not a valid spectrum.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file holds transmission, from which no emissivity follows.
    #[error("{}: this is a transmission spectrum ({said:?})", path.display())]
    Transmission {
        /// The file.
        path: PathBuf,
        /// Where it says so.
        said: String,
    },
    /// The file holds absorbance, -log10 of a transmittance or of a reflectance.
    #[error("{}: this is an absorbance spectrum ({said:?})", path.display())]
    Absorbance {
        /// The file.
        path: PathBuf,
        /// Where it says so.
        said: String,
    },
    /// The file holds several spectra where one is needed.
    #[error("{} holds {} spectra, but one is needed", path.display(), names.len())]
    Several {
        /// The file.
        path: PathBuf,
        /// Their names.
        names: Vec<String>,
    },
    /// No shipped spectrum or set of optical constants has that name.
    #[error("{name:?} is not a shipped {kind}")]
    Unknown {
        /// What was looked for.
        kind: &'static str,
        /// Its name.
        name: String,
        /// The names that exist.
        known: Vec<&'static str>,
    },
    /// The spectrum does not hold the wavelengths needed.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// A powder's emissivity that no facet can give.
    #[error(
        "{of} has an emissivity of {emissivity:.4} at {wavelength_um} um, but the pure bed cannot \
         go below {least:.4}, even with white facets"
    )]
    NoFacet {
        /// The powder's spectrum.
        of: String,
        /// The wavelength, um.
        wavelength_um: f64,
        /// The powder's emissivity.
        emissivity: f64,
        /// The least emissivity of the pure bed.
        least: f64,
    },
    /// The wavelength is in a gap of the file: its channels were deleted.
    #[error(
        "the spectrum of {of} has no values between {} and {} um, but {needed_um} um is needed",
        gap_um[0], gap_um[1]
    )]
    Gap {
        /// The file.
        of: String,
        /// The wavelength needed, um.
        needed_um: f64,
        /// The last wavelength before the gap and the first after it, um.
        gap_um: [f64; 2],
    },
}

impl Failure for SpectrumError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::File(error) => {
                return error.hint_or(
                    "docs/guide/own_spectra.md names the formats; leave out bad values at wavelengths that \
                     are not needed: `soilsig spectra convert FILE --range FROM-TO --out FILE.csv`",
                );
            }
            Self::Unknown { known, .. } => format!("the names are {}", known.join(", ")),
            Self::Transmission { .. } => {
                "use the reflectance or the emissivity of the same sample".into()
            }
            Self::Absorbance { .. } => {
                "use the reflectance or the emissivity of the same sample; absorbance A that was \
                 measured in reflection is a reflectance of 10^-A"
                    .into()
            }
            Self::Several { names, .. } => {
                let shown = names.iter().take(8).map(String::as_str).collect::<Vec<_>>().join(", ");
                format!(
                    "write one to its own file: `soilsig spectra convert FILE --name NAME --out \
                     NAME.csv`; the names are {shown}{}",
                    if names.len() > 8 { " and more" } else { "" }
                )
            }
            Self::Range(error) => error.hint(),
            Self::NoFacet { .. } => {
                "trace the pure bed with facets of a lower emissivity: paths are then followed \
                 longer, and fewer are given up"
                    .into()
            }
            Self::Gap { .. } => "ask for a range on one side of the gap, with --range".into(),
        })
    }
}
