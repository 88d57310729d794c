//! The shipped spectra: parameters of quartz powders, optical constants of quartz.

use std::sync::LazyLock;

use super::{Spectrum, SpectrumError};
use crate::spectrum::optics::{PowderForm, PowderParameters, UniaxialCrystal};

/// Names and files.
type Shipped = [(&'static str, &'static str); 3];

/// The shipped powders.
const POWDERS: Shipped = [
    ("quartz_fine", include_str!("../../spectra/quartz_fine.json")),
    ("quartz_medium", include_str!("../../spectra/quartz_medium.json")),
    ("quartz_coarse", include_str!("../../spectra/quartz_coarse.json")),
];

/// The shipped optical constants of crystalline quartz.
const QUARTZ_SETS: Shipped = [
    ("quartz", include_str!("../../spectra/quartz.json")),
    ("quartz_zeidler", include_str!("../../spectra/quartz_zeidler.json")),
    ("quartz_spitzer_kleinman", include_str!("../../spectra/quartz_spitzer_kleinman.json")),
];

fn place(shipped: &Shipped, kind: &'static str, name: &str) -> Result<usize, SpectrumError> {
    shipped.iter().position(|(known, _)| *known == name).ok_or_else(|| SpectrumError::Unknown {
        kind,
        name: name.to_owned(),
        known: shipped.map(|(name, _)| name).to_vec(),
    })
}

/// A shipped set of optical constants by name.
pub fn crystal(name: &str) -> Result<&'static UniaxialCrystal, SpectrumError> {
    static SETS: LazyLock<[UniaxialCrystal; 3]> = LazyLock::new(|| {
        QUARTZ_SETS.map(|(_, text)| serde_json::from_str(text).expect("a test reads the constants"))
    });
    Ok(&SETS[place(&QUARTZ_SETS, "set of optical constants", name)?])
}

/// All shipped spectra: the powders, then Fresnel facets of each set of constants.
pub fn all() -> Vec<Spectrum> {
    let powders = POWDERS.iter().map(|(name, _)| Spectrum::builtin(name));
    let facets = QUARTZ_SETS.iter().map(|(name, _)| Spectrum::fresnel(name));
    powders.chain(facets).map(|shipped| shipped.expect("a shipped name")).collect()
}

pub(super) fn powder(name: &str) -> Result<PowderForm, SpectrumError> {
    let (_, text) = POWDERS[place(&POWDERS, "spectrum", name)?];
    let parameters: PowderParameters =
        serde_json::from_str(text).expect("a test reads the parameters");
    Ok(PowderForm::new(crystal(&parameters.constants)?, parameters))
}
