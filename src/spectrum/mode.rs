//! What kind of spectrum a facet has, and what that means for a result.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Spectrum;

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
