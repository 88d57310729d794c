//! Where a facet's emissivity comes from.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checked, need};

/// Where a facet's emissivity comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SpectrumSource {
    /// A shipped spectrum: `quartz_fine`, `quartz_medium` or `quartz_coarse`.
    Builtin(String),
    /// A file with a spectrum, relative to the scene file: two columns, wavelength in um and emissivity from 0
    /// to 1, or one of the formats of spectral libraries.
    File(PathBuf),
    /// The same emissivity at every wavelength, 0 to 1.
    Constant(f64),
    /// Shipped optical constants, `quartz`, `quartz_zeidler` or `quartz_spitzer_kleinman`: the facets reflect
    /// specularly, with the Fresnel reflectance at the angle of each hit.
    Fresnel(String),
    /// Facets such that a bed of them alone has the emissivity of a powder's spectrum.
    Inverted(Inverted),
}

/// A powder's spectrum and the bed that it is taken apart with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inverted {
    /// The powder's spectrum: `builtin`, `file` or `constant`.
    pub spectrum: Box<SpectrumSource>,
    /// Bounce tables of beds of that powder alone, its facets Lambertian, relative to the scene file; without it the
    /// shipped bed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pure_bed: Vec<PathBuf>,
}

impl SpectrumSource {
    /// The file that the spectrum is read from, if it is one.
    pub fn file_mut(&mut self) -> Option<&mut PathBuf> {
        match self {
            Self::File(file) => Some(file),
            Self::Inverted(inverted) => inverted.spectrum.file_mut(),
            Self::Builtin(_) | Self::Constant(_) | Self::Fresnel(_) => None,
        }
    }

    /// Bounce tables that it names.
    pub fn tables_mut(&mut self) -> &mut [PathBuf] {
        match self {
            Self::Inverted(inverted) => &mut inverted.pure_bed,
            _ => &mut [],
        }
    }

    /// What is wrong with it, at its place in the scene.
    pub(super) fn check(&self, place: &str) -> Checked {
        match self {
            Self::Constant(emissivity) => {
                need((0.0..=1.0).contains(emissivity), &format!("{place}.constant"), || {
                    format!("an emissivity of {emissivity} is not within 0 to 1")
                })
            }
            Self::Inverted(inverted) => {
                let place = format!("{place}.inverted.spectrum");
                need(
                    !matches!(*inverted.spectrum, Self::Fresnel(_) | Self::Inverted(_)),
                    &place,
                    || "it must be the spectrum of a powder: builtin, file or constant".into(),
                )?;
                inverted.spectrum.check(&place)
            }
            Self::Builtin(_) | Self::File(_) | Self::Fresnel(_) => Ok(()),
        }
    }
}
