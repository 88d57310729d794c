//! Where a facet's emissivity comes from.

use std::path::PathBuf;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checked, need, within};
use super::{Change, Scene};

/// The emissivity of a material's facets: one of these keys.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SpectrumSource {
    /// A shipped spectrum: `quartz_fine`, `quartz_medium` or `quartz_coarse`.
    Builtin(String),
    /// A file with a spectrum, relative to the scene file. It has two columns, wavelength (um) and
    /// emissivity (0 to 1), or a format of the spectral libraries.
    File(PathBuf),
    /// The same emissivity at every wavelength, 0 to 1.
    Constant(f64),
    /// Shipped optical constants: `quartz`, `quartz_zeidler` or `quartz_spitzer_kleinman`. Facets
    /// are specular, with the Fresnel reflectance at the angle of each hit.
    Fresnel(String),
    /// The facets of a powder: a bed of them alone has the emissivity of the powder's spectrum.
    Inverted(Inverted),
}

/// A powder's spectrum, and the bed that its facets are found with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Inverted {
    /// The powder's spectrum: `builtin`, `file` or `constant`.
    pub spectrum: Box<SpectrumSource>,
    /// Bounce tables of beds of that powder alone with Lambertian facets, relative to the scene
    /// file. Default: the shipped pure bed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pure_bed: Vec<PathBuf>,
}

/// What the spectra of powders give to facets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum Facets {
    /// The powder's spectrum itself, as the paper does.
    Library,
    /// The spectrum inverted by a pure bed: scattering between grains counts once.
    Inverted,
}

impl Facets {
    /// Gives the facets of all powders this meaning. Constants and optical constants are those of
    /// a facet and stay.
    pub fn apply(self, scene: &mut Scene) {
        for material in &mut scene.materials {
            let source = &mut material.spectrum;
            match (self, &mut *source) {
                (Self::Inverted, SpectrumSource::Builtin(_) | SpectrumSource::File(_)) => {
                    let spectrum = Box::new(source.clone());
                    *source = SpectrumSource::Inverted(Inverted { spectrum, pure_bed: Vec::new() });
                }
                (Self::Library, SpectrumSource::Inverted(inverted)) => {
                    *source = (*inverted.spectrum).clone();
                }
                _ => {}
            }
        }
        scene.changes.push(Change::of_facets(self));
    }
}

impl SpectrumSource {
    /// The spectrum's file, and the bounce tables of its pure bed.
    pub(super) fn files_mut(&mut self) -> (Option<&mut PathBuf>, &mut [PathBuf]) {
        match self {
            Self::File(file) => (Some(file), &mut []),
            Self::Inverted(Inverted { spectrum, pure_bed }) => (spectrum.files_mut().0, pure_bed),
            Self::Builtin(_) | Self::Constant(_) | Self::Fresnel(_) => (None, &mut []),
        }
    }

    pub(super) fn check(&self, place: &str) -> Checked {
        match self {
            Self::Constant(emissivity) => {
                within(*emissivity, 0.0..=1.0, &format!("{place}.constant"))
            }
            Self::Inverted(inverted) => {
                let place = format!("{place}.inverted.spectrum");
                let is_powder = !matches!(*inverted.spectrum, Self::Fresnel(_) | Self::Inverted(_));
                need(is_powder, &place, || {
                    "it must be the spectrum of a powder: builtin, file or constant".into()
                })?;
                inverted.spectrum.check(&place)
            }
            Self::Builtin(_) | Self::File(_) | Self::Fresnel(_) => Ok(()),
        }
    }
}
