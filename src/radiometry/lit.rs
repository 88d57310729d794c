//! What a band's radiance depends on besides the bed.

use super::at_sensor;
use crate::histogram::{Histogram, Mean, Radiance, Sources};

/// What there is in one band to reflect and to emit, and what lies before the sensor: everything besides the geometry
/// that the radiance depends on. It serves the histogram of a bed and that of each pixel alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Lit {
    /// Wavelength, um.
    pub wavelength_um: f64,
    /// Reflectance of each symbol of the histogram.
    pub reflectance: Vec<f64>,
    /// Radiance of a black body at the temperature of each material.
    pub l_blackbody_of: Vec<f64>,
    /// Radiance of the sky in each zenith bin.
    pub l_sky: Vec<f64>,
    /// Radiance of a black body at the scene's temperature.
    pub l_blackbody: f64,
    /// Radiance of the sky; of one that depends on the zenith angle what a horizontal Lambertian mirror would return.
    pub l_downwelling: f64,
    /// Transmittance and path radiance between target and sensor, if there is an atmosphere.
    pub path: Option<(f64, f64)>,
}

impl Lit {
    /// The emissivity that a histogram gives towards the sensor, and the radiance that leaves its target.
    pub fn seen(&self, histogram: &Histogram) -> (Mean, Radiance) {
        let (weight, radiance) = histogram.seen(self.sources());
        (Mean { mean: 1.0 - weight.mean, ..weight }, radiance)
    }

    /// What reaches the sensor of a radiance that leaves the target.
    pub fn l_sensor(&self, l_target: f64) -> f64 {
        self.path
            .map_or(l_target, |(transmittance, l_path)| at_sensor(l_target, transmittance, l_path))
    }

    /// For [`Histogram::seen`].
    pub fn sources(&self) -> Sources<'_> {
        Sources {
            reflectance: &self.reflectance,
            l_blackbody: &self.l_blackbody_of,
            l_sky: &self.l_sky,
        }
    }
}
