//! Other spectra, temperatures, skies and atmospheres for a table, as far as its paths allow them.

use super::Table;
use crate::radiometry::SkyTable;
use crate::scene::Sky;
use crate::spectrum::Spectrum;
use crate::support::error::{Failure, Status};

/// The paths of a table say nothing of what it is to be evaluated with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChangeError {
    /// There is no such material.
    #[error("{name:?} is not a material of the table: {known}")]
    Material {
        /// The name.
        name: String,
        /// The materials.
        known: String,
    },
    /// Light was followed through grains.
    #[error(
        "{0:?}: the paths were traced through grains by the spectra of the scene; trace it again"
    )]
    Refractive(String),
    /// Facets that scatter in other directions.
    #[error(
        "{name:?}: the paths were traced with {traced}, which scatters in other directions; trace \
         the scene again"
    )]
    Scatter {
        /// The material.
        name: String,
        /// Its spectrum in the trace.
        traced: String,
    },
    /// Materials would differ in temperature.
    #[error(
        "at {0} K some materials have another temperature than the scene, and the paths were traced \
         without the order of their hits; trace the scene again at that temperature"
    )]
    Temperature(f64),
    /// The temperature depends on depth or sun.
    #[error("the temperature of the scene depends on depth or sun; trace it again with another")]
    Layers,
    /// No temperature at all.
    #[error("{0}")]
    Sky(String),
    /// The zenith angles of escape were not recorded.
    #[error(
        "{0} depends on the zenith angle, and the paths were traced without it; trace the scene \
         again with such a sky"
    )]
    Zenith(String),
}

impl Failure for ChangeError {
    fn status(&self) -> Status {
        Status::Usage
    }
}

impl Table {
    /// Gives a material another spectrum.
    ///
    /// # Errors
    /// An unknown material, or facets that scatter otherwise than those that were traced.
    pub fn set_spectrum(&mut self, name: &str, spectrum: Spectrum) -> Result<(), ChangeError> {
        let Some(place) = self.materials.iter().position(|m| m.name == name) else {
            let names: Vec<&str> = self.materials.iter().map(|m| &*m.name).collect();
            return Err(ChangeError::Material { name: name.into(), known: names.join(", ") });
        };
        let is_floor = self.floor == Some(place);
        if let Some(nodes) = &self.nodes
            && !(is_floor && nodes.floor == self.floor)
        {
            return Err(ChangeError::Refractive(name.into()));
        }
        let material = &mut self.materials[place];
        if spectrum.is_angular() != material.spectrum.is_angular() {
            let traced = material.spectrum.to_string();
            return Err(ChangeError::Scatter { name: name.into(), traced });
        }
        (material.spectrum, material.auto) = (spectrum, false);
        Ok(())
    }

    /// Gives the scene another temperature, K.
    ///
    /// # Errors
    /// No valid temperature, or materials of one of their own whose hits were traced without order.
    pub fn set_temperature(&mut self, temperature_k: f64) -> Result<(), ChangeError> {
        if let Some(problem) = Sky::Isotropic(temperature_k).problem() {
            return Err(ChangeError::Sky(problem));
        }
        if self.layers.is_some() {
            return Err(ChangeError::Layers);
        }
        self.temperature_k = temperature_k;
        if self.lacks_order() { Err(ChangeError::Temperature(temperature_k)) } else { Ok(()) }
    }

    /// Gives the scene a grey sky of a temperature, K.
    ///
    /// # Errors
    /// No valid temperature.
    pub fn set_sky_temperature(&mut self, temperature_k: f64) -> Result<(), ChangeError> {
        let sky = Sky::Isotropic(temperature_k);
        if let Some(problem) = sky.problem() {
            return Err(ChangeError::Sky(problem));
        }
        (self.sky_temperature_k, self.sky_radiance) = (Some(sky), None);
        Ok(())
    }

    /// Gives the scene a sky of a file.
    ///
    /// # Errors
    /// A sky by zenith angle, where the paths were traced without it.
    pub fn set_sky(&mut self, sky: SkyTable) -> Result<(), ChangeError> {
        if sky.is_by_zenith() && self.histogram.kept.zeniths == 1 {
            return Err(ChangeError::Zenith(sky.file));
        }
        (self.sky_temperature_k, self.sky_radiance) = (None, Some(sky));
        Ok(())
    }
}
