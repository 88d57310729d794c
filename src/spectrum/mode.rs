//! The kind of a facet's spectrum, its error, and what they mean for a result.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Spectrum, SpectrumError, kirchhoff};

use crate::support::math;

/// Where the reflectance of facets comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Mode {
    /// A measured or fitted spectrum.
    Library,
    /// A powder's spectrum, inverted by a pure bed.
    Inverted,
    /// Optical constants, evaluated at the angle of each hit.
    Fresnel,
    /// Optical constants, by paths through the grains.
    Refractive,
    /// One number.
    Constant,
    /// Several spectra, mixed by area.
    Mix,
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&format!("{self:?}").to_lowercase())
    }
}

/// The facets of a material, as a result describes them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FacetSource {
    /// Kind of spectrum.
    pub mode: Mode,
    /// Description of the spectrum.
    pub spectrum: String,
    /// What this means for the result.
    pub means: String,
    /// Warnings about the spectrum.
    pub warnings: Vec<String>,
}

impl Spectrum {
    /// Where the reflectance comes from.
    pub fn mode(&self) -> Mode {
        match self {
            Self::Builtin(..) | Self::Tabulated(_) => Mode::Library,
            Self::Inverted(..) => Mode::Inverted,
            Self::Fresnel(..) => Mode::Fresnel,
            Self::Refractive(..) => Mode::Refractive,
            Self::Constant(_) => Mode::Constant,
            Self::Mix(_) => Mode::Mix,
        }
    }

    /// Standard error of a facet's emissivity at a wavelength in um, as far as it is
    /// [known](Self::has_error): 0 where nothing is. For a fit it is the root mean square error.
    /// For inverted facets it combines those of the powder and of the pure bed. Those of a mix add
    /// up, as if they were fully correlated.
    pub fn error(&self, um: f64) -> Result<f64, SpectrumError> {
        Ok(match self {
            Self::Builtin(_, form) => form.parameters.rms,
            Self::Constant(_) | Self::Tabulated(_) | Self::Fresnel(..) | Self::Refractive(..) => {
                0.0
            }
            Self::Inverted(powder, bed) => {
                let reflectance = kirchhoff(powder.emissivity(um)?);
                let facet = |rho: f64| bed.facet(rho.clamp(0.0, 1.0)).unwrap_or(1.0);
                let error = math::hypot(powder.error(um)?, bed.standard_error);
                (facet(reflectance + error) - facet(reflectance - error)) / 2.0
            }
            Self::Mix(mix) => mix.mean(|of| of.error(um))?,
        })
    }

    /// Whether all of its standard error is known. A file states none; a pure bed's is known even
    /// where that of its powder is not.
    pub fn has_error(&self) -> bool {
        match self {
            Self::Constant(_) | Self::Builtin(..) => true,
            Self::Tabulated(_) | Self::Fresnel(..) | Self::Refractive(..) => false,
            Self::Inverted(powder, _) => powder.has_error(),
            Self::Mix(mix) => mix.components().iter().all(|(_, of)| of.has_error()),
        }
    }

    /// What a result says of it.
    pub fn facets(&self) -> FacetSource {
        let means = match self {
            Self::Builtin(..) => "the facets have the emissivity of a powder: scattering between \
                                  grains counts twice, and the bed's emissivity is too high"
                .into(),
            Self::Tabulated(_) => "the facets have the emissivity of the file: if it is a \
                                   powder's, scattering between grains counts twice, and the \
                                   bed's emissivity is too high"
                .into(),
            Self::Inverted(_, pure_bed) => format!(
                "the facets give a bed of this material alone ({}) the powder's emissivity; the \
                 standard error of that bed is {:.4}",
                pure_bed.title, pure_bed.standard_error
            ),
            Self::Fresnel(..) => "specular facets by optical constants, without a fit; for opaque \
                                  grains"
                .into(),
            Self::Refractive(..) => {
                "light passes through the grains, by optical constants without a \
                                     fit; for grains that are large against the wavelength, or \
                                     that let light through"
                    .into()
            }
            Self::Constant(_) => "the same at every wavelength".into(),
            Self::Mix(mix) => {
                let means = |(share, of): &(f64, Self)| {
                    format!("{share} {}: {}", of.name(), of.facets().means)
                };
                let of = mix.components().iter().map(means).collect::<Vec<_>>().join("; ");
                format!("patches side by side on each facet, small against it; {of}")
            }
        };
        FacetSource {
            mode: self.mode(),
            spectrum: self.to_string(),
            means,
            warnings: self.warnings().iter().map(ToString::to_string).collect(),
        }
    }
}
