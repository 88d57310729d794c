//! What a band's radiance depends on besides the geometry.

use super::at_sensor;
use crate::histogram::{Histogram, Mean, Radiance, Sources};

/// Everything besides the geometry that the radiance of one band depends on: reflectances,
/// black-body radiances, sky and atmosphere. It serves histograms of beds and of pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Lit {
    /// Wavelength, um.
    pub wavelength_um: f64,
    /// Reflectance of each symbol of the histogram.
    pub reflectance: Vec<f64>,
    /// Black-body radiance at the temperature of each material.
    pub l_blackbody_of: Vec<f64>,
    /// Radiance of the sky in each zenith bin.
    pub l_sky: Vec<f64>,
    /// Black-body radiance at the scene's temperature.
    pub l_blackbody: f64,
    /// Radiance of the isotropic sky with the same irradiance on a horizontal surface.
    pub l_downwelling: f64,
    /// Transmittance and path radiance of the atmosphere, if there is one.
    pub path: Option<(f64, f64)>,
}

impl Lit {
    /// The emissivity towards the sensor, and the radiance that leaves the target.
    pub fn seen(&self, histogram: &Histogram) -> (Mean, Radiance) {
        let weight = histogram.weight(&self.reflectance);
        let emissivity = Mean { mean: 1.0 - weight.mean, ..weight };
        let alike = self.l_blackbody_of.iter().all(|&l| l == self.l_blackbody);
        let radiance = if alike && self.l_sky.len() == 1 {
            // A path emits all the weight that it does not bring to the sky.
            let times = |mean: f64, l: f64| Mean {
                mean: mean * l,
                standard_error: weight.standard_error * l.abs(),
                trapped: weight.trapped * l.abs(),
            };
            let l_emitted = times(emissivity.mean, self.l_blackbody);
            let l_reflected = times(weight.mean, self.l_sky[0]);
            let sum = super::l_target(l_emitted.mean, l_reflected.mean);
            let l_target = Mean { mean: sum, ..times(1.0, self.l_blackbody - self.l_sky[0]) };
            Radiance { l_emitted, l_reflected, l_target }
        } else {
            histogram.radiance(self.sources())
        };
        (emissivity, radiance)
    }

    /// Radiance at the sensor for a radiance that leaves the target.
    pub fn l_sensor(&self, l_target: f64) -> f64 {
        self.path
            .map_or(l_target, |(transmittance, l_path)| at_sensor(l_target, transmittance, l_path))
    }

    /// The sources for [`Histogram::radiance`].
    pub fn sources(&self) -> Sources<'_> {
        Sources {
            reflectance: &self.reflectance,
            l_blackbody: &self.l_blackbody_of,
            l_sky: &self.l_sky,
        }
    }
}
