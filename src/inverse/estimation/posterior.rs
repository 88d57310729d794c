//! What the bands tell of the parameters, for each discrepancy of the grid: its evidence by the
//! model linearised about the best fit, and the posterior by the model itself.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::super::discrepancy::Discrepancy;
use super::super::importance::{self, Drawn, Proposal};
use super::super::kernel::{lower_solve, root};
use super::{Estimation, Evaluated, Fitting, Parameter};
use crate::support::math;

/// Draws from the posterior of the answer, and of a model that it is compared with.
const DRAWS: usize = 1536;
const DRAWS_TO_COMPARE: usize = 512;

/// A discrepancy less likely than this, over the most likely one, has no part in the posterior.
const LEAST_LIKELY: f64 = 1e-6;

/// What least squares tell of the parameters, in units of the priors' standard deviations.
struct Told {
    /// The information, by all that is uncertain.
    information: DMatrix<f64>,
    /// What it would be if the weights were all.
    by_weights: DMatrix<f64>,
    /// The covariance of the sums.
    spread: DMatrix<f64>,
}

/// A discrepancy, its evidence and what the bands tell with it.
pub struct GridPoint {
    discrepancy: Discrepancy,
    evidence: f64,
    told: Told,
}

fn most_likely(grid: &[GridPoint]) -> &GridPoint {
    let by_evidence = |a: &&GridPoint, b: &&GridPoint| a.evidence.total_cmp(&b.evidence);
    grid.iter().max_by(by_evidence).expect("the grid has points")
}

