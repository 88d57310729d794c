//! Optimal estimation (Rodgers, Inverse Methods for Atmospheric Sounding, 2000) by least squares,
//! with errors by all that is uncertain.
//!
//! Observed bands are y = F(x) + e. The best fit is that of least squares: bands count by their own
//! errors alone, since the shape of what the model misses is not known well enough to weigh them.
//! The covariance of e is the sum of what is known (measurement, spread of beds, spectra) and of a
//! discrepancy of the model: a smooth curve of unknown size and correlation length. It is carried
//! through the fit to the parameters (Rodgers' chapter 3.2: the covariance by any gain). The
//! posterior of the discrepancy is found on a grid, by the evidence of the linearised model. That
//! of the parameters is the mixture over the grid, within the bounds. So an uncertain discrepancy
//! widens the errors.

mod posterior;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::discrepancy::{Discrepancy, root_mean_square};
use super::solver::{self, Minimum, Residuals};
use crate::support::math;

/// A parameter of a model, and what is known of it beforehand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its unit; empty for a share.
    pub unit: String,
    /// Mean of the prior.
    pub prior: f64,
    /// Standard deviation of the prior; 0 for a parameter that is not fitted.
    pub prior_standard_deviation: f64,
    /// The least and the greatest value that it may have.
    pub bounds: [f64; 2],
}

/// The bands of a model, and their derivatives in each parameter.
#[derive(Debug, Clone)]
pub struct Evaluated {
    /// A value for each band.
    pub bands: Vec<f64>,
    /// For each parameter its derivative in each band.
    pub slopes: Vec<Vec<f64>>,
}

/// A model of the observed bands.
pub trait Model: Sync {
    /// Its parameters.
    fn parameters(&self) -> &[Parameter];
    /// The bands for these parameters.
    fn evaluate(&self, x: &[f64]) -> Evaluated;
    /// The bands alone, where derivatives are not needed.
    fn bands(&self, x: &[f64]) -> Vec<f64> {
        self.evaluate(x).bands
    }
    /// The covariance of what is known to be uncertain in the model.
    fn covariance(&self, x: &[f64]) -> DMatrix<f64>;
}

/// What was observed.
#[derive(Debug, Clone)]
pub struct Observed {
    /// Wavelengths, um, ascending.
    pub um: Vec<f64>,
    /// A value for each.
    pub bands: Vec<f64>,
    /// Their standard errors.
    pub errors: Vec<f64>,
}

/// Rounds of a fit and of the size of its residual.
const MOST_ROUNDS: usize = 8;

/// The least error of a band that a fit counts with.
const LEAST_ERROR: f64 = 1e-6;

/// A fit of a model.
#[derive(Debug, Clone)]
pub struct Estimation {
    /// The parameters of the best fit.
    pub best: Vec<f64>,
    /// The bands there, and their derivatives.
    pub evaluated: Evaluated,
    /// The discrepancy of the greatest evidence.
    pub discrepancy: Discrepancy,
    /// Logarithm of the evidence, the mean over the grid.
    pub evidence: f64,
    /// Draws from the posterior, each with a value for each parameter.
    pub draws: Vec<Vec<f64>>,
    /// How many independent draws would tell as much.
    pub effective: f64,
    /// Averaging kernel of the fitted parameters; 0 of others.
    pub averaging: DMatrix<f64>,
    /// Parameters at a bound.
    pub held: Vec<bool>,
    /// Covariance of the observed bands without the discrepancy.
    pub known: DMatrix<f64>,
    /// Chi-square of the residual with the known covariance, and with the discrepancy.
    pub chi_square: [f64; 2],
    /// The parameters of the next best minimum that starts led to, if there is one.
    pub other: Option<Vec<f64>>,
    /// Whether the fit settled.
    pub converged: bool,
    /// The standard error of each band that it was weighed by.
    weighed: Vec<f64>,
    /// For each parameter, the variance by these weights over that of the posterior.
    narrower: Vec<f64>,
}

