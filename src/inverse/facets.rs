//! Models of the facets, which are compared and not fitted.

use serde::{Deserialize, Serialize};

use crate::spectrum::{PureBed, Spectrum, SpectrumError};
use crate::table::TableMaterial;

/// Where the reflectance of facets comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FacetModel {
    /// The powders' spectra on the facets, as in the paper
    Library,
    /// Facets that give a pure bed the powder's spectrum
    Inverted,
    /// Grains by Fresnel's equations, fines as inverted
    Fresnel,
}

impl FacetModel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Library, Self::Inverted, Self::Fresnel];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Library => "library",
            Self::Inverted => "inverted",
            Self::Fresnel => "fresnel",
        }
    }

    /// The materials of a bed with such facets.
    ///
    /// # Errors
    /// There are no optical constants.
    pub fn of(
        self,
        materials: &[TableMaterial],
        is_grain: impl Fn(usize) -> bool,
    ) -> Result<Vec<TableMaterial>, SpectrumError> {
        let of = |(number, material): (usize, &TableMaterial)| {
            let powder = powder(&material.spectrum);
            let spectrum = match self {
                Self::Library => powder,
                Self::Fresnel if is_grain(number) => Spectrum::fresnel(CONSTANTS)?,
                Self::Inverted | Self::Fresnel => inverted(powder),
            };
            let specular = if spectrum.is_angular() { 1.0 } else { 0.0 };
            Ok(TableMaterial { spectrum, specular, ..material.clone() })
        };
        materials.iter().enumerate().map(of).collect()
    }
}

impl FacetModel {
    /// The facets of finer grains than those of a bed, where there are any: of the shipped quartz,
    /// whose facets are Lambertian.
    ///
    /// # Errors
    /// Never of the shipped powders.
    pub fn medium(self, grain: &Spectrum) -> Result<Option<Spectrum>, SpectrumError> {
        let is_coarse = powder(grain) == Spectrum::builtin("quartz_coarse")?;
        let medium = Spectrum::builtin("quartz_medium")?;
        Ok(match self {
            Self::Library if is_coarse => Some(medium),
            Self::Inverted if is_coarse => Some(inverted(medium)),
            _ => None,
        })
    }
}

/// The optical constants of the grains.
const CONSTANTS: &str = "quartz";

/// The spectrum of the powder whose facets they are.
pub fn powder(spectrum: &Spectrum) -> Spectrum {
    match spectrum {
        Spectrum::Inverted(powder, _) => (**powder).clone(),
        other => other.clone(),
    }
}

fn inverted(powder: Spectrum) -> Spectrum {
    match powder {
        // Facets of optical constants and mixes of facets are no powder.
        Spectrum::Fresnel(..) | Spectrum::Refractive(..) | Spectrum::Mix(_) => powder,
        powder => Spectrum::Inverted(Box::new(powder), PureBed::shipped().clone()),
    }
}
