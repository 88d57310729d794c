//! Draws from a mixture of normal distributions within bounds, by Gibbs' sampler.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::support::math;
use crate::support::random::{Purpose, Source, Stream};

/// A normal distribution.
#[derive(Debug, Clone)]
pub struct Component {
    /// Its mean.
    pub mean: DVector<f64>,
    /// The inverse of its covariance.
    pub precision: DMatrix<f64>,
}

/// Sweeps over all parameters for each draw.
const SWEEPS: usize = 12;

/// Beyond this many standard deviations the tail of a normal distribution is taken as exponential.
const TAIL: f64 = 6.0;

/// Draws from components in proportion to their weights, within the bounds of each parameter.
pub fn draws(
    components: &[&Component],
    weights: &[f64],
    bounds: &[[f64; 2]],
    number: usize,
    seed: u64,
) -> Vec<DVector<f64>> {
    let sum: f64 = weights.iter().sum();
    let standard = Normal::standard();
    let mut random = Source::new(seed, Purpose::Posterior).stream(0);
    let (mut component, mut reached) = (0, weights[0]);
    let inside = |mean: &DVector<f64>| {
        DVector::from_fn(mean.len(), |i, _| mean[i].clamp(bounds[i][0], bounds[i][1]))
    };
    let mut x = inside(&components[0].mean);
    (0..number)
        .map(|draw| {
            // Evenly spaced over the weights, so that each component has its share.
            let at = (draw as f64 + 0.5) / number as f64 * sum;
            while reached < at && component + 1 < weights.len() {
                component += 1;
                reached += weights[component];
                x = inside(&components[component].mean);
            }
            let Component { mean, precision } = components[component];
            for _ in 0..SWEEPS {
                for i in 0..x.len() {
                    let off = precision.row(i).transpose().dot(&(&x - mean))
                        - precision[(i, i)] * (x[i] - mean[i]);
                    let sd = precision[(i, i)].sqrt().recip();
                    let middle = mean[i] - off * sd * sd;
                    let [low, high] = bounds[i].map(|bound| (bound - middle) / sd);
                    x[i] = middle + sd * between(&standard, [low, high], &mut random);
                    x[i] = x[i].clamp(bounds[i][0], bounds[i][1]);
                }
            }
            x.clone()
        })
        .collect()
}

/// A number of the standard normal distribution between two bounds.
fn between(standard: &Normal, [low, high]: [f64; 2], random: &mut Stream) -> f64 {
    let [share, _] = random.pair();
    if low > 0.0 {
        // The lower tail keeps its digits.
        return -between_of(standard, [-high, -low], share);
    }
    between_of(standard, [low, high], share)
}

fn between_of(standard: &Normal, [low, high]: [f64; 2], share: f64) -> f64 {
    if high < -TAIL {
        // Nearly exponential below the bound, cut at the other one.
        let rate = -high;
        let cut = -math::expm1(rate * (low - high));
        return high + math::log1p(-share * cut) / rate;
    }
    let (from, to) = (standard.cdf(low), standard.cdf(high));
    standard.inverse_cdf(from + share * (to - from)).clamp(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_and_sd(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
    }

    fn of(bounds: [[f64; 2]; 2], mean: [f64; 2]) -> [(f64, f64); 2] {
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.2, 1.2, 1.0]);
        let precision = covariance.try_inverse().expect("regular");
        let component = Component { mean: DVector::from_row_slice(&mean), precision };
        let draws = draws(&[&component], &[1.0], &bounds, 20_000, 3);
        [0, 1].map(|i| mean_and_sd(&draws.iter().map(|draw| draw[i]).collect::<Vec<_>>()))
    }

    #[test]
    fn without_bounds_the_moments_are_those_of_the_distribution() {
        let [a, b] = of([[-1e9, 1e9]; 2], [1.0, -2.0]);
        assert!((a.0 - 1.0).abs() < 0.06 && (a.1 - 2.0).abs() < 0.05, "{a:?}");
        assert!((b.0 + 2.0).abs() < 0.03 && (b.1 - 1.0).abs() < 0.03, "{b:?}");
    }

    /// Above its mean a normal distribution has the mean sqrt(2 / pi).
    #[test]
    fn bounds_cut_as_in_closed_form() {
        let [_, b] = of([[-1e9, 1e9], [-2.0, 1e9]], [1.0, -2.0]);
        assert!((b.0 + 2.0 - (2.0 / std::f64::consts::PI).sqrt()).abs() < 0.03, "{b:?}");
        // Ten standard deviations beyond the mean the excess is nearly 1 / 10.
        let [_, far] = of([[-1e9, 1e9], [8.0, 1e9]], [1.0, -2.0]);
        assert!((far.0 - 8.0 - 0.098).abs() < 0.01, "{far:?}");
    }

    #[test]
    fn the_same_seed_gives_the_same_draws() {
        assert_eq!(of([[0.0, 1.0]; 2], [0.5, 0.5]), of([[0.0, 1.0]; 2], [0.5, 0.5]));
    }
}