/// A model beside its observations.
pub struct Fitting<'a> {
    model: &'a dyn Model,
    observed: &'a Observed,
    free: Vec<usize>,
}

impl<'a> Fitting<'a> {
    /// A fit of the parameters whose prior is wider than 0.
    pub fn new(model: &'a dyn Model, observed: &'a Observed) -> Self {
        let is_free = |i: &usize| model.parameters()[*i].prior_standard_deviation > 0.0;
        let free = (0..model.parameters().len()).filter(is_free).collect();
        Self { model, observed, free }
    }

    fn parameter(&self, free: usize) -> &Parameter {
        &self.model.parameters()[self.free[free]]
    }

    /// All parameters for values of the free ones.
    fn all(&self, x: &DVector<f64>) -> Vec<f64> {
        let mut all: Vec<f64> = self.model.parameters().iter().map(|p| p.prior).collect();
        for (&place, value) in self.free.iter().zip(x.iter()) {
            all[place] = *value;
        }
        all
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        (0..self.free.len()).map(|i| self.parameter(i).bounds).collect()
    }

    /// The covariance that is known: measurement and model.
    fn known(&self, x: &[f64]) -> DMatrix<f64> {
        let mut known = self.model.covariance(x);
        for (i, error) in self.observed.errors.iter().enumerate() {
            known[(i, i)] += error * error;
        }
        known
    }

    /// Residuals and derivatives in the free parameters.
    fn residuals(&self, x: &DVector<f64>) -> (Evaluated, Residuals) {
        let found = self.model.evaluate(&self.all(x));
        let n = self.observed.um.len();
        let off = DVector::from_fn(n, |i, _| found.bands[i] - self.observed.bands[i]);
        let slopes = DMatrix::from_fn(n, self.free.len(), |i, p| found.slopes[self.free[p]][i]);
        (found, (off, slopes))
    }

    /// The best fit with these standard errors of the bands, from one start.
    fn best(&self, weighed: &[f64], start: &DVector<f64>) -> Minimum {
        let (n, p) = (self.observed.um.len(), self.free.len());
        let of = |x: &DVector<f64>| {
            let (_, (off, slopes)) = self.residuals(x);
            let mut rows = DVector::zeros(n + p);
            let mut matrix = DMatrix::zeros(n + p, p);
            for (i, error) in weighed.iter().enumerate() {
                rows[i] = off[i] / error;
                matrix.row_mut(i).copy_from(&(slopes.row(i) / *error));
            }
            for i in 0..p {
                let Parameter { prior, prior_standard_deviation: sd, .. } = self.parameter(i);
                rows[n + i] = (x[i] - prior) / sd;
                matrix[(n + i, i)] = 1.0 / sd;
            }
            (rows, matrix)
        };
        solver::minimise(&of, start, &self.bounds())
    }

    /// Where searches begin: near parameters that are given, else at low, middle and high values of
    /// each of the first two parameters.
    fn starts(&self, near: Option<&[f64]>) -> Vec<DVector<f64>> {
        let middle = DVector::from_fn(self.free.len(), |i, _| self.parameter(i).prior);
        if let Some(near) = near {
            let near = |i: usize| near.get(self.free[i]).copied().unwrap_or(middle[i]);
            return vec![DVector::from_fn(self.free.len(), |i, _| near(i)), middle];
        }
        let mut starts = vec![middle];
        for i in 0..self.free.len().min(2) {
            let Parameter { bounds: [low, high], .. } = self.parameter(i);
            starts = starts
                .iter()
                .flat_map(|start| {
                    [0.15, 0.5, 0.85].map(|share| {
                        let mut start = start.clone();
                        start[i] = low + share * (high - low);
                        start
                    })
                })
                .collect();
        }
        starts
    }

