//! The noise of the sensor.

use super::bands::Bands;
use crate::radiometry::planck_derivative;
use crate::scene::Noise;
use crate::support::math;
use crate::support::random::{Purpose, Source};

/// Gaussian noise, independent in every pixel and band.
pub(super) struct Detectors {
    /// Noise-equivalent radiance by band, W m-2 sr-1 um-1.
    nedl: Vec<f64>,
    source: Source,
}

impl Detectors {
    pub(super) fn new(noise: Noise, temperature_k: f64, bands: &Bands) -> Self {
        let slope: Vec<f64> =
            bands.nodes_um.iter().map(|&um| planck_derivative(um, temperature_k)).collect();
        let of = |band| {
            let of_nedt = || noise.nedt_k.unwrap_or_default() * bands.mean(band, &slope);
            noise.nedl_w_m2_sr_um.unwrap_or_else(of_nedt)
        };
        let nedl = (0..bands.centres_um.len()).map(of).collect();
        Self { nedl, source: Source::new(noise.seed, Purpose::SensorNoise) }
    }

    /// Adds noise to the radiance of a pixel, and its share to the standard errors.
    pub(super) fn add(&self, pixel: u64, l: &mut [f32], errors: &mut [f32]) {
        let mut random = self.source.stream(pixel);
        for (band, nedl) in self.nedl.iter().enumerate() {
            // Box and Muller's method.
            let [u, v] = random.pair();
            let normal = (-2.0 * math::log(1.0 - u)).sqrt() * math::cos(std::f64::consts::TAU * v);
            l[band] = (f64::from(l[band]) + nedl * normal) as f32;
            errors[band] = math::hypot(f64::from(errors[band]), *nedl) as f32;
        }
    }
}
