//! A mean over groups of paths and its standard error.

use crate::support::random::GROUPS;
use crate::support::statistics::{T_95, quantile_95};

/// A mean over paths and its errors.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Mean {
    /// The mean. The unknown rest of paths given up counts with the middle of its range.
    pub mean: f64,
    /// Standard error of the mean, from the difference between the two nets. If some groups saw no
    /// target it is inflated, so that 2.12 times it is still a 95 % interval.
    pub standard_error: f64,
    /// Half of the range that paths given up leave open: a bound on the error of the mean.
    pub trapped: f64,
}

impl Mean {
    /// Half-width of the 95 % interval: the noise of the rays and what paths given up leave open.
    pub fn half_width(&self) -> f64 {
        T_95 * self.standard_error + self.trapped
    }
}

/// Sums over the parts of paths of each group, in one band.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sums {
    pub(super) value: [f64; GROUPS],
    /// What paths given up leave open, of all groups.
    pub(super) open: f64,
}

impl Sums {
    pub(crate) const ZERO: Self = Self { value: [0.0; GROUPS], open: 0.0 };

    /// Adds other sums, `factor` times, and a constant for each path that met the target.
    pub(crate) fn add(&mut self, other: &Self, factor: f64, constant: f64, met: &[f64; GROUPS]) {
        for ((sum, value), met) in self.value.iter_mut().zip(&other.value).zip(met) {
            *sum += factor * value + constant * met;
        }
        self.open += factor.abs() * other.open;
    }

    /// The mean over all paths that met the target: the ratio of two sums, since the number of
    /// paths of a group that met it is itself random.
    ///
    /// If the spread is unknown, the standard error is the widest that values up to `greatest` can
    /// have.
    pub(crate) fn mean(&self, met: &[f64; GROUPS], greatest: f64) -> Mean {
        let paths: f64 = met.iter().sum();
        let mean = self.value.iter().sum::<f64>() / paths;
        let standard_error = standard_error(&self.residuals(met), met, greatest);
        Mean { mean, standard_error, trapped: self.open / paths }
    }

    /// How much the paths of each group add to the mean beyond as many average ones.
    pub(super) fn residuals(&self, met: &[f64; GROUPS]) -> [f64; GROUPS] {
        let paths: f64 = met.iter().sum();
        let mean = self.value.iter().sum::<f64>() / paths;
        std::array::from_fn(|g| (self.value[g] - mean * met[g]) / paths)
    }
}

/// The standard error of a sum over all groups.
///
/// Twins have as many points in the same cells, and chance of their own: the variance of their
/// difference is that of their sum. Groups that met nothing know nothing.
pub(super) fn standard_error(parts: &[f64; GROUPS], met: &[f64; GROUPS], greatest: f64) -> f64 {
    let (parts, met) = (parts.as_chunks::<2>().0, met.as_chunks::<2>().0);
    if (0..2).any(|net| met.iter().all(|met| met[net] == 0.0)) {
        return greatest / 2.0;
    }
    let squares: f64 = parts.iter().map(|[a, b]| (a - b).powi(2)).sum();
    // Fewer groups know less of the spread than `T_95` assumes.
    let known = met.iter().filter(|met| **met != [0.0, 0.0]).count();
    let unsure = if known == met.len() { 1.0 } else { quantile_95(known.max(2)) / T_95 };
    squares.sqrt() * unsure
}
