//! Radiance as the observation: temperature and calibration offset join the soil's parameters.

use nalgebra::DMatrix;

use super::estimation::{Evaluated, Model, Observed, Parameter};
use crate::radiometry::{Measured, Temperature, planck, planck_derivative};
use crate::support::math;

/// The radiance of a soil, in units of the contrast of a black body at a first temperature with the
/// sky: (L - L_d) / (B(T_0) - L_d). At that temperature, and without an offset, it is the
/// emissivity (Eq. 2).
pub struct Radiance<'a> {
    soil: &'a dyn Model,
    parameters: Vec<Parameter>,
    um: Vec<f64>,
    l_downwelling: Vec<f64>,
    /// B(T_0) - L_d in each band.
    contrast: Vec<f64>,
    /// Relative standard error of the sky's radiance.
    downwelling_error: f64,
}

/// The names of its parameters beside the soil's.
pub const NAMES: [&str; 2] = ["temperature", "offset"];

/// Standard deviation of the temperature's prior beyond the error of the separation, K.
const TEMPERATURE_K: f64 = 3.0;
/// Standard deviation of the calibration offset's prior, as a share of the mean contrast.
const OFFSET: f64 = 0.01;

impl<'a> Radiance<'a> {
    /// The model and its observations. `first` is the temperature T_0 with its standard error.
    pub fn new(
        soil: &'a dyn Model,
        measured: &[Measured],
        first: Temperature,
        downwelling_error: f64,
    ) -> (Self, Observed) {
        let um: Vec<f64> = measured.iter().map(|m| m.wavelength_um).collect();
        let contrast: Vec<f64> =
            measured.iter().map(|m| planck(m.wavelength_um, first.k) - m.l_downwelling).collect();
        let of = |of: fn(&Measured) -> f64| -> Vec<f64> {
            measured.iter().zip(&contrast).map(|(m, contrast)| of(m) / contrast).collect()
        };
        let observed = Observed {
            um: um.clone(),
            bands: of(|m| m.l_target - m.l_downwelling),
            errors: of(|m| m.l_target_error).iter().map(|error| error.abs()).collect(),
        };
        let offset = OFFSET * contrast.iter().sum::<f64>() / contrast.len() as f64;
        let sd = math::hypot(first.error_k, TEMPERATURE_K);
        let mut parameters = soil.parameters().to_vec();
        parameters.push(Parameter {
            name: NAMES[0].into(),
            unit: "K".into(),
            prior: first.k,
            prior_standard_deviation: sd,
            bounds: [first.k - 8.0 * sd, first.k + 8.0 * sd],
        });
        parameters.push(Parameter {
            name: NAMES[1].into(),
            unit: "W m-2 sr-1 um-1".into(),
            prior: 0.0,
            prior_standard_deviation: offset,
            bounds: [-8.0 * offset, 8.0 * offset],
        });
        let l_downwelling = measured.iter().map(|m| m.l_downwelling).collect();
        (Self { soil, parameters, um, l_downwelling, contrast, downwelling_error }, observed)
    }

    /// The same with other priors.
    #[must_use]
    pub fn with(self, parameters: Vec<Parameter>) -> Self {
        Self { parameters, ..self }
    }

    /// B(T) - L_d in a band, in units of the contrast.
    fn warmth(&self, band: usize, kelvin: f64) -> f64 {
        (planck(self.um[band], kelvin) - self.l_downwelling[band]) / self.contrast[band]
    }
}

