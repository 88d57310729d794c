//! What the bands tell of the parameters: the linearised model about the best fit, for each
//! discrepancy of the grid.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::super::discrepancy::Discrepancy;
use super::super::kernel::{lower_solve, root};
use super::super::truncated::{self, Component};
use super::{Estimation, Evaluated, Fitting};
use crate::support::math;

/// Draws from the posterior.
pub const DRAWS: usize = 4096;

/// What least squares tell of the parameters, in units of the priors' standard deviations.
struct Told {
    /// The information, by all that is uncertain.
    information: DMatrix<f64>,
    /// What it would be if the weights were all.
    by_weights: DMatrix<f64>,
    /// With the prior, in the parameters' own units.
    posterior: Component,
}

/// A discrepancy, its evidence and the posterior that belongs to it.
pub struct GridPoint {
    discrepancy: Discrepancy,
    evidence: f64,
    component: Component,
}

fn most_likely(grid: &[GridPoint]) -> Discrepancy {
    let by_evidence = |a: &&GridPoint, b: &&GridPoint| a.evidence.total_cmp(&b.evidence);
    grid.iter().max_by(by_evidence).expect("the grid has points").discrepancy
}

impl Fitting<'_> {
    /// The evidence and the posterior of the linearised model, for each discrepancy of the grid.
    pub(super) fn grid(
        &self,
        x: &DVector<f64>,
        held: &[bool],
        known: &DMatrix<f64>,
        weighed: &[f64],
    ) -> Vec<GridPoint> {
        let (Evaluated { bands, .. }, (off, slopes)) = self.residuals(x);
        // A parameter that a bound holds cannot explain what lies beyond it.
        let free: Vec<usize> = (0..held.len()).filter(|&i| !held[i]).collect();
        let of = |&discrepancy: &Discrepancy| {
            let covariance = discrepancy.with(known, &self.observed.um, &bands);
            let component = self.told(x, &off, &slopes, weighed, &covariance).posterior;
            let root = root(&covariance);
            let ln_det = 2.0 * root.l_dirty().diagonal().map(math::log).sum();
            let (white, white_slopes) = (lower_solve(&root, &off), lower_solve(&root, &slopes));
            let evidence = self.evidence(x, &white, &white_slopes, &free) - 0.5 * ln_det;
            GridPoint { discrepancy, evidence, component }
        };
        Discrepancy::grid().par_iter().map(of).collect()
    }

    /// What the bands tell by least squares, with errors by a covariance of the bands.
    ///
    /// Least squares use of the bands the sums u = J^T W d alone, one for each parameter. Their mean
    /// is H (x - x_a), H = J^T W J, their covariance V = J^T W S W J. So they tell H V^-1 H
    /// (Godambe's information), all in units of the priors' standard deviations.
    fn told(
        &self,
        x: &DVector<f64>,
        off: &DVector<f64>,
        slopes: &DMatrix<f64>,
        weighed: &[f64],
        covariance: &DMatrix<f64>,
    ) -> Told {
        let p = self.free.len();
        let sd = DVector::from_fn(p, |i, _| self.parameter(i).prior_standard_deviation);
        let prior = DVector::from_fn(p, |i, _| self.parameter(i).prior);
        if p == 0 {
            let nothing = DMatrix::zeros(0, 0);
            let posterior = Component { mean: prior, precision: nothing.clone() };
            return Told { information: nothing.clone(), by_weights: nothing, posterior };
        }
        let scaled = slopes * DMatrix::from_diagonal(&sd);
        let weights = DVector::from_iterator(weighed.len(), weighed.iter().map(|e| e.powi(-2)));
        let gain = DMatrix::from_diagonal(&weights) * &scaled;
        // What the model misses at the mean of the prior.
        let at_prior = slopes * (x - &prior) - off;
        let by_weights = scaled.tr_mul(&gain);
        let mut spread = gain.tr_mul(&(covariance * &gain));
        // What no band tells has no spread either.
        let least = 1e-12 * spread.trace() + f64::MIN_POSITIVE;
        (0..p).for_each(|i| spread[(i, i)] += least);
        let spread = root(&spread);
        let information = by_weights.tr_mul(&spread.solve(&by_weights));
        let right = by_weights.tr_mul(&spread.solve(&gain.tr_mul(&at_prior)));
        let precision = &information + DMatrix::identity(p, p);
        let mean = prior + root(&precision).solve(&right).component_mul(&sd);
        let units = DMatrix::from_diagonal(&sd.map(f64::recip));
        let posterior = Component { mean, precision: &units * precision * &units };
        Told { information, by_weights, posterior }
    }

    /// The evidence of the linearised model of whitened bands, but for the determinant of their
    /// covariance. Parameters at these places may move.
    fn evidence(
        &self,
        x: &DVector<f64>,
        white: &DVector<f64>,
        slopes: &DMatrix<f64>,
        places: &[usize],
    ) -> f64 {
        let p = places.len();
        if p == 0 {
            return -0.5 * white.norm_squared();
        }
        let slopes = slopes.select_columns(places);
        let sd = |i: usize| self.parameter(places[i]).prior_standard_deviation;
        let from_prior = DVector::from_fn(p, |i, _| x[places[i]] - self.parameter(places[i]).prior);
        // What the model misses at the mean of the prior.
        let at_prior = &slopes * &from_prior - white;
        let mut precision = slopes.tr_mul(&slopes);
        let mut ln_det = 0.0;
        for i in 0..p {
            precision[(i, i)] += sd(i).powi(-2);
            ln_det += 2.0 * math::log(sd(i));
        }
        let right = slopes.tr_mul(&at_prior);
        let root = root(&precision);
        ln_det += 2.0 * root.l_dirty().diagonal().map(math::log).sum();
        let squares = at_prior.norm_squared() - right.dot(&root.solve(&right));
        -0.5 * (squares + ln_det)
    }

    pub(super) fn finish(
        &self,
        seed: u64,
        x: &DVector<f64>,
        grid: &[GridPoint],
        (known, weighed): (DMatrix<f64>, Vec<f64>),
        (minima, converged): (usize, bool),
    ) -> Estimation {
        let best = self.all(x);
        let um = &self.observed.um;
        let (evaluated, (off, slopes)) = self.residuals(x);
        let greatest = grid.iter().map(|point| point.evidence).fold(f64::MIN, f64::max);
        let weights: Vec<f64> = grid.iter().map(|p| math::exp(p.evidence - greatest)).collect();
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        let components: Vec<&Component> = grid.iter().map(|point| &point.component).collect();
        let draws = truncated::draws(&components, &weights, &self.bounds(), DRAWS, seed);
        let draws = draws.iter().map(|draw| self.all(draw)).collect();
        let discrepancy = most_likely(grid);
        let all = discrepancy.with(&known, um, &evaluated.bands);
        let told = self.told(x, &off, &slopes, &weighed, &all);
        let chi_square =
            [&known, &all].map(|covariance| lower_solve(&root(covariance), &off).norm_squared());
        let p = self.free.len();
        let [by_fit, by_all] = [&told.by_weights, &told.information]
            .map(|information| root(&(information + DMatrix::identity(p, p))).inverse());
        // In units of the priors' standard deviations.
        let kernel = &by_all * &told.information;
        let sd = |i: usize| self.parameter(i).prior_standard_deviation;
        let n = best.len();
        let mut averaging = DMatrix::zeros(n, n);
        let mut narrower = vec![1.0; n];
        for (i, &row) in self.free.iter().enumerate() {
            for (j, &column) in self.free.iter().enumerate() {
                averaging[(row, column)] = kernel[(i, j)] * sd(i) / sd(j);
            }
            narrower[row] = by_fit[(i, i)] / by_all[(i, i)];
        }
        let is_held = |i: usize| {
            let [low, high] = self.model.parameters()[i].bounds;
            let room = 1e-6 * (high - low);
            self.free.contains(&i) && (best[i] <= low + room || best[i] >= high - room)
        };
        Estimation {
            held: (0..n).map(is_held).collect(),
            best,
            evaluated,
            discrepancy,
            evidence: greatest + math::log(mean),
            draws,
            averaging,
            known,
            chi_square,
            minima,
            converged,
            weighed,
            narrower,
        }
    }
}
