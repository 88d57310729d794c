//! The sky and the atmosphere of a scene, read from its files.

use std::path::PathBuf;

use super::{Atmosphere, RadiometryError, SkyTable};
use crate::scene::{Scene, SkyRadiance};
use crate::support::error::Error;

/// What a scene takes from files of the sky and of the atmosphere before the sensor.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Air {
    /// Radiance of the sky.
    pub sky_radiance: Option<SkyTable>,
    /// What lies between target and sensor.
    pub atmosphere: Option<Atmosphere>,
}

/// Reads a scene's files of sky and atmosphere, which have to hold all of the wavelengths; they are relative to the
/// scene file.
pub fn air(scene: &Scene, wavelengths_um: &[f64]) -> Result<Air, Error> {
    let ends = [wavelengths_um[0], wavelengths_um[wavelengths_um.len() - 1]];
    let read_sky = |radiance: &SkyRadiance| {
        let path = scene.path_of(radiance.file());
        let sky = SkyTable::read(&path)?;
        sky.covers(ends)?;
        let (key, problem) = match radiance {
            SkyRadiance::Isotropic(_) => ("by_zenith", "there is a column zenith_deg"),
            SkyRadiance::ByZenith(_) => ("isotropic", "there is no column zenith_deg"),
        };
        if sky.is_by_zenith() == (key == "isotropic") {
            return Ok(sky);
        }
        let problem = format!("{problem}: the scene's sky_radiance has to be {{{key:?}: ...}}");
        let hint = "docs/radiometry.md shows both kinds of file";
        Err(RadiometryError::File { path, problem, hint })
    };
    let sky_radiance = scene.sky_radiance.as_ref().map(read_sky).transpose()?;
    let read_atmosphere = |file: &PathBuf| {
        let atmosphere = Atmosphere::read(&scene.path_of(file))?;
        atmosphere.covers(ends).map(|()| atmosphere)
    };
    let atmosphere = scene.atmosphere_file.as_ref().map(read_atmosphere).transpose()?;
    Ok(Air { sky_radiance, atmosphere })
}
