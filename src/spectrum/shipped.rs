//! What the binary carries: parameters of quartz powders, optical constants of quartz.

use std::sync::LazyLock;

use super::{PureBed, Spectrum, SpectrumError};
use crate::spectrum::optics::{PowderForm, PowderParameters, UniaxialCrystal};

/// Names of the shipped powders, each with its file.
pub(super) const POWDERS: [(&str, &str); 3] = [
    ("quartz_fine", include_str!("../../spectra/quartz_fine.json")),
    ("quartz_medium", include_str!("../../spectra/quartz_medium.json")),
    ("quartz_coarse", include_str!("../../spectra/quartz_coarse.json")),
];

/// Names of the shipped sets of optical constants of crystalline quartz, each with its file.
pub(super) const QUARTZ_SETS: [(&str, &str); 3] = [
    ("quartz", include_str!("../../spectra/quartz.json")),
    ("quartz_zeidler", include_str!("../../spectra/quartz_zeidler.json")),
    ("quartz_spitzer_kleinman", include_str!("../../spectra/quartz_spitzer_kleinman.json")),
];

/// A shipped set of optical constants by name.
pub fn crystal(name: &str) -> Result<&'static UniaxialCrystal, SpectrumError> {
    static SETS: LazyLock<[UniaxialCrystal; QUARTZ_SETS.len()]> = LazyLock::new(|| {
        QUARTZ_SETS.map(|(_, text)| {
            serde_json::from_str(text).expect("the shipped constants are read by a test")
        })
    });
    QUARTZ_SETS
        .iter()
        .position(|(known, _)| *known == name)
        .map(|set| &SETS[set])
        .ok_or_else(|| SpectrumError::UnknownConstants(name.to_owned()))
}

/// The shipped bed of one material.
pub(super) fn pure_bed() -> &'static PureBed {
    static BED: LazyLock<PureBed> = LazyLock::new(|| {
        serde_json::from_str(include_str!("../../spectra/pure_bed.json"))
            .expect("the shipped bed is read by a test")
    });
    &BED
}

/// All shipped spectra: the powders, then Fresnel facets by each set of constants.
pub fn all() -> Vec<Spectrum> {
    let powders = POWDERS.iter().map(|(name, _)| Spectrum::builtin(name));
    let facets = QUARTZ_SETS.iter().map(|(name, _)| Spectrum::fresnel(name));
    powders.chain(facets).map(|shipped| shipped.expect("a shipped name")).collect()
}

pub(super) fn powder(name: &str) -> Result<PowderForm, SpectrumError> {
    let (_, text) = POWDERS
        .iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| SpectrumError::Unknown(name.to_owned()))?;
    let parameters: PowderParameters =
        serde_json::from_str(text).expect("the shipped parameters are read by a test");
    Ok(PowderForm::new(crystal(&parameters.constants)?, parameters))
}
