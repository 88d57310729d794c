//! Optimal estimation (Rodgers, Inverse Methods for Atmospheric Sounding, 2000) with a model
//! discrepancy that is estimated beside the parameters.
//!
//! Observed bands are y = F(x) + e. The covariance of e is the sum of what is known (measurement,
//! spread of beds, spectra) and of a discrepancy of the model: a smooth curve of unknown size and
//! correlation length. Their posterior is found on a grid, by the evidence of the linearised model.
//! The parameters' posterior is the mixture over the grid, within the bounds. So an uncertain
//! discrepancy widens the errors.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::kernel;
use super::solver::{self, Minimum, Residuals};
use super::truncated::{self, Component};
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

/// The discrepancy of a model: a curve beyond what its parameters can make.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Discrepancy {
    /// Its standard deviation, in emissivity.
    pub standard_deviation: f64,
    /// The length over which it is correlated, um.
    pub length_um: f64,
}

/// Standard deviations and lengths of the grid. A discrepancy longer than the window is a level,
/// one shorter than the features of quartz is noise.
const DEVIATIONS: [f64; 12] =
    [0.0005, 0.001, 0.002, 0.003, 0.0045, 0.0065, 0.01, 0.014, 0.02, 0.03, 0.045, 0.07];
const LENGTHS_UM: [f64; 6] = [0.06, 0.12, 0.22, 0.4, 0.75, 1.4];

/// Rounds of fit and discrepancy.
const MOST_ROUNDS: usize = 8;

