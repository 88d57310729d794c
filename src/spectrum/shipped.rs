//! The shipped spectra: parameters of quartz powders, optical constants of minerals.

use std::sync::LazyLock;

use super::{Spectrum, SpectrumError};
use crate::spectrum::optics::{Crystal, PowderForm, PowderParameters};

/// Names and files.
type Shipped = [(&'static str, &'static str)];

/// The shipped powders.
const POWDERS: &Shipped = &[
    ("quartz_fine", include_str!("../../spectra/quartz_fine.json")),
    ("quartz_medium", include_str!("../../spectra/quartz_medium.json")),
    ("quartz_coarse", include_str!("../../spectra/quartz_coarse.json")),
];

/// The shipped optical constants.
const CRYSTALS: &Shipped = &[
    ("quartz", include_str!("../../spectra/quartz.json")),
    ("quartz_zeidler", include_str!("../../spectra/quartz_zeidler.json")),
    ("quartz_spitzer_kleinman", include_str!("../../spectra/quartz_spitzer_kleinman.json")),
    ("calcite", include_str!("../../spectra/calcite.json")),
    ("corundum", include_str!("../../spectra/corundum.json")),
    ("forsterite", include_str!("../../spectra/forsterite.json")),
    ("hematite", include_str!("../../spectra/hematite.json")),
];

fn place(shipped: &Shipped, kind: &'static str, name: &str) -> Result<usize, SpectrumError> {
    shipped.iter().position(|(known, _)| *known == name).ok_or_else(|| SpectrumError::Unknown {
        kind,
        name: name.to_owned(),
        known: shipped.iter().map(|(name, _)| *name).collect(),
    })
}

/// A shipped set of optical constants by name.
pub fn crystal(name: &str) -> Result<&'static Crystal, SpectrumError> {
    static SETS: LazyLock<Vec<Crystal>> = LazyLock::new(|| {
        let read = |(_, text): &(_, &str)| serde_json::from_str(text);
        CRYSTALS.iter().map(|set| read(set).expect("a test reads the constants")).collect()
    });
    Ok(&SETS[place(CRYSTALS, "set of optical constants", name)?])
}

/// All shipped spectra: the powders, then Fresnel facets of each set of constants.
pub fn all() -> Vec<Spectrum> {
    let powders = POWDERS.iter().map(|(name, _)| Spectrum::builtin(name));
    let facets = CRYSTALS.iter().map(|(name, _)| Spectrum::fresnel(name));
    powders.chain(facets).map(|shipped| shipped.expect("a shipped name")).collect()
}

pub(super) fn powder(name: &str) -> Result<PowderForm, SpectrumError> {
    let (_, text) = POWDERS[place(POWDERS, "spectrum", name)?];
    let parameters: PowderParameters =
        serde_json::from_str(text).expect("a test reads the parameters");
    Ok(PowderForm::new(crystal(&parameters.constants)?, parameters))
}
