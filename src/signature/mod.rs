//! Emissivity and radiance of a traced bed, band by band (Eq. 1 to 3).

pub mod budget;
mod cells;
pub(crate) mod csv;
pub mod in_bands;
pub mod jacobian;
pub mod levels;
#[cfg(feature = "netcdf")]
pub mod netcdf;
pub mod plan;
mod window;

use rayon::prelude::*;

use crate::histogram::{Estimate, Mean, Radiance};
use crate::radiometry::{self, Assumed, Lit, Measured, Retrieved, Temperature};
use crate::support::error::Error;
use crate::table::{NodesError, Table};

pub use csv::csv_text;
pub use levels::Levels;
pub use window::Window;

/// One band of a signature. Radiance is in W m-2 sr-1 um-1.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Band {
    /// Wavelength, um.
    pub wavelength_um: f64,
    /// Whether the models of all facets hold. `fresnel` facets fail on grains that transmit light.
    pub valid: bool,
    /// Share of the band for which light through `auto` facets was followed, mean of the beds;
    /// `None` without such facets.
    pub refracted: Option<f64>,
    /// Emissivity of the bed towards the sensor: a property of the bed, whatever its temperatures.
    pub emissivity: Estimate,
    /// Radiance emitted.
    pub l_emitted: Estimate,
    /// Radiance reflected from the sky.
    pub l_reflected: Estimate,
    /// Radiance that leaves the target: their sum (Eq. 1).
    pub l_target: Estimate,
    /// Radiance of a black body at the scene's temperature.
    pub l_blackbody: f64,
    /// Radiance of the sky; where it depends on the zenith angle, the mean that a horizontal
    /// Lambertian mirror would return.
    pub l_downwelling: f64,
    /// Transmittance and path radiance between target and sensor, if there is an atmosphere.
    pub path: Option<(f64, f64)>,
}

/// Evaluates the tables of a recipe's packings with the spectra and temperatures of the first. Where
/// the same drops are there as hulls and with fines that touch, the mean is of both levels.
///
/// # Errors
/// A spectrum does not cover a wavelength.
///
/// # Panics
/// Without a table.
pub fn evaluate(packings: &[Table], wavelengths_um: &[f64]) -> Result<Vec<Band>, Error> {
    if packings.iter().any(|table| table.histogram.kept != packings[0].histogram.kept) {
        return Err(NodesError::Mixed(packings[0].scene.clone()).into());
    }
    let (lit, levels) = (packings[0].lit(wavelengths_um)?, Levels::of(packings));
    Ok(lit.par_iter().map(|lit| band(packings, &levels, lit)).collect())
}

/// The emissivity for one reflectance of each symbol of the tables.
pub fn emissivity(packings: &[Table], reflectance: &[f64]) -> Estimate {
    let of = |packing: &Table| {
        let weight = packing.weight(reflectance);
        Mean { mean: 1.0 - weight.mean, ..weight }
    };
    Levels::of(packings).estimate(&packings.iter().map(of).collect::<Vec<_>>())
}

/// The emissivity of each table alone in each band.
pub fn curves(packings: &[Table], wavelengths_um: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
    let rho = packings[0].reflectances(wavelengths_um)?;
    let of = |table: &Table| {
        table.histogram.weight_in(&rho).iter().map(|weight| 1.0 - weight.mean).collect()
    };
    Ok(packings.par_iter().map(of).collect())
}

fn band(packings: &[Table], levels: &Levels, lit: &Lit) -> Band {
    let seen: Vec<(Mean, Radiance)> = packings.iter().map(|p| lit.seen(&p.histogram)).collect();
    let of = |part: fn(&(Mean, Radiance)) -> Mean| {
        levels.estimate(&seen.iter().map(part).collect::<Vec<_>>())
    };
    Band {
        wavelength_um: lit.wavelength_um,
        valid: packings[0].materials.iter().all(|m| m.is_valid(lit.wavelength_um)),
        refracted: refracted(packings, lit.wavelength_um),
        emissivity: of(|(emissivity, _)| *emissivity),
        l_emitted: of(|(_, radiance)| radiance.l_emitted),
        l_reflected: of(|(_, radiance)| radiance.l_reflected),
        l_target: of(|(_, radiance)| radiance.l_target),
        l_blackbody: lit.l_blackbody,
        l_downwelling: lit.l_downwelling,
        path: lit.path,
    }
}

fn refracted(packings: &[Table], um: f64) -> Option<f64> {
    let shares: Option<Vec<f64>> = packings.iter().map(|table| table.opaque_share(um)).collect();
    shares.map(|shares| 1.0 - shares.iter().sum::<f64>() / shares.len() as f64)
}

impl Band {
    /// The radiance that a sensor without noise would measure, compensated for the atmosphere.
    pub fn measured(&self) -> Measured {
        let Estimate { mean, standard_error, .. } = self.l_sensor();
        let l = [mean, standard_error];
        Measured::at_sensor(self.wavelength_um, l, self.l_downwelling, self.path)
    }

    /// Radiance that reaches the sensor.
    pub fn l_sensor(&self) -> Estimate {
        self.path.map_or(self.l_target, |(transmittance, l_path)| Estimate {
            mean: radiometry::at_sensor(self.l_target.mean, transmittance, l_path),
            standard_error: transmittance * self.l_target.standard_error,
            half_width: transmittance * self.l_target.half_width,
            rays_standard_error: transmittance * self.l_target.rays_standard_error,
            spread: self.l_target.spread.map(|spread| transmittance * spread),
            trapped: transmittance * self.l_target.trapped,
        })
    }

    /// Emissivity by Eq. 3, from the radiance that leaves the target under a cold black sky, and
    /// its standard error.
    pub fn emissivity_eq3(&self, temperature: Temperature) -> [f64; 2] {
        let l_blackbody = radiometry::planck(self.wavelength_um, temperature.k);
        let emissivity = radiometry::emissivity(self.l_emitted.mean, l_blackbody, 0.0);
        let slope = radiometry::planck_derivative(self.wavelength_um, temperature.k);
        let errors = [self.l_emitted.standard_error, slope * temperature.error_k, 0.0];
        [emissivity, radiometry::emissivity_error(emissivity, l_blackbody, 0.0, errors)]
    }
}

/// Eq. 2 in each band, for a target of one temperature.
pub fn retrieve(bands: &[Band], temperature: Temperature, assumed: Assumed) -> Vec<Retrieved> {
    bands.iter().map(|band| Retrieved::new(&band.measured(), temperature, assumed)).collect()
}

/// Where the models of facets do not hold: the first and the last band of each run, um.
pub fn not_valid_um(bands: &[Band]) -> Vec<[f64; 2]> {
    let runs = bands.chunk_by(|a, b| a.valid == b.valid).filter(|run| !run[0].valid);
    runs.map(|run| [run[0].wavelength_um, run[run.len() - 1].wavelength_um]).collect()
}
