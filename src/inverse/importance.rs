//! Draws from a density that is known but for a factor, by importance sampling.
//!
//! Points of Student's t distribution are drawn within the bounds and weighed by the density over
//! that of the draw. Its tails are longer than those of a normal distribution, so that no weight is
//! large. Rounds of few points find where to draw: about the mean and by the covariance of those
//! before (Cappé et al., J. Comput. Graph. Stat. 13(4), 907, 2004). Where a few of them have all the
//! weight, powers of the weights are taken first. Of the last round, points are taken in proportion
//! to their weights.

use nalgebra::{DMatrix, DVector};

use super::kernel::{lower_solve, root};
use crate::support::math;
use crate::support::random::{Purpose, Source, Stream};

/// Points of each round before, most such rounds, and as many points as must count for the next.
const FEWER: usize = 256;
const ROUNDS: usize = 12;
const ENOUGH: f64 = 64.0;

/// Degrees of freedom of Student's t distribution.
const FREEDOM: usize = 5;

/// Its scale over the covariance of the points before.
const WIDER: f64 = 1.5;

/// Draws for a point within the bounds, at most.
const TRIES: usize = 1000;

/// Where points are drawn.
#[derive(Debug, Clone)]
pub struct Proposal {
    /// The middle, within the bounds.
    pub middle: DVector<f64>,
    /// The covariance.
    pub covariance: DMatrix<f64>,
}

/// Draws, each as likely.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// The draws.
    pub draws: Vec<DVector<f64>>,
    /// As many independent draws tell as much.
    pub effective: f64,
}

/// Gives the weights of points from the logarithm of the density by which each was drawn.
pub type Weigh<'a> = dyn Fn(&[DVector<f64>], &[f64]) -> Vec<f64> + 'a;

/// Draws `number` points, from as many in the last round, within the bounds of each parameter. Weights are the density over that of the
/// draw, but for a factor that all of a round have.
pub fn draws(
    first: Proposal,
    bounds: &[[f64; 2]],
    weigh: &Weigh,
    number: usize,
    seed: u64,
) -> Drawn {
    let mut random = Source::new(seed, Purpose::Posterior).stream(0);
    let mut proposal = first;
    for round in 0..ROUNDS {
        let (points, weights) = proposal.weighed(bounds, weigh, FEWER, &mut random);
        let power = power(&weights);
        let tempered: Vec<f64> = weights.iter().map(|w| math::pow(*w, power)).collect();
        proposal = moments(&points, &tempered);
        if round > 0 && power == 1.0 {
            break;
        }
    }
    let (points, weights) = proposal.weighed(bounds, weigh, number, &mut random);
    let draws = in_proportion(&weights, number).map(|i| points[i].clone()).collect();
    Drawn { draws, effective: effective(weights.iter().copied()) }
}

impl Proposal {
    /// Points within the bounds and their weights.
    fn weighed(
        &self,
        bounds: &[[f64; 2]],
        weigh: &Weigh,
        number: usize,
        random: &mut Stream,
    ) -> (Vec<DVector<f64>>, Vec<f64>) {
        let scale = root(&(&self.covariance * WIDER));
        let points: Vec<DVector<f64>> =
            (0..number).map(|_| within(&self.middle, scale.l_dirty(), bounds, random)).collect();
        let ln_density = |x: &DVector<f64>| {
            let squares = lower_solve(&scale, &(x - &self.middle)).norm_squared();
            let power = 0.5 * (FREEDOM + x.len()) as f64;
            -power * math::log1p(squares / FREEDOM as f64)
        };
        let drawn: Vec<f64> = points.iter().map(ln_density).collect();
        let weights = weigh(&points, &drawn);
        (points, weights)
    }
}

/// As many independent draws tell as much as draws with these weights.
fn effective(weights: impl Iterator<Item = f64>) -> f64 {
    let (sum, squares) = weights.fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
    sum * sum / squares
}

