//! The closed form of a powder's emissivity.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde::Deserialize;

use super::{Axes, Axis, Crystal, normal_reflectance};

use crate::support::math;

/// Parameters of [`PowderForm`], from a file in spectra/. Other keys of the file are for the script
/// that fits them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PowderParameters {
    /// The powder; it says that the form is a fit.
    pub title: String,
    /// The fitted data and their source.
    pub citation: String,
    /// The shipped set of optical constants that the changes apply to.
    pub constants: String,
    /// Range of wavelengths in which the form holds, um.
    pub range_um: [f64; 2],
    /// Root mean square error in emissivity for the fitted sample.
    pub rms: f64,
    /// The same for a sample that was not fitted.
    pub rms_other_sample: f64,
    /// The fitted numbers, by their place in the file.
    pub fitted: Vec<String>,
    /// Weight of the ordinary ray in Rs and T; the extraordinary ray has the rest.
    pub ordinary_weight: f64,
    /// Added to the extraordinary ray's eps_inf.
    #[serde(default)]
    pub extraordinary_eps_inf_shift: f64,
    /// Surface reflection.
    pub surface: Surface,
    /// Volume scattering, if there is any.
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
    /// Shape of the distribution of path lengths, T = (1 + x/m)^-m. Default: exp(-x).
    #[serde(default)]
    m: Option<f64>,
}

/// A change to some oscillators, which the file names by their resonance.
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
/// with surface reflection and multiple scattering, and volume scattering that absorption within
/// a grain damps. Rs is the reflectance at normal incidence. The form is a fit, valid only in its
/// range.
#[derive(Debug, Clone, PartialEq)]
pub struct PowderForm {
    /// The parameters, with their range and source.
    pub parameters: PowderParameters,
    ordinary: Axis,
    extraordinary: Axis,
}

impl PowderForm {
    /// The form of one size fraction, from the constants of a uniaxial crystal with the changes of the
    /// fit.
    ///
    /// # Panics
    /// If the crystal is not uniaxial.
    pub fn new(crystal: &Crystal, parameters: PowderParameters) -> Self {
        let Axes::Uniaxial(axes) = &crystal.axes else { panic!("quartz is uniaxial") };
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
        let [ordinary, mut extraordinary] = [&axes[0], &axes[1]].map(changed);
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
                m.map_or_else(|| math::exp(-x), |m| math::pow(1.0 + x / m, -m))
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

    /// The values are from scripts/fit_powder.py, an independent computation.
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

    /// Known features of measured powders.
    #[test]
    fn shipped_forms_have_the_features_of_measured_quartz() {
        use crate::spectrum::features::{Windows, features};
        for (name, christiansen_um, at_least, most_fitted) in [
            ("quartz_fine", 7.354, 0.997, 12),
            ("quartz_medium", 7.344, 0.9995, 11),
            ("quartz_coarse", 7.344, 0.9995, 9),
        ] {
            let spectrum = Spectrum::builtin(name).expect("shipped");
            let um: Vec<f64> = (730..=1400).map(|i| f64::from(i) / 100.0).collect();
            let curve: Vec<f64> =
                um.iter().map(|&um| spectrum.emissivity(um).expect("in range")).collect();
            let found = features(&um, &curve, Windows::quartz());
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
