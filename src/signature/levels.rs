//! The mean over beds as a sum of levels (multilevel Monte Carlo; Giles, Acta Numerica 24, 259
//! (2015)).
//!
//! Beds dropped as hulls are cheap, but hulls keep fines apart. Dropped on until their fines touch,
//! the same beds change by an amount that differs little from bed to bed. So many hulls carry the
//! spread between beds, and a few pairs of the same drop carry the change:
//!
//! ```text
//! mean = (1/N) sum of h_i, i to N,  +  (1/M) sum of (c_i - h_i), i to M,  M <= N
//! ```
//!
//! with h_i of hulls and c_i of the same drop whose fines touch. Its variance is that of the pairs,
//! z_i = h_i / N + (c_i - h_i) / M, and that of the other hulls, h_i / N. Both are independent.

use crate::histogram::{Estimate, Mean};
use crate::scene::Origin;
use crate::support::statistics::{T_95, quantile_of};
use crate::table::Table;

/// Beds from which on their spread tells how they differ, with their cells as [`OF_CELLS`] further
/// beds. Of fewer it may be small by luck, and the wider of spread and cells counts.
pub(super) const MANY: usize = 5;

/// So many further beds the cells of the views stand for beside the spread of many beds: a run that
/// ends when its interval is narrow favours spreads that came out small, and cells do not (docs:
/// tolerances).
const OF_CELLS: f64 = 3.0;

/// Beds differ by so much of what their cells tell: by .76, .64, .72 and .90 in four recipes.
const OF_SPREAD_BY_CELLS: f64 = 0.8;

/// Which tables are of which level, by their index.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Levels {
    tables: usize,
    /// Beds of the first level: hulls, or all beds where there are no pairs.
    first: Vec<usize>,
    /// Hulls, and the same drop whose fines touch.
    pairs: Vec<[usize; 2]>,
}

/// The variance of the mean by its parts, for other numbers of beds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parts {
    /// Variance between beds of the first level.
    pub(super) first: f64,
    /// Variance between the changes of pairs; 0 without.
    change: f64,
    /// Covariance of a hull with its change.
    both: f64,
    /// Quantile of the interval.
    pub(super) quantile: f64,
}

impl Levels {
    /// The levels of a recipe's beds.
    pub fn of(tables: &[Table]) -> Self {
        let find = |touching: &Table| {
            let is_hull = |t: &&Table| t.origin == Origin::DrawnApart && t.drop == touching.drop;
            touching.drop?;
            tables.iter().position(|t| is_hull(&t))
        };
        let touching = tables.iter().enumerate().filter(|(_, t)| t.origin == Origin::Drawn);
        let pairs: Vec<[usize; 2]> =
            touching.filter_map(|(i, table)| Some([find(table)?, i])).collect();
        let is_second = |i: &usize| pairs.iter().any(|[_, touching]| touching == i);
        let first = (0..tables.len()).filter(|i| !is_second(i)).collect();
        Self { tables: tables.len(), first, pairs }
    }

    /// Of tables of which the first are the touching ones of pairs, whose hulls follow first.
    #[cfg(test)]
    pub(super) fn of_pairs(pairs: usize, drops: usize) -> Self {
        let first = (pairs..pairs + drops).collect();
        let pairs_of = (0..pairs).map(|i| [pairs + i, i]).collect();
        Self { tables: pairs + drops, first, pairs: pairs_of }
    }

    /// The drops.
    pub fn drops(&self) -> usize {
        self.first.len()
    }

    /// The drops that are there as hulls and with fines that touch.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// Of what is there for each table, that of the first level.
    pub(crate) fn first<'a, T>(&'a self, of_tables: &'a [T]) -> impl Iterator<Item = &'a T> {
        self.first.iter().map(|&i| &of_tables[i])
    }

    /// The weight of each table in the mean; some are negative.
    pub fn weights(&self) -> Vec<f64> {
        let mut weights = vec![0.0; self.tables];
        self.first.iter().for_each(|&i| weights[i] += 1.0 / self.first.len() as f64);
        for &[hulls, touching] in &self.pairs {
            weights[hulls] -= 1.0 / self.pairs.len() as f64;
            weights[touching] += 1.0 / self.pairs.len() as f64;
        }
        weights
    }

    /// The estimate from the mean of each table.
    pub fn estimate(&self, of: &[Mean]) -> Estimate {
        if self.pairs.is_empty() {
            return Estimate::of(of);
        }
        let weights = self.weights();
        let sum = |part: &dyn Fn(&Mean, f64) -> f64| -> f64 {
            of.iter().zip(&weights).map(|(mean, &weight)| part(mean, weight)).sum()
        };
        let rays = sum(&|m, weight| (weight * m.standard_error).powi(2)).sqrt();
        let trapped = self.first.iter().map(|&i| of[i].trapped).sum::<f64>() / self.drops() as f64;
        let parts = self.parts(&of.iter().map(|m| m.mean).collect::<Vec<_>>(), None);
        let [n, m] = [self.drops(), self.pairs()].map(|beds| beds as f64);
        let standard_error = parts.variance(n, m).sqrt().max(rays);
        Estimate {
            mean: sum(&|m, weight| weight * m.mean),
            standard_error,
            half_width: parts.quantile * standard_error + trapped,
            rays_standard_error: rays,
            spread: Some(standard_error * n.sqrt()),
            trapped,
        }
    }

