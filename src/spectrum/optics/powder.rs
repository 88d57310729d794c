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
    /// What was fitted, and its source.
    pub citation: String,
    /// The shipped set of optical constants that the changes start from.
    pub constants: String,
    /// Wavelengths in which the form holds, um.
    pub range_um: [f64; 2],
    /// Root mean square error in emissivity against the sample fitted.
    pub rms: f64,
    /// The same against a sample that was not fitted.
    pub rms_other_sample: f64,
    /// The largest error against the sample fitted, with its sign.
    pub largest_error: f64,
    /// Where it is, um.
    pub largest_error_at_um: f64,
    /// Where the sample has its Christiansen maximum, um: the fit flattens its slope there.
    pub christiansen_um: f64,
    /// Weight of that slope (per um) among the errors.
    pub christiansen_weight: f64,
    /// The numbers that were fitted, by their place in the file.
    pub fitted: Vec<String>,
    /// Weight of the ordinary ray in Rs and T, the extraordinary ray having the rest.
    pub ordinary_weight: f64,
    /// Added to the extraordinary ray's eps_inf.
    #[serde(default)]
    pub extraordinary_eps_inf_shift: f64,
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
/// grain damps. Rs is at normal incidence. It is a fit, valid in its range only.
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
        let ordinary = changed(&crystal.ordinary);
        let mut extraordinary = changed(&crystal.extraordinary);
        extraordinary.eps_inf += parameters.extraordinary_eps_inf_shift;
        Self { parameters, ordinary, extraordinary }
    }

    /// Emissivity at a wavelength in um.
    pub fn emissivity(&self, wavelength_um: f64) -> f64 {
        let (o, e) = (self.ordinary.index(wavelength_um), self.extraordinary.index(wavelength_um));
        let weight = self.parameters.ordinary_weight;
        let mean = |o: f64, e: f64| weight * o + (1.0 - weight) * e;
        let rs = mean(normal_reflectance(o), normal_reflectance(e));
        let Surface { a, c } = self.parameters.surface;
        let surface = a * rs * (1.0 - c) / (1.0 - c * rs);
        let volume = self.parameters.volume.as_ref().map_or(0.0, |&Volume { b, r0, d_um, m }| {
            let transmitted = |index: Complex64| {
                let x = 4.0 * PI * index.im * d_um / wavelength_um;
                m.map_or_else(|| (-x).exp(), |m| (1.0 + x / m).powf(-m))
            };
            let t = mean(transmitted(o), transmitted(e));
            b * (1.0 - rs) * t * rs / (rs + r0)
        });
        1.0 - surface - volume
    }
}

#[cfg(test)]
mod tests {
    use crate::spectrum::Spectrum;

    /// The values are those of scripts/fit_powder.py, which computes them on its own.
    #[test]
    fn shipped_forms_give_the_values_of_the_script_that_fits_them() {
        for (name, values) in [
            ("quartz_fine", [0.792_105_0, 0.756_704_8, 0.889_180_9, 0.824_756_7, 0.928_349_4]),
            ("quartz_medium", [0.511_960_2, 0.449_651_1, 0.905_006_0, 0.932_085_2, 0.889_705_4]),
            ("quartz_coarse", [0.430_856_0, 0.381_030_5, 0.890_970_1, 0.941_785_8, 0.864_712_2]),
        ] {
            let spectrum = Spectrum::builtin(name).expect("shipped");
            for (um, value) in [8.5, 8.95, 10.0, 11.0, 12.5].into_iter().zip(values) {
                let emissivity = spectrum.emissivity(um).expect("in range");
                assert!((emissivity - value).abs() < 1e-6, "{name} at {um}: {emissivity}");
            }
        }
    }

    /// What they owe to the measured powders in known features, without a measured file.
    #[test]
    fn shipped_forms_have_the_features_of_measured_quartz() {
        for (name, christiansen_um, at_least, most_fitted) in [
            ("quartz_fine", 7.354, 0.997, 12),
            ("quartz_medium", 7.344, 0.9995, 11),
            ("quartz_coarse", 7.344, 0.9995, 9),
        ] {
            let spectrum = Spectrum::builtin(name).expect("shipped");
            let um: Vec<f64> = (730..=1400).map(|i| f64::from(i) / 100.0).collect();
            let curve: Vec<f64> =
                um.iter().map(|&um| spectrum.emissivity(um).expect("in range")).collect();
            let found = crate::spectrum::features::features(&um, &curve);
            let christiansen = found.christiansen.expect("a maximum within the range");
            assert!(
                (christiansen.wavelength_um - christiansen_um).abs() < 0.05,
                "{name}: {christiansen:?}"
            );
            assert!(christiansen.emissivity > at_least, "{name}: {christiansen:?}");
            let doublet = found.reststrahlen.expect("a doublet");
            assert!((doublet.peak.wavelength_um - 8.627).abs() < 0.02, "{name}: {doublet:?}");
            let Spectrum::Builtin(_, form) = spectrum else { panic!("a closed form") };
            assert!(form.parameters.fitted.len() <= most_fitted, "{name}");
        }
    }
}
