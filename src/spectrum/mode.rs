//! What kind of spectrum a facet has, and what that means for a result.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Spectrum, SpectrumError, kirchhoff};

/// Where the reflectance of facets comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// A spectrum as it was measured or fitted.
    Library,
    /// A powder's spectrum, taken apart by a pure bed.
    Inverted,
    /// Optical constants, at the angle of each hit.
    Fresnel,
    /// A number.
    Constant,
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Library => "library",
            Self::Inverted => "inverted",
            Self::Fresnel => "fresnel",
            Self::Constant => "constant",
        })
    }
}

/// The facets of a material, as a result tells them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FacetSource {
    /// What kind of spectrum it is.
    pub mode: Mode,
    /// The spectrum.
    pub spectrum: String,
    /// What it means for the result.
    pub means: String,
    /// What speaks against the spectrum that was read.
    pub warnings: Vec<String>,
}

impl Spectrum {
    /// Where the reflectance comes from.
    pub fn mode(&self) -> Mode {
        match self {
            Self::Builtin(..) | Self::Tabulated(_) => Mode::Library,
            Self::Inverted(..) => Mode::Inverted,
            Self::Fresnel(..) => Mode::Fresnel,
            Self::Constant(_) => Mode::Constant,
        }
    }

    /// Standard error of a facet's emissivity at a wavelength in um, of a fit its root mean square, of inverted facets by
    /// those of the powder and of the pure bed; `None` where the spectrum comes without one.
    pub fn error(&self, um: f64) -> Result<Option<f64>, SpectrumError> {
        Ok(match self {
            Self::Constant(_) => Some(0.0),
            Self::Builtin(_, form) => Some(form.parameters.rms),
            Self::Tabulated(_) | Self::Fresnel(..) => None,
            Self::Inverted(powder, bed) => match powder.error(um)? {
                None => None,
                Some(error) => {
                    let wanted = kirchhoff(powder.emissivity(um)?);
                    let error = error.hypot(bed.standard_error);
                    let facet = |rho: f64| bed.facet(rho.clamp(0.0, 1.0)).unwrap_or(1.0);
                    Some((facet(wanted + error) - facet(wanted - error)) / 2.0)
                }
            },
        })
    }

    /// Whether it comes with an error.
    pub fn has_error(&self) -> bool {
        match self {
            Self::Constant(_) | Self::Builtin(..) => true,
            Self::Tabulated(_) | Self::Fresnel(..) => false,
            Self::Inverted(powder, _) => powder.has_error(),
        }
    }

    /// What a result has to say of it.
    pub fn facets(&self) -> FacetSource {
        let means = match self {
            Self::Builtin(..) => "a powder's emissivity on facets: scattering between grains counts twice, the bed \
                                  comes out too emissive"
                .into(),
            Self::Tabulated(_) => "an emissivity on facets as it is: if it is a powder's, scattering between grains \
                                   counts twice, and the bed comes out too emissive"
                .into(),
            Self::Inverted(_, pure_bed) => format!(
                "facets of which a bed of this material alone ({}) has the powder's emissivity; that bed is known to \
                 {:.4} (standard error)",
                pure_bed.title, pure_bed.standard_error
            ),
            Self::Fresnel(..) => "specular facets by optical constants, nothing fitted; for grains that let no light \
                                  through"
                .into(),
            Self::Constant(_) => "the same at every wavelength".into(),
        };
        FacetSource {
            mode: self.mode(),
            spectrum: self.to_string(),
            means,
            warnings: self.warnings().iter().map(ToString::to_string).collect(),
        }
    }
}