    /// The parts of the variance of the mean of `values`, one of each table. `cells` is the standard
    /// deviation between beds by the cells of their views; of few beds it is not used.
    pub(super) fn parts(&self, values: &[f64], cells: Option<f64>) -> Parts {
        let firsts: Vec<f64> = self.first(values).copied().collect();
        let by_spread = covariance(&firsts, &firsts);
        let alone = firsts.len() as f64 - 1.0;
        let (first, of_first) = match cells.filter(|_| firsts.len() >= MANY) {
            Some(cells) => {
                let freedom = alone + OF_CELLS;
                let by_cells = (OF_SPREAD_BY_CELLS * cells).powi(2);
                ((alone * by_spread + OF_CELLS * by_cells) / freedom, freedom)
            }
            None => (by_spread, alone),
        };
        let Self { pairs, .. } = self;
        if pairs.len() < 2 {
            let quantile = if of_first > 0.0 { quantile_of(of_first) } else { T_95 };
            return Parts { first, change: 0.0, both: 0.0, quantile };
        }
        let hulls: Vec<f64> = pairs.iter().map(|&[hulls, _]| values[hulls]).collect();
        let changes: Vec<f64> =
            pairs.iter().map(|&[hulls, touching]| values[touching] - values[hulls]).collect();
        let (change, both) = (covariance(&changes, &changes), covariance(&hulls, &changes));
        let parts = Parts { first, change, both, quantile: 0.0 };
        let [n, m] = [firsts.len(), pairs.len()].map(|beds| beds as f64);
        // Welch and Satterthwaite, of the pairs and of the hulls that are alone.
        let of_pairs = covariance(&hulls, &hulls) * m / (n * n) + change / m + 2.0 * both / n;
        let alone = first * (n - m) / (n * n);
        let freedom =
            (of_pairs + alone).powi(2) / (of_pairs.powi(2) / (m - 1.0) + alone.powi(2) / of_first);
        let freedom = if freedom.is_finite() { freedom.max(1.0) } else { m - 1.0 };
        Parts { quantile: quantile_of(freedom), ..parts }
    }

    /// Half-width of the 95 % interval of the mean of `values`, one of each table, whose rays have
    /// this standard error; `None` of a single bed.
    pub(super) fn half_width(&self, values: &[f64], rays: f64, cells: Option<f64>) -> Option<f64> {
        (self.drops() > 1).then(|| {
            let parts = self.parts(values, cells);
            let [drops, pairs] = [self.drops(), self.pairs()].map(|beds| beds as f64);
            // Beds that happen to agree are no more precise than their rays.
            parts.quantile * parts.variance(drops, pairs).sqrt().max(rays)
        })
    }
}

impl Parts {
    /// The variance of the mean of n hulls, m of them in pairs; without pairs `m` does not count.
    pub(super) fn variance(&self, n: f64, m: f64) -> f64 {
        let hulls = self.first / n;
        // By luck the covariance of a few pairs may leave next to nothing.
        let changes = if m > 0.0 { self.change / m } else { 0.0 };
        (hulls + changes + 2.0 * self.both / n).max(changes.max(0.1 * hulls))
    }

    /// Standard deviation of the change.
    pub(super) fn of_change(&self) -> f64 {
        self.change.sqrt()
    }
}

fn covariance(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (mean_a, mean_b) = (mean(a), mean(b));
    a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum::<f64>() / (n - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn means(values: &[f64]) -> Vec<Mean> {
        values.iter().map(|&mean| Mean { mean, ..Mean::default() }).collect()
    }

    /// Hulls .1, .2, .3, .4; the first two change by +.01 and +.03.
    #[test]
    fn few_pairs_carry_the_change_and_all_hulls_the_spread() {
        let levels = Levels::of_pairs(2, 4);
        let of = [0.11, 0.23, 0.1, 0.2, 0.3, 0.4];
        let estimate = levels.estimate(&means(&of));
        assert!((estimate.mean - (0.25 + 0.02)).abs() < 1e-12);
        let weights = levels.weights();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(weights, [0.5, 0.5, 0.25 - 0.5, 0.25 - 0.5, 0.25, 0.25]);
        // Variances: of hulls .05 / 3, of changes .0002, both .001.
        let variance: f64 = 0.05 / 3.0 / 4.0 + 0.0002 / 2.0 + 2.0 * 0.001 / 4.0;
        assert!((estimate.standard_error - variance.sqrt()).abs() < 1e-12);
        let alone = Levels::of_pairs(0, 4).estimate(&means(&of[2..]));
        assert_eq!(alone, Estimate::of(&means(&of[2..])));
    }

    /// Where every drop is a pair, the mean and its error are those of the touching beds.
    #[test]
    fn pairs_alone_are_beds_that_touch() {
        let (hulls, touching) = ([0.1, 0.2, 0.35, 0.4], [0.12, 0.19, 0.38, 0.41]);
        let of = [touching, hulls].concat();
        let estimate = Levels::of_pairs(4, 4).estimate(&means(&of));
        let direct = Estimate::of(&means(&touching));
        for (a, b) in [
            (estimate.mean, direct.mean),
            (estimate.standard_error, direct.standard_error),
            (estimate.half_width, direct.half_width),
        ] {
            assert!((a - b).abs() < 1e-9, "{a} and {b}");
        }
    }
}
