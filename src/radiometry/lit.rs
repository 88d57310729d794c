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
    /// Black-body radiance at the temperature of each material, layer by layer.
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
        let (weight, radiance) = histogram.seen(self.sources());
        (Mean { mean: 1.0 - weight.mean, ..weight }, radiance)
    }

    /// Radiance at the sensor for a radiance that leaves the target.
    pub fn l_sensor(&self, l_target: f64) -> f64 {
        self.path
            .map_or(l_target, |(transmittance, l_path)| at_sensor(l_target, transmittance, l_path))
    }

    /// The sources for [`Histogram::seen`].
    pub fn sources(&self) -> Sources<'_> {
        Sources {
            reflectance: &self.reflectance,
            l_blackbody: &self.l_blackbody_of,
            l_sky: &self.l_sky,
        }
    }
}
