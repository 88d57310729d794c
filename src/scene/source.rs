//! Where a facet's emissivity comes from.

use std::path::PathBuf;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checked, need, within};
use super::{Change, Scene};
use crate::support::statistics::SHARES_ROUNDING;

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
    /// Optical constants of a crystal, shipped or from a file. Facets are specular, with the Fresnel
    /// reflectance at the angle of each hit.
    Fresnel(Constants),
    /// Optical constants of a crystal, shipped or from a file. Light passes through the facets: it is
    /// refracted, absorbed within the grain, and leaves again.
    Refractive(Constants),
    /// Optical constants of a crystal, shipped or from a file. Facets are opaque in the bands in
    /// which grains of their size let no light through, and `refractive` in the others.
    Auto(Constants),
    /// The facets of a powder: a bed of them alone has the emissivity of the powder's spectrum.
    Inverted(Inverted),
    /// Patches of several kinds on each facet, mixed by area: 1 to 100. Patches are small against
    /// the facet, and Lambertian: `fresnel` is not among them.
    Mix(Vec<Component>),
}

/// Optical constants: the name of a shipped set, or a file of one's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged, expecting = "constants are the name of a shipped set, or {\"file\": name}")]
pub enum Constants {
    /// A shipped set: one that `soilsig spectra list` names.
    Shipped(String),
    /// A file of optical constants.
    File(ConstantsFile),
}

/// A file of optical constants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ConstantsFile {
    /// A JSON file with the dielectric function along each axis, relative to the scene file.
    pub file: PathBuf,
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

/// One kind of patch on a facet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Component {
    /// Its share of the area, above 0. All shares add up to 1.
    pub share: f64,
    /// Its spectrum: `builtin`, `file`, `constant` or `inverted`.
    pub spectrum: SpectrumSource,
}

/// Most components of a mix.
const MOST_COMPONENTS: usize = 100;

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
            self.give(&mut material.spectrum);
        }
        scene.changes.push(Change::of_facets(self));
    }

    fn give(self, source: &mut SpectrumSource) {
        match (self, &mut *source) {
            (Self::Inverted, SpectrumSource::Builtin(_) | SpectrumSource::File(_)) => {
                let spectrum = Box::new(source.clone());
                *source = SpectrumSource::Inverted(Inverted { spectrum, pure_bed: Vec::new() });
            }
            (Self::Library, SpectrumSource::Inverted(inverted)) => {
                *source = (*inverted.spectrum).clone();
            }
            (_, SpectrumSource::Mix(components)) => {
                for component in components {
                    self.give(&mut component.spectrum);
                }
            }
            _ => {}
        }
    }
}

impl SpectrumSource {
    /// Gives each file to `add`, with its label and whether it is a bounce table of a pure bed.
    /// `number` is that of the material.
    pub(super) fn files_mut<'a>(
        &'a mut self,
        number: &str,
        add: &mut impl FnMut(String, &'a mut PathBuf, bool),
    ) {
        match self {
            Self::File(file) => add(format!("spectrum_{number}"), file, false),
            Self::Inverted(Inverted { spectrum, pure_bed }) => {
                spectrum.files_mut(number, add);
                for (bed, table) in pure_bed.iter_mut().enumerate() {
                    add(format!("pure_bed_{number}_{bed}"), table, true);
                }
            }
            Self::Mix(components) => {
                for (i, component) in components.iter_mut().enumerate() {
                    component.spectrum.files_mut(&format!("{number}_{i}"), add);
                }
            }
            Self::Fresnel(Constants::File(ConstantsFile { file }))
            | Self::Refractive(Constants::File(ConstantsFile { file }))
            | Self::Auto(Constants::File(ConstantsFile { file })) => {
                add(format!("constants_{number}"), file, false);
            }
            Self::Builtin(_)
            | Self::Constant(_)
            | Self::Fresnel(Constants::Shipped(_))
            | Self::Refractive(Constants::Shipped(_))
            | Self::Auto(Constants::Shipped(_)) => {}
        }
    }

    /// What is wrong with its values, if anything is.
    pub fn problem(&self) -> Option<String> {
        self.check("spectrum").err().map(|(place, problem)| format!("{place}: {problem}"))
    }

    pub(super) fn check(&self, place: &str) -> Checked {
        match self {
            Self::Constant(emissivity) => {
                within(*emissivity, 0.0..=1.0, &format!("{place}.constant"))
            }
            Self::Inverted(inverted) => {
                let place = format!("{place}.inverted.spectrum");
                let is_powder = matches!(
                    *inverted.spectrum,
                    Self::Builtin(_) | Self::File(_) | Self::Constant(_)
                );
                need(is_powder, &place, || {
                    "it must be the spectrum of a powder: builtin, file or constant".into()
                })?;
                inverted.spectrum.check(&place)
            }
            Self::Mix(components) => check_mix(components, &format!("{place}.mix")),
            Self::Builtin(_)
            | Self::File(_)
            | Self::Fresnel(_)
            | Self::Refractive(_)
            | Self::Auto(_) => Ok(()),
        }
    }
}

fn check_mix(components: &[Component], place: &str) -> Checked {
    within(components.len(), 1..=MOST_COMPONENTS, place)?;
    for (i, component) in components.iter().enumerate() {
        let place = format!("{place}[{i}]");
        let Component { share, spectrum } = component;
        need(*share > 0.0 && *share <= 1.0, &format!("{place}.share"), || {
            format!("{share} is not above 0 and at most 1")
        })?;
        let place = format!("{place}.spectrum");
        let is_lambertian = !matches!(
            spectrum,
            SpectrumSource::Fresnel(_)
                | SpectrumSource::Refractive(_)
                | SpectrumSource::Auto(_)
                | SpectrumSource::Mix(_)
        );
        need(is_lambertian, &place, || {
            "a component is Lambertian: builtin, file, constant or inverted. Give mirrors a \
             material of their own"
                .into()
        })?;
        spectrum.check(&place)?;
    }
    let sum: f64 = components.iter().map(|component| component.share).sum();
    need((sum - 1.0).abs() <= SHARES_ROUNDING, place, || {
        format!("the shares add up to {sum}, not 1")
    })
}