impl Fitting<'_> {
    /// Standard deviations of the priors.
    fn prior_deviations(&self) -> DVector<f64> {
        DVector::from_fn(self.free.len(), |i, _| self.parameter(i).prior_standard_deviation)
    }

    /// The weights of the bands in the sums u = G^T (y - F): G = W J, in units of the priors.
    fn gain(&self, slopes: &DMatrix<f64>, weighed: &[f64]) -> DMatrix<f64> {
        let weights = DVector::from_iterator(weighed.len(), weighed.iter().map(|e| e.powi(-2)));
        DMatrix::from_diagonal(&weights) * slopes * DMatrix::from_diagonal(&self.prior_deviations())
    }

    /// The evidence of the linearised model, for each discrepancy of the grid.
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
            let told = self.told(&slopes, weighed, &covariance);
            let root = root(&covariance);
            let ln_det = 2.0 * root.l_dirty().diagonal().map(math::log).sum();
            let (white, white_slopes) = (lower_solve(&root, &off), lower_solve(&root, &slopes));
            let evidence = self.evidence(x, &white, &white_slopes, &free) - 0.5 * ln_det;
            GridPoint { discrepancy, evidence, told }
        };
        Discrepancy::grid().par_iter().map(of).collect()
    }

    /// What the bands tell by least squares, with errors by a covariance of the bands.
    ///
    /// Least squares use of the bands the sums u = J^T W d alone, one for each parameter. Their mean
    /// is H (x - x_a), H = J^T W J, their covariance V = J^T W S W J. So they tell H V^-1 H
    /// (Godambe's information), all in units of the priors' standard deviations.
    fn told(&self, slopes: &DMatrix<f64>, weighed: &[f64], covariance: &DMatrix<f64>) -> Told {
        let p = self.free.len();
        if p == 0 {
            let nothing = || DMatrix::zeros(0, 0);
            return Told { information: nothing(), by_weights: nothing(), spread: nothing() };
        }
        let gain = self.gain(slopes, weighed);
        let scaled = slopes * DMatrix::from_diagonal(&self.prior_deviations());
        let by_weights = scaled.tr_mul(&gain);
        let mut spread = gain.tr_mul(&(covariance * &gain));
        // What no band tells has no spread either.
        let least = 1e-12 * spread.trace() + f64::MIN_POSITIVE;
        (0..p).for_each(|i| spread[(i, i)] += least);
        let information = by_weights.tr_mul(&root(&spread).solve(&by_weights));
        Told { information, by_weights, spread }
    }

    /// Draws from the posterior: the sums u are normally distributed, with the covariance that each
    /// discrepancy gives them. They are those of the model itself at each draw; the weights of the
    /// bands in them stay those of the best fit.
    fn drawn(
        &self,
        x: &DVector<f64>,
        slopes: &DMatrix<f64>,
        weighed: &[f64],
        grid: &[GridPoint],
        (seed, is_answer): (u64, bool),
    ) -> Drawn {
        let number = if is_answer { DRAWS } else { DRAWS_TO_COMPARE };
        let p = self.free.len();
        if p == 0 {
            return Drawn { draws: vec![x.clone(); number], effective: number as f64 };
        }
        let greatest = most_likely(grid).evidence;
        let likely: Vec<(f64, &Told)> = (grid.iter())
            .map(|point| (math::exp(point.evidence - greatest), &point.told))
            .filter(|(share, _)| *share > LEAST_LIKELY)
            .collect();
        let sum: f64 = likely.iter().map(|(share, _)| share).sum();
        let covariance = likely.iter().fold(DMatrix::zeros(p, p), |covariance, (share, told)| {
            let precision = &told.information + DMatrix::identity(p, p);
            covariance + root(&precision).inverse() * (share / sum)
        });
        let units = DMatrix::from_diagonal(&self.prior_deviations());
        let covariance = &units * covariance * &units;
        let gain = self.gain(slopes, weighed);
        let roots: Vec<_> =
            likely.iter().map(|(share, told)| (share, root(&told.spread))).collect();
        let weigh = |points: &[DVector<f64>], drawn: &[f64]| -> Vec<f64> {
            let sums_and_prior = |x: &DVector<f64>| {
                let fitted = self.model.bands(&self.all(x));
                let off = fitted.iter().zip(&self.observed.bands).map(|(f, seen)| seen - f);
                let off = DVector::from_iterator(fitted.len(), off);
                let from_prior = |i: usize| {
                    let Parameter { prior, prior_standard_deviation: sd, .. } = self.parameter(i);
                    ((x[i] - prior) / sd).powi(2)
                };
                (gain.tr_mul(&off), -0.5 * (0..p).map(from_prior).sum::<f64>())
            };
            let sums: Vec<(DVector<f64>, f64)> = points.par_iter().map(sums_and_prior).collect();
            let of = |(share, root): &(&f64, Cholesky<f64, Dyn>)| -> Vec<f64> {
                let density = |((sums, prior), drawn): (&(DVector<f64>, f64), &f64)| {
                    prior - 0.5 * lower_solve(root, sums).norm_squared() - drawn
                };
                let all: Vec<f64> = sums.iter().zip(drawn).map(density).collect();
                let greatest = all.iter().copied().fold(f64::MIN, f64::max);
                let all: Vec<f64> = all.iter().map(|of| math::exp(of - greatest)).collect();
                let sum: f64 = all.iter().sum();
                all.iter().map(|of| *share * of / sum).collect()
            };
            let of_all: Vec<Vec<f64>> = roots.par_iter().map(of).collect();
            (0..points.len()).map(|i| of_all.iter().map(|of| of[i]).sum()).collect()
        };
        let first = Proposal { middle: x.clone(), covariance };
        importance::draws(first, &self.bounds(), &weigh, number, seed)
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
        draws: (u64, bool),
        x: &DVector<f64>,
        grid: &[GridPoint],
        (known, weighed): (DMatrix<f64>, Vec<f64>),
        (other, converged): (Option<Vec<f64>>, bool),
    ) -> Estimation {
        let best = self.all(x);
        let um = &self.observed.um;
        let (evaluated, (off, slopes)) = self.residuals(x);
        let greatest = most_likely(grid);
        let of = |point: &GridPoint| math::exp(point.evidence - greatest.evidence);
        let mean = grid.iter().map(of).sum::<f64>() / grid.len() as f64;
        let Drawn { draws, effective } = self.drawn(x, &slopes, &weighed, grid, draws);
        let draws = draws.iter().map(|draw| self.all(draw)).collect();
        let GridPoint { discrepancy, told, .. } = greatest;
        let all = discrepancy.with(&known, um, &evaluated.bands);
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
            discrepancy: *discrepancy,
            evidence: greatest.evidence + math::log(mean),
            draws,
            effective,
            averaging,
            known,
            chi_square,
            other,
            converged,
            weighed,
            narrower,
        }
    }
}
