//! The cheap model beside the traced one: linear mixing of spectra by area.

use nalgebra::DMatrix;

use super::estimation::{Evaluated, Model, Parameter};
use super::kernel::{self, Smoothness};

/// Length over which errors of the spectra are correlated, um.
const LENGTH_UM: f64 = 0.2;

/// Emissivities of fines and grains that are mixed by area, with a spectrally flat component.
pub struct Linear {
    /// Wavelengths, um.
    pub um: Vec<f64>,
    /// Emissivity of the fines and of the grains.
    pub ends: [Vec<f64>; 2],
    /// Their standard errors.
    pub errors: [Vec<f64>; 2],
    /// Share of the fines, share of the flat component, its emissivity.
    pub parameters: Vec<Parameter>,
}

impl Model for Linear {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn evaluate(&self, x: &[f64]) -> Evaluated {
        let [fines, flat, level] = [x[0], x[1], x[2]];
        let [a, b] = &self.ends;
        let mixed = |(a, b): (&f64, &f64)| fines * a + (1.0 - fines) * b;
        let quartz: Vec<f64> = a.iter().zip(b).map(mixed).collect();
        Evaluated {
            bands: quartz.iter().map(|of| (1.0 - flat) * of + flat * level).collect(),
            slopes: vec![
                a.iter().zip(b).map(|(a, b)| (1.0 - flat) * (a - b)).collect(),
                quartz.iter().map(|of| level - of).collect(),
                vec![flat; quartz.len()],
            ],
        }
    }

    fn covariance(&self, x: &[f64]) -> DMatrix<f64> {
        let of = |errors: &[f64], share: f64| {
            let off: Vec<f64> = errors.iter().map(|error| error * share * (1.0 - x[1])).collect();
            kernel::covariance(&self.um, &off, LENGTH_UM, Smoothness::Rough)
        };
        of(&self.errors[0], x[0]) + of(&self.errors[1], 1.0 - x[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::math;

    #[test]
    fn every_derivative_is_that_of_differences() {
        let um: Vec<f64> = (0..9).map(|i| 8.0 + 0.3 * f64::from(i)).collect();
        let ends =
            [0.7, 0.4].map(|e| um.iter().map(|um| e + 0.05 * math::sin_cos(*um).0).collect());
        let errors = [vec![0.01; 9], vec![0.02; 9]];
        let model = Linear { um, ends, errors, parameters: vec![] };
        let x = [0.3, 0.4, 0.96];
        let slopes = model.evaluate(&x).slopes;
        for place in 0..3 {
            let moved = |step: f64| {
                let mut x = x;
                x[place] += step;
                model.evaluate(&x).bands
            };
            for (band, (up, down)) in moved(1e-6).iter().zip(moved(-1e-6)).enumerate() {
                assert!(((up - down) / 2e-6 - slopes[place][band]).abs() < 1e-8);
            }
        }
    }
}
