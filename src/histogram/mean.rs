//! A mean over groups of paths and its standard error.

use crate::support::random::GROUPS;
use crate::support::statistics::{T_95, quantile_95};

/// A mean over paths and how far it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The mean; what trapped paths leave open counts with half of its bound.
    pub mean: f64,
    /// Standard error of the mean, from what the two nets differ by; where fewer groups met the target than there are, so much
    /// more that [`T_95`] holds of it.
    pub standard_error: f64,
    /// Half of what trapped paths leave open: the mean is known no better than that.
    pub trapped: f64,
}

impl Mean {
    /// Half-width of the 95 % interval: the noise of the rays and what trapped paths leave open.
    pub fn half_width(&self) -> f64 {
        T_95 * self.standard_error + self.trapped
    }
}

/// Sums over the paths of each group.
pub(crate) struct Sums {
    pub(crate) value: [f64; GROUPS],
    pub(crate) open: f64,
}

impl Sums {
    pub(super) const fn new() -> Self {
        Self { value: [0.0; GROUPS], open: 0.0 }
    }

    pub(super) fn add(&mut self, counts: &[(u16, i64)], value: f64, open: f64) {
        for &(group, count) in counts {
            self.value[usize::from(group)] += count as f64 * value;
            self.open += count as f64 * open;
        }
    }

    /// The mean over all paths that met the target, as the ratio of two sums: how many paths of a group met it
    /// is itself random.
    ///
    /// One path tells nothing of the spread: then it is the widest that numbers up to `greatest` can have.
    pub(crate) fn mean(&self, met: &[f64; GROUPS], greatest: f64) -> Mean {
        let paths: f64 = met.iter().sum();
        let mean = self.value.iter().sum::<f64>() / paths;
        let standard_error = standard_error(&self.residuals(met), met, greatest);
        Mean { mean, standard_error, trapped: self.open / paths }
    }

    /// What the paths of each group add to the mean beyond what as many average ones would.
    pub(super) fn residuals(&self, met: &[f64; GROUPS]) -> [f64; GROUPS] {
        let paths: f64 = met.iter().sum();
        let mean = self.value.iter().sum::<f64>() / paths;
        std::array::from_fn(|g| (self.value[g] - mean * met[g]) / paths)
    }
}

/// The standard error of a sum over all groups, of which each adds its part. Twins have as many points in the same cells, and chance of their own: what they
/// differ by has the variance of their sum.
///
/// Groups that met nothing know nothing.
pub(super) fn standard_error(parts: &[f64; GROUPS], met: &[f64; GROUPS], greatest: f64) -> f64 {
    let (parts, met) = (parts.as_chunks::<2>().0, met.as_chunks::<2>().0);
    if (0..2).any(|net| met.iter().all(|met| met[net] == 0.0)) {
        return greatest / 2.0;
    }
    let squares: f64 = parts.iter().map(|[a, b]| (a - b).powi(2)).sum();
    // Fewer than there are know less of the spread than `T_95` takes for granted.
    let known = met.iter().filter(|met| **met != [0.0, 0.0]).count();
    let unsure = if known == met.len() { 1.0 } else { quantile_95(known.max(2)) / T_95 };
    squares.sqrt() * unsure
}