    /// Fits. Draws come from the seed. A model like another may start near its parameters.
    pub fn run(&self, seed: u64, near: Option<&[f64]>) -> Estimation {
        // The residual is not known before a fit. Then it counts as an error of all bands alike.
        let weighed = |residual: f64| -> Vec<f64> {
            let of = |error: &f64| math::hypot(*error, residual).max(LEAST_ERROR);
            self.observed.errors.iter().map(of).collect()
        };
        let mut residual = 0.02;
        let mut x = DVector::from_fn(self.free.len(), |i, _| self.parameter(i).prior);
        let mut held = vec![false; self.free.len()];
        let (mut other, mut converged) = (None, false);
        for round in 0..MOST_ROUNDS {
            let weighed = weighed(residual);
            let minimum = if round < 2 {
                let starts = self.starts(near);
                let found: Vec<Minimum> = starts.iter().map(|s| self.best(&weighed, s)).collect();
                let (best, next) = best_two(found);
                other = next.map(|next| self.all(&next.x));
                best
            } else {
                self.best(&weighed, &x)
            };
            let moved = &minimum.x - &x;
            let small = (0..self.free.len())
                .all(|i| moved[i].abs() < 1e-3 * self.parameter(i).prior_standard_deviation);
            converged = minimum.converged && round > 0 && small;
            (x, held) = (minimum.x, minimum.held);
            if converged {
                break;
            }
            residual = root_mean_square(self.residuals(&x).1.0.as_slice());
        }
        let weighed = weighed(residual);
        let known = self.known(&self.all(&x));
        let grid = self.grid(&x, &held, &known, &weighed);
        self.finish((seed, near.is_none()), &x, &grid, (known, weighed), (other, converged))
    }

    /// The logarithm of the profile likelihood over one parameter, relative to its greatest: the
    /// other parameters are fitted anew at each value. It is as wide as the posterior.
    pub fn profile(&self, of: &Estimation, place: usize, values: &[f64]) -> Vec<f64> {
        let start = |fitting: &Fitting| {
            DVector::from_fn(fitting.free.len(), |i, _| of.best[fitting.free[i]])
        };
        let prior = &self.model.parameters()[place];
        let squares: Vec<f64> = values
            .iter()
            .map(|&value| {
                let fixed = Fixed { model: self.model, place, value, parameters: vec![] }.ready();
                let fitting = Fitting::new(&fixed, self.observed);
                let from_prior = (value - prior.prior) / prior.prior_standard_deviation;
                fitting.best(&of.weighed, &start(&fitting)).squares() + from_prior.powi(2)
            })
            .collect();
        let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
        let scale = -0.5 * of.narrower[place];
        squares.into_iter().map(|squares| scale * (squares - least)).collect()
    }
}

/// A model with one parameter fixed.
struct Fixed<'a> {
    model: &'a dyn Model,
    place: usize,
    value: f64,
    parameters: Vec<Parameter>,
}

impl Fixed<'_> {
    fn ready(mut self) -> Self {
        self.parameters = self.model.parameters().to_vec();
        let fixed = &mut self.parameters[self.place];
        (fixed.prior, fixed.prior_standard_deviation) = (self.value, 0.0);
        self
    }
}

impl Model for Fixed<'_> {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn evaluate(&self, x: &[f64]) -> Evaluated {
        self.model.evaluate(x)
    }

    fn covariance(&self, x: &[f64]) -> DMatrix<f64> {
        self.model.covariance(x)
    }
}

/// The least minimum, and the least of those whose sums of squares differ from it.
fn best_two(mut found: Vec<Minimum>) -> (Minimum, Option<Minimum>) {
    found.sort_by(|a, b| a.squares().total_cmp(&b.squares()));
    let best = found.remove(0);
    let differs = |of: &Minimum| of.squares() - best.squares() > 1e-6 * (1.0 + best.squares());
    let other = found.into_iter().find(differs);
    (best, other)
}
