//! What a model misses: a smooth curve beyond what its parameters can make.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::kernel::{self, Smoothness};

/// The discrepancy of a model: a curve beyond what its parameters can make.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Discrepancy {
    /// Its standard deviation, in emissivity: the root mean square over the bands.
    pub standard_deviation: f64,
    /// The length over which it is correlated, um.
    pub length_um: f64,
    /// How it changes over that length.
    pub smoothness: Smoothness,
    /// Whether it grows with the depth of the features, 1 - emissivity; else it is the same in all
    /// bands.
    pub by_depth: bool,
}

/// Standard deviations and lengths of the grid. A discrepancy longer than the window is a level,
/// one shorter than the features of quartz is noise.
const DEVIATIONS: [f64; 12] =
    [0.0005, 0.001, 0.002, 0.003, 0.0045, 0.0065, 0.01, 0.014, 0.02, 0.03, 0.045, 0.07];
const LENGTHS_UM: [f64; 6] = [0.06, 0.12, 0.22, 0.4, 0.75, 1.4];

/// What is left of a discrepancy by depth where there is no feature, in parts of the usual depth.
const WITHOUT_FEATURES: f64 = 0.2;

impl Discrepancy {
    /// All that are considered, each as likely beforehand.
    pub fn grid() -> Vec<Self> {
        let all = [Smoothness::Rough, Smoothness::Smooth]
            .map(|smoothness| [(smoothness, false), (smoothness, true)]);
        let of = |(smoothness, by_depth): (Smoothness, bool)| {
            LENGTHS_UM.into_iter().flat_map(move |length_um| {
                DEVIATIONS.map(|standard_deviation| Self {
                    standard_deviation,
                    length_um,
                    smoothness,
                    by_depth,
                })
            })
        };
        all.into_iter().flatten().flat_map(of).collect()
    }

    /// The standard deviation in each band of a fitted curve.
    pub fn deviations(self, fitted: &[f64]) -> Vec<f64> {
        let form = if self.by_depth { depths(fitted) } else { vec![1.0; fitted.len()] };
        form.iter().map(|of| of * self.standard_deviation).collect()
    }

    /// The covariance of bands at wavelengths in um: what is known, and the discrepancy.
    pub fn with(self, known: &DMatrix<f64>, um: &[f64], fitted: &[f64]) -> DMatrix<f64> {
        known + kernel::covariance(um, &self.deviations(fitted), self.length_um, self.smoothness)
    }
}

/// Depths of the features, with a root mean square of 1.
fn depths(fitted: &[f64]) -> Vec<f64> {
    let depth: Vec<f64> = fitted.iter().map(|e| (1.0 - e).max(0.0)).collect();
    let floor = WITHOUT_FEATURES * root_mean_square(&depth).max(f64::EPSILON);
    let raised: Vec<f64> = depth.iter().map(|depth| depth + floor).collect();
    let mean = root_mean_square(&raised);
    raised.iter().map(|depth| depth / mean).collect()
}

/// The root of the mean square.
pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_discrepancy_has_its_standard_deviation_over_the_bands() {
        let um: Vec<f64> = (0..9).map(|i| 8.0 + 0.3 * f64::from(i)).collect();
        let fitted = [1.0, 0.9, 0.7, 0.6, 0.8, 0.9, 0.95, 0.97, 0.98];
        let none = DMatrix::zeros(9, 9);
        for by_depth in [false, true] {
            let (length_um, smoothness) = (0.4, Smoothness::Rough);
            let of = Discrepancy { standard_deviation: 0.02, length_um, smoothness, by_depth };
            let covariance = of.with(&none, &um, &fitted);
            assert!((covariance.trace() / 9.0 - 4e-4).abs() < 1e-12);
            let [flat, deep] = [0, 3].map(|i: usize| covariance[(i, i)].sqrt());
            // Depths of 0 and .4; their root mean square is .18673.
            let expected = if by_depth { (0.4 + 0.037_346) / 0.037_346 } else { 1.0 };
            assert!((deep / flat / expected - 1.0).abs() < 1e-4, "{}", deep / flat);
        }
    }
}
