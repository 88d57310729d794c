//! The closed form of a powder's emissivity.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde::Deserialize;

use super::{Axis, UniaxialCrystal, normal_reflectance};

/// Parameters of [`PowderForm`], as they stand in a file of spectra/.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PowderParameters {
    /// What the powder is, and that the form is a fit.
    pub title: String,
    /// How many numbers were fitted.
    pub numbers_fitted: u32,
    /// Wavelengths in which the form holds, um.
    pub range_um: [f64; 2],
    /// Root mean square error in emissivity against the sample fitted.
    pub rms: f64,
    /// The same against a sample that was not fitted.
    pub rms_other_sample: f64,
    /// What was fitted, and its source.
    pub citation: String,
    /// The share of surface reflection.
    pub surface: Surface,
    /// The share of volume scattering, where there is one.
    #[serde(default)]
    pub volume: Option<Volume>,
    /// Changes to the crystal's oscillators.
    pub changes: Vec<Change>,
}

/// Surface reflection with multiple scattering: a Rs (1 - c) / (1 - c Rs).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    a: f64,
    c: f64,
}

/// Volume scattering: b (1 - Rs) T Rs / (Rs + R0), with T the transmittance of a path of length D.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Volume {
    b: f64,
    r0: f64,
    d_um: f64,
    /// Shape of the distribution of path lengths, T = (1 + x/m)^-m; exp(-x) without it.
    #[serde(default)]
    m: Option<f64>,
}

/// A change to some oscillators, found by their resonance in the crystal's constants.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    rows_per_cm: Vec<f64>,
    #[serde(default)]
    shift_per_cm: f64,
    #[serde(default = "one")]
    strength: f64,
    #[serde(default = "one")]
    damping: f64,
}

fn one() -> f64 {
    1.0
}

/// Emissivity of a quartz powder as a closed semi-empirical form,
///
/// eps = 1 - a Rs (1 - c) / (1 - c Rs) - b (1 - Rs) T Rs / (Rs + R0),
///
/// surface reflection with multiple scattering less volume scattering that absorption within a
/// grain damps. Rs and T weigh the ordinary and the extraordinary ray 2 : 1. It is a fit, valid in
/// its range only.
#[derive(Debug, Clone, PartialEq)]
pub struct PowderForm {
    /// The parameters, with their range and source.
    pub parameters: PowderParameters,
    ordinary: Axis,
    extraordinary: Axis,
}

impl PowderForm {
    /// The form of one size fraction: the crystal's constants, changed where the fit changes them.
    pub fn new(crystal: &UniaxialCrystal, parameters: PowderParameters) -> Self {
        let changed = |axis: &Axis| {
            let mut axis = axis.clone();
            for oscillator in &mut axis.oscillators {
                let row = oscillator.v0_per_cm;
                for change in parameters.changes.iter().filter(|c| c.rows_per_cm.contains(&row)) {
                    oscillator.v0_per_cm += change.shift_per_cm;
                    oscillator.strength *= change.strength;
                    oscillator.damping *= change.damping;
                }
            }
            axis
        };
        let (ordinary, extraordinary) =
            (changed(&crystal.ordinary), changed(&crystal.extraordinary));
        Self { parameters, ordinary, extraordinary }
    }

    /// Emissivity at a wavelength in um.
    pub fn emissivity(&self, wavelength_um: f64) -> f64 {
        let (o, e) = (self.ordinary.index(wavelength_um), self.extraordinary.index(wavelength_um));
        let rs = (2.0 * normal_reflectance(o) + normal_reflectance(e)) / 3.0;
        let Surface { a, c } = self.parameters.surface;
        let surface = a * rs * (1.0 - c) / (1.0 - c * rs);
        let volume = self.parameters.volume.as_ref().map_or(0.0, |&Volume { b, r0, d_um, m }| {
            let transmitted = |index: Complex64| {
                let x = 4.0 * PI * index.im * d_um / wavelength_um;
                m.map_or_else(|| (-x).exp(), |m| (1.0 + x / m).powf(-m))
            };
            let t = (2.0 * transmitted(o) + transmitted(e)) / 3.0;
            b * (1.0 - rs) * t * rs / (rs + r0)
        });
        1.0 - surface - volume
    }
}

#[cfg(test)]
mod tests {
    use crate::spectrum::Spectrum;

    #[test]
    fn shipped_forms_give_their_published_values() {
        for (name, values) in [
            ("quartz_fine", [0.790_498, 0.757_448, 0.892_280, 0.826_067, 0.915_140]),
            ("quartz_medium", [0.509_701, 0.447_547, 0.899_382, 0.933_303, 0.869_533]),
            ("quartz_coarse", [0.430_242, 0.375_540, 0.890_112, 0.942_050, 0.840_175]),
        ] {
            let spectrum = Spectrum::builtin(name).expect("shipped");
            for (um, value) in [8.5, 8.95, 10.0, 11.0, 12.5].into_iter().zip(values) {
                let emissivity = spectrum.emissivity(um).expect("in range");
                assert!((emissivity - value).abs() < 1e-6, "{name} at {um}: {emissivity}");
            }
        }
    }
}