impl Model for Radiance<'_> {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn evaluate(&self, x: &[f64]) -> Evaluated {
        let (of_soil, [kelvin, offset]) = (&x[..x.len() - 2], [x[x.len() - 2], x[x.len() - 1]]);
        let soil = self.soil.evaluate(of_soil);
        let bands = 0..self.um.len();
        let warmth: Vec<f64> = bands.clone().map(|band| self.warmth(band, kelvin)).collect();
        let scaled =
            |slopes: Vec<f64>| slopes.iter().zip(&warmth).map(|(slope, w)| slope * w).collect();
        let mut slopes: Vec<Vec<f64>> = soil.slopes.into_iter().map(scaled).collect();
        let by_kelvin = |band: usize| {
            soil.bands[band] * planck_derivative(self.um[band], kelvin) / self.contrast[band]
        };
        slopes.push(bands.clone().map(by_kelvin).collect());
        slopes.push(self.contrast.iter().map(|contrast| 1.0 / contrast).collect());
        let value = |band: usize| soil.bands[band] * warmth[band] + offset / self.contrast[band];
        Evaluated { bands: bands.map(value).collect(), slopes }
    }

    fn bands(&self, x: &[f64]) -> Vec<f64> {
        let (of_soil, [kelvin, offset]) = (&x[..x.len() - 2], [x[x.len() - 2], x[x.len() - 1]]);
        let soil = self.soil.bands(of_soil);
        let value = |(band, emissivity): (usize, f64)| {
            emissivity * self.warmth(band, kelvin) + offset / self.contrast[band]
        };
        soil.into_iter().enumerate().map(value).collect()
    }

    fn covariance(&self, x: &[f64]) -> DMatrix<f64> {
        let (of_soil, kelvin) = (&x[..x.len() - 2], x[x.len() - 2]);
        let mut all = self.soil.covariance(of_soil);
        let n = self.um.len();
        let emissivity = self.soil.evaluate(of_soil).bands;
        let warmth: Vec<f64> = (0..n).map(|band| self.warmth(band, kelvin)).collect();
        // The sky is off by one factor in all bands.
        let by_sky = |band: usize| {
            (1.0 - emissivity[band]) * self.downwelling_error * self.l_downwelling[band]
                / self.contrast[band]
        };
        let by_sky: Vec<f64> = (0..n).map(by_sky).collect();
        for i in 0..n {
            for j in 0..n {
                all[(i, j)] = all[(i, j)] * warmth[i] * warmth[j] + by_sky[i] * by_sky[j];
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inverse::linear::Linear;

    fn parameter(prior: f64) -> Parameter {
        let (name, unit) = (String::new(), String::new());
        Parameter { name, unit, prior, prior_standard_deviation: 0.1, bounds: [0.0, 1.0] }
    }

    #[test]
    fn every_derivative_is_that_of_differences_and_eq_2_holds_at_the_first_temperature() {
        let um: Vec<f64> = (0..9).map(|i| 8.0 + 0.3 * f64::from(i)).collect();
        let ends =
            [0.7, 0.4].map(|e| um.iter().map(|um| e + 0.05 * math::sin_cos(*um).0).collect());
        let errors = [vec![0.01; 9], vec![0.02; 9]];
        let parameters = [0.3, 0.4, 0.96].map(parameter).to_vec();
        let soil = Linear { um: um.clone(), ends, errors, parameters };
        let at = |um: f64| Measured::at_sensor(um, [7.0, 0.01], planck(um, 250.0), None);
        let measured: Vec<Measured> = um.iter().map(|&um| at(um)).collect();
        let first = Temperature { k: 300.0, error_k: 0.5 };
        let (model, observed) = Radiance::new(&soil, &measured, first, 0.02);
        let eq_2 = crate::radiometry::emissivity(7.0, planck(8.0, 300.0), planck(8.0, 250.0));
        assert!((observed.bands[0] - eq_2).abs() < 1e-14);
        let x = [0.3, 0.4, 0.96, 301.0, 0.02];
        assert_eq!(model.parameters().len(), x.len());
        let slopes = model.evaluate(&x).slopes;
        for place in 0..x.len() {
            let step = 1e-5 * x[place];
            let moved = |step: f64| {
                let mut x = x;
                x[place] += step;
                model.evaluate(&x).bands
            };
            for (band, (up, down)) in moved(step).iter().zip(moved(-step)).enumerate() {
                let found = (up - down) / (2.0 * step);
                assert!((found / slopes[place][band] - 1.0).abs() < 1e-5, "{place} {band} {found}");
            }
        }
        let at_first = model.evaluate(&[0.3, 0.4, 0.96, 300.0, 0.0]).bands;
        assert_eq!(at_first.len(), 9);
        for (a, b) in at_first.iter().zip(soil.evaluate(&[0.3, 0.4, 0.96]).bands) {
            assert!((a - b).abs() < 1e-14);
        }
    }
}
