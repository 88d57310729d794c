//! The sky and the atmosphere of a scene, read from its files.

use std::path::PathBuf;

use super::{Atmosphere, RadiometryError, SkyTable};
use crate::scene::{Scene, SkyRadiance};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::linear::ends;

/// What a scene's files of sky and atmosphere hold.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Air {
    /// Radiance of the sky.
    pub sky_radiance: Option<SkyTable>,
    /// The atmosphere between target and sensor.
    pub atmosphere: Option<Atmosphere>,
}

/// Reads a scene's files of sky and atmosphere.
///
/// # Errors
/// A file that cannot be used or does not hold all wavelengths, um, ascending.
pub fn air(scene: &Scene, wavelengths_um: &[f64]) -> Result<Air, Error> {
    let ends = ends(wavelengths_um);
    let read_sky = |radiance: &SkyRadiance| {
        let path = scene.path_of(radiance.file());
        let sky = SkyTable::read(&path)?;
        sky.covers(ends)?;
        let problem = match (radiance, sky.is_by_zenith()) {
            (SkyRadiance::Isotropic(_), true) => "it has a column zenith_deg: use by_zenith",
            (SkyRadiance::ByZenith(_), false) => "it has no column zenith_deg: use isotropic",
            _ => return Ok(sky),
        };
        let problem = format!("{problem} in the scene's sky_radiance");
        let error = FileError::wrong(&path, problem);
        Err(error.with_hint("docs/guide/retrieval.md shows both kinds of file").into())
    };
    let sky_radiance: Result<_, RadiometryError> =
        scene.sky_radiance.as_ref().map(read_sky).transpose();
    let read_atmosphere = |file: &PathBuf| {
        let atmosphere = Atmosphere::read(&scene.path_of(file))?;
        atmosphere.covers(ends).map(|()| atmosphere)
    };
    let atmosphere = scene.atmosphere_file.as_ref().map(read_atmosphere).transpose()?;
    Ok(Air { sky_radiance: sky_radiance?, atmosphere })
}