/// Draws from the posterior.
pub const DRAWS: usize = 4096;

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
    /// Averaging kernel of the fitted parameters; 0 of others.
    pub averaging: DMatrix<f64>,
    /// Parameters at a bound.
    pub held: Vec<bool>,
    /// Covariance of the observed bands without the discrepancy.
    pub known: DMatrix<f64>,
    /// Chi-square of the residual with the known covariance, and with the discrepancy.
    pub chi_square: [f64; 2],
    /// Number of different minima that the starts led to, at the last discrepancy of the search.
    pub minima: usize,
    /// Whether fit and discrepancy settled.
    pub converged: bool,
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

    /// The best fit for a covariance of the bands, from one start.
    fn best(&self, root: &Cholesky<f64, Dyn>, start: &DVector<f64>) -> Minimum {
        let (n, p) = (self.observed.um.len(), self.free.len());
        let of = |x: &DVector<f64>| {
            let (_, (off, slopes)) = self.residuals(x);
            let mut rows = DVector::zeros(n + p);
            let mut matrix = DMatrix::zeros(n + p, p);
            rows.rows_mut(0, n).copy_from(&lower_solve(root, &off));
            matrix.rows_mut(0, n).copy_from(&lower_solve(root, &slopes));
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
        let um = &self.observed.um;
        let mut discrepancy = Discrepancy { standard_deviation: 0.02, length_um: 0.22 };
        let mut x = DVector::from_fn(self.free.len(), |i, _| self.parameter(i).prior);
        let (mut minima, mut converged) = (0, false);
        let mut known = self.known(&self.all(&x));
        let mut grid = Vec::new();
        for round in 0..MOST_ROUNDS {
            let root = root(with(&known, um, discrepancy));
            let minimum = if round < 2 {
                let starts = self.starts(near);
                let found: Vec<Minimum> = starts.iter().map(|s| self.best(&root, s)).collect();
                minima = different(&found);
                let by_squares = |a: &Minimum, b: &Minimum| a.squares().total_cmp(&b.squares());
                found.into_iter().min_by(by_squares).expect("there is a start")
            } else {
                self.best(&root, &x)
            };
            let solved = minimum.converged;
            let moved = &minimum.x - &x;
            x = minimum.x;
            known = self.known(&self.all(&x));
            grid = self.grid(&x, &minimum.held, &known);
            let before = discrepancy;
            discrepancy = most_likely(&grid);
            let small = (0..self.free.len())
                .all(|i| moved[i].abs() < 1e-3 * self.parameter(i).prior_standard_deviation);
            converged = solved && round > 0 && small && before == discrepancy;
            if converged {
                break;
            }
        }
        self.finish(seed, &x, discrepancy, &grid, (minima, converged))
    }

    /// The evidence and the posterior of the linearised model, for each discrepancy of the grid.
    fn grid(&self, x: &DVector<f64>, held: &[bool], known: &DMatrix<f64>) -> Vec<GridPoint> {
        use rayon::prelude::*;
        let (_, (off, slopes)) = self.residuals(x);
        let pairs: Vec<Discrepancy> = LENGTHS_UM
            .iter()
            .flat_map(|&length_um| {
                DEVIATIONS.map(|standard_deviation| Discrepancy { standard_deviation, length_um })
            })
            .collect();
        let of = |&discrepancy: &Discrepancy| {
            let root = root(with(known, &self.observed.um, discrepancy));
            let ln_det = 2.0 * root.l_dirty().diagonal().map(math::log).sum();
            let white = lower_solve(&root, &off);
            let white_slopes = lower_solve(&root, &slopes);
            let all: Vec<bool> = vec![true; held.len()];
            let free: Vec<bool> = held.iter().map(|held| !held).collect();
            let (mean, precision, _) = self.linear(x, &white, &white_slopes, &all);
            // A parameter that a bound holds cannot explain what lies beyond it.
            let (_, _, evidence) = self.linear(x, &white, &white_slopes, &free);
            let component = Component { mean, precision };
            GridPoint { discrepancy, evidence: evidence - 0.5 * ln_det, component }
        };
        pairs.par_iter().map(of).collect()
    }

    /// The linearised model's posterior of the parameters that may move, and its evidence but for
    /// the determinant of the bands' covariance.
    fn linear(
        &self,
        x: &DVector<f64>,
        white: &DVector<f64>,
        slopes: &DMatrix<f64>,
        moves: &[bool],
    ) -> (DVector<f64>, DMatrix<f64>, f64) {
        let places: Vec<usize> = (0..moves.len()).filter(|&i| moves[i]).collect();
        let p = places.len();
        if p == 0 {
            let (none, nothing) = (DVector::zeros(0), DMatrix::zeros(0, 0));
            return (none, nothing, -0.5 * white.norm_squared());
        }
        let slopes = slopes.select_columns(&places);
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
        let root = root(precision.clone());
        let from_prior = root.solve(&right);
        ln_det += 2.0 * root.l_dirty().diagonal().map(math::log).sum();
        let squares = at_prior.norm_squared() - right.dot(&from_prior);
        let mean = DVector::from_fn(p, |i, _| self.parameter(places[i]).prior + from_prior[i]);
        (mean, precision, -0.5 * (squares + ln_det))
    }

    fn finish(
        &self,
        seed: u64,
        x: &DVector<f64>,
        discrepancy: Discrepancy,
        grid: &[GridPoint],
        (minima, converged): (usize, bool),
    ) -> Estimation {
        let best = self.all(x);
        let known = self.known(&best);
        let (evaluated, (off, slopes)) = self.residuals(x);
        let greatest = grid.iter().map(|point| point.evidence).fold(f64::MIN, f64::max);
        let weights: Vec<f64> = grid.iter().map(|p| math::exp(p.evidence - greatest)).collect();
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        let components: Vec<&Component> = grid.iter().map(|point| &point.component).collect();
        let draws = truncated::draws(&components, &weights, &self.bounds(), DRAWS, seed);
        let draws = draws.iter().map(|draw| self.all(draw)).collect();
        let chi_square = [known.clone(), with(&known, &self.observed.um, discrepancy)]
            .map(|covariance| lower_solve(&root(covariance), &off).norm_squared());
        let root = root(with(&known, &self.observed.um, discrepancy));
        let white = lower_solve(&root, &slopes);
        let information = white.tr_mul(&white);
        let mut precision = information.clone();
        for i in 0..self.free.len() {
            precision[(i, i)] += self.parameter(i).prior_standard_deviation.powi(-2);
        }
        let kernel = self::root(precision).solve(&information);
        let n = best.len();
        let mut averaging = DMatrix::zeros(n, n);
        for (i, &row) in self.free.iter().enumerate() {
            for (j, &column) in self.free.iter().enumerate() {
                averaging[(row, column)] = kernel[(i, j)];
            }
        }
        let is_held = |i: usize| {
            let [low, high] = self.model.parameters()[i].bounds;
            let room = 1e-6 * (high - low);
            self.free.contains(&i) && (best[i] <= low + room || best[i] >= high - room)
        };
        let held = (0..n).map(is_held).collect();
        let evidence = greatest + math::log(mean);
        Estimation {
            best,
            evaluated,
            discrepancy,
            evidence,
            draws,
            averaging,
            held,
            known,
            chi_square,
            minima,
            converged,
        }
    }

    /// The logarithm of the profile likelihood over one parameter, relative to its greatest: the
    /// other parameters are fitted anew at each value.
    pub fn profile(&self, of: &Estimation, place: usize, values: &[f64]) -> Vec<f64> {
        let root = root(with(&of.known, &self.observed.um, of.discrepancy));
        let start = |fitting: &Fitting| {
            DVector::from_fn(fitting.free.len(), |i, _| of.best[fitting.free[i]])
        };
        let squares: Vec<f64> = values
            .iter()
            .map(|&value| {
                let fixed = Fixed { model: self.model, place, value, parameters: vec![] }.ready();
                let fitting = Fitting::new(&fixed, self.observed);
                fitting.best(&root, &start(&fitting)).squares()
            })
            .collect();
        let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
        squares.into_iter().map(|squares| -0.5 * (squares - least)).collect()
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

/// A discrepancy, its evidence and the posterior that belongs to it.
struct GridPoint {
    discrepancy: Discrepancy,
    evidence: f64,
    component: Component,
}

fn most_likely(grid: &[GridPoint]) -> Discrepancy {
    let by_evidence = |a: &&GridPoint, b: &&GridPoint| a.evidence.total_cmp(&b.evidence);
    grid.iter().max_by(by_evidence).expect("the grid has points").discrepancy
}

/// Minima whose sums of squares differ.
fn different(found: &[Minimum]) -> usize {
    let mut squares: Vec<f64> = found.iter().map(Minimum::squares).collect();
    squares.sort_by(f64::total_cmp);
    squares.dedup_by(|a, b| (*a - *b).abs() <= 1e-6 * (1.0 + b.abs()));
    squares.len()
}

/// A covariance with a discrepancy.
fn with(known: &DMatrix<f64>, um: &[f64], discrepancy: Discrepancy) -> DMatrix<f64> {
    let Discrepancy { standard_deviation, length_um } = discrepancy;
    known + kernel::correlation(um, length_um) * standard_deviation.powi(2)
}

/// The Cholesky factor of a covariance. Where rounding makes it indefinite its diagonal is raised.
fn root(covariance: DMatrix<f64>) -> Cholesky<f64, Dyn> {
    let mean = covariance.trace() / covariance.nrows() as f64;
    let mut raised = 1e-12;
    loop {
        if let Some(root) = covariance.clone().cholesky() {
            return root;
        }
        let more = DMatrix::identity(covariance.nrows(), covariance.ncols()) * (raised * mean);
        if let Some(root) = (&covariance + more).cholesky() {
            return root;
        }
        raised *= 10.0;
    }
}

fn lower_solve<C: nalgebra::Dim>(
    root: &Cholesky<f64, Dyn>,
    of: &nalgebra::OMatrix<f64, Dyn, C>,
) -> nalgebra::OMatrix<f64, Dyn, C>
where
    nalgebra::DefaultAllocator: nalgebra::allocator::Allocator<Dyn, C>,
{
    let mut solved = of.clone();
    let is_regular = root.l_dirty().solve_lower_triangular_mut(&mut solved);
    debug_assert!(is_regular, "a Cholesky factor has no zero on its diagonal");
    solved
}

/// The probability of a chi-square as great or greater by chance.
pub fn chance(chi_square: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom.max(1.0)).map_or(1.0, |of| of.sf(chi_square))
}