/// The greatest power of the weights, up to 1, with which enough points count.
fn power(weights: &[f64]) -> f64 {
    let enough = |power: f64| effective(weights.iter().map(|w| math::pow(*w, power))) >= ENOUGH;
    if enough(1.0) {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..20 {
        let middle = f64::midpoint(low, high);
        if enough(middle) { low = middle } else { high = middle }
    }
    low
}

/// A point of Student's t distribution within the bounds.
fn within(
    middle: &DVector<f64>,
    lower: &DMatrix<f64>,
    bounds: &[[f64; 2]],
    random: &mut Stream,
) -> DVector<f64> {
    let p = middle.len();
    let mut x = middle.clone();
    for _ in 0..TRIES {
        let normal: Vec<f64> = normals(random, p + FREEDOM);
        let squares: f64 = normal[p..].iter().map(|of| of * of).sum();
        let wide = (FREEDOM as f64 / squares).sqrt();
        for i in 0..p {
            let off: f64 = (0..=i).map(|j| lower[(i, j)] * normal[j]).sum();
            x[i] = middle[i] + wide * off;
        }
        if x.iter().zip(bounds).all(|(x, [low, high])| (low..=high).contains(&x)) {
            return x;
        }
    }
    middle.clone()
}

/// Numbers of the standard normal distribution (Box and Muller).
fn normals(random: &mut Stream, number: usize) -> Vec<f64> {
    let pair = || {
        let [radius, turn] = random.pair();
        let radius = (-2.0 * math::log1p(-radius)).sqrt();
        let (sine, cosine) = math::sin_cos(std::f64::consts::TAU * turn);
        [radius * cosine, radius * sine]
    };
    std::iter::repeat_with(pair).flatten().take(number).collect()
}

/// The mean and the covariance of weighed points.
fn moments(points: &[DVector<f64>], weights: &[f64]) -> Proposal {
    let sum: f64 = weights.iter().sum();
    let p = points[0].len();
    let all = || points.iter().zip(weights).map(|(x, weight)| (x, weight / sum));
    let middle = all().fold(DVector::zeros(p), |mean, (x, weight)| mean + x * weight);
    let covariance = all().fold(DMatrix::zeros(p, p), |covariance, (x, weight)| {
        let off = x - &middle;
        covariance + &off * off.transpose() * weight
    });
    Proposal { middle, covariance }
}

/// Places in proportion to their weights, at even distances of the sum of these.
fn in_proportion(weights: &[f64], number: usize) -> impl Iterator<Item = usize> {
    let sum: f64 = weights.iter().sum();
    let (mut place, mut reached) = (0, weights[0]);
    (0..number).map(move |draw| {
        let at = (draw as f64 + 0.5) / number as f64 * sum;
        while reached < at && place + 1 < weights.len() {
            place += 1;
            reached += weights[place];
        }
        place
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBER: usize = 2048;

    /// A normal distribution of two parameters with standard deviations 2 and 1, correlated by .6.
    fn of(bounds: [[f64; 2]; 2], mean: [f64; 2]) -> Drawn {
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.2, 1.2, 1.0]);
        let mean = DVector::from_row_slice(&mean);
        let root = root(&covariance);
        let weigh = |points: &[DVector<f64>], drawn: &[f64]| -> Vec<f64> {
            let ln = |x: &DVector<f64>| -0.5 * lower_solve(&root, &(x - &mean)).norm_squared();
            let ln: Vec<f64> = points.iter().zip(drawn).map(|(x, drawn)| ln(x) - drawn).collect();
            let greatest = ln.iter().copied().fold(f64::MIN, f64::max);
            ln.iter().map(|ln| math::exp(ln - greatest)).collect()
        };
        let middle = DVector::from_fn(2, |i, _| mean[i].clamp(bounds[i][0], bounds[i][1]));
        draws(Proposal { middle, covariance: covariance.clone() }, &bounds, &weigh, NUMBER, 3)
    }

    fn mean_and_sd(drawn: &Drawn, place: usize) -> (f64, f64) {
        let n = drawn.draws.len() as f64;
        let values = || drawn.draws.iter().map(|draw| draw[place]);
        let mean = values().sum::<f64>() / n;
        (mean, (values().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
    }

    #[test]
    fn without_bounds_the_moments_are_those_of_the_distribution() {
        let drawn = of([[-1e9, 1e9]; 2], [1.0, -2.0]);
        let [a, b] = [0, 1].map(|place| mean_and_sd(&drawn, place));
        assert!((a.0 - 1.0).abs() < 0.15 && (a.1 - 2.0).abs() < 0.15, "{a:?}");
        assert!((b.0 + 2.0).abs() < 0.08 && (b.1 - 1.0).abs() < 0.08, "{b:?}");
        // A proposal that is wider by 1.5 and has longer tails loses some.
        let all = NUMBER as f64;
        assert!((0.5 * all..0.95 * all).contains(&drawn.effective), "{}", drawn.effective);
    }

    /// Above its mean a normal distribution has the mean sqrt(2 / pi).
    #[test]
    fn bounds_cut_as_in_closed_form() {
        let b = mean_and_sd(&of([[-1e9, 1e9], [-2.0, 1e9]], [1.0, -2.0]), 1);
        assert!((b.0 + 2.0 - (2.0 / std::f64::consts::PI).sqrt()).abs() < 0.06, "{b:?}");
        // Ten standard deviations beyond the mean the excess is nearly 1 / 10. It is narrower by ten
        // than the first proposal.
        let far = mean_and_sd(&of([[-1e9, 1e9], [8.0, 1e9]], [1.0, -2.0]), 1);
        assert!((far.0 - 8.0 - 0.098).abs() < 0.015, "{far:?}");
    }

    /// A density along a bent line, x_1 = x_0^2 / 2 +- .5: the first proposal knows of no bend.
    #[test]
    fn a_bent_density_is_followed() {
        let weigh = |points: &[DVector<f64>], drawn: &[f64]| -> Vec<f64> {
            let off = |x: &DVector<f64>| (x[1] - 0.5 * x[0] * x[0]) / 0.5;
            let ln = |x: &DVector<f64>| -0.5 * (x[0] * x[0] + off(x).powi(2));
            points.iter().zip(drawn).map(|(x, drawn)| math::exp(ln(x) - drawn)).collect()
        };
        let covariance = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.25]);
        let first = Proposal { middle: DVector::zeros(2), covariance };
        let drawn = draws(first, &[[-9.0, 9.0]; 2], &weigh, NUMBER, 5);
        let [a, b] = [0, 1].map(|place| mean_and_sd(&drawn, place));
        // x_0^2 has mean 1 and variance 2.
        assert!(a.0.abs() < 0.15 && (a.1 - 1.0).abs() < 0.15, "{a:?}");
        assert!((b.0 - 0.5).abs() < 0.1 && (b.1 - 0.75_f64.sqrt()).abs() < 0.15, "{b:?}");
    }

    #[test]
    fn the_same_seed_gives_the_same_draws() {
        let [a, b] = [0, 1].map(|_| of([[0.0, 1.0]; 2], [0.5, 0.5]).draws);
        assert_eq!(a, b);
    }
}
