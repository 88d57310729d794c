//! Least squares within bounds, by Levenberg and Marquardt's method.
//!
//! A step solves the linearised problem with damping, scaled by the greatest norms of the columns
//! so far (Moré, Lecture Notes in Mathematics 630, 105, 1978). Parameters at a bound that the step
//! would leave are held there. The damping follows Nielsen's rule (IMM report 1999-05).

use nalgebra::{DMatrix, DVector};

/// Most steps.
const MOST_STEPS: usize = 500;

/// Steps end where the cost changes relatively less than this, and the parameters too.
const ENOUGH: f64 = 1e-13;

/// Residuals and their derivatives, one column for each parameter.
pub type Residuals = (DVector<f64>, DMatrix<f64>);

/// The least sum of squares.
#[derive(Debug, Clone)]
pub struct Minimum {
    /// The parameters.
    pub x: DVector<f64>,
    /// The residuals there.
    pub residuals: DVector<f64>,
    /// Parameters that a bound holds.
    pub held: Vec<bool>,
    /// Whether the steps ended by themselves.
    pub converged: bool,
}

impl Minimum {
    /// The sum of the squares.
    pub fn squares(&self) -> f64 {
        self.residuals.norm_squared()
    }
}

/// Finds the least sum of squared residuals near `start`, between the bounds of each parameter.
pub fn minimise(
    of: &dyn Fn(&DVector<f64>) -> Residuals,
    start: &DVector<f64>,
    bounds: &[[f64; 2]],
) -> Minimum {
    let inside =
        |x: DVector<f64>| DVector::from_fn(x.len(), |i, _| x[i].clamp(bounds[i][0], bounds[i][1]));
    let mut x = inside(start.clone());
    let (mut residuals, mut jacobian) = of(&x);
    let mut squares = residuals.norm_squared();
    let mut scale = DVector::from_element(x.len(), 0.0);
    let (mut damping, mut growth) = (1e-3, 2.0);
    let mut converged = false;
    let mut held;
    let mut steps = 0;
    while steps < MOST_STEPS && !converged {
        steps += 1;
        for (i, column) in jacobian.column_iter().enumerate() {
            scale[i] = f64::max(scale[i], column.norm()).max(f64::MIN_POSITIVE);
        }
        held = held_by_bounds(&x, &jacobian.tr_mul(&residuals), bounds);
        let step = damped(&residuals, &jacobian, &scale, damping, &held);
        let next = inside(&x + &step);
        let step = &next - &x;
        let (new_residuals, new_jacobian) = of(&next);
        let new_squares = new_residuals.norm_squared();
        let expected = squares - (&residuals + &jacobian * &step).norm_squared();
        let small = step.component_mul(&scale).norm()
            <= ENOUGH.sqrt() * 1e-3 * (x.component_mul(&scale).norm() + f64::MIN_POSITIVE);
        if new_squares <= squares && new_squares.is_finite() {
            let gain = squares - new_squares;
            converged = (gain <= ENOUGH * squares && expected <= ENOUGH * squares) || small;
            let ratio = if expected > 0.0 { gain / expected } else { 1.0 };
            damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
            growth = 2.0;
            (x, residuals, jacobian, squares) = (next, new_residuals, new_jacobian, new_squares);
        } else {
            converged = small;
            damping *= growth;
            growth *= 2.0;
        }
    }
    held = held_by_bounds(&x, &jacobian.tr_mul(&residuals), bounds);
    Minimum { x, residuals, held, converged }
}

/// Whether each parameter is at a bound that lies downhill, against the gradient.
fn held_by_bounds(x: &DVector<f64>, gradient: &DVector<f64>, bounds: &[[f64; 2]]) -> Vec<bool> {
    let is_held = |(i, [low, high]): (usize, &[f64; 2])| {
        (x[i] <= *low && gradient[i] >= 0.0) || (x[i] >= *high && gradient[i] <= 0.0)
    };
    bounds.iter().enumerate().map(is_held).collect()
}

/// The step of the linearised problem with damping, by a QR decomposition: normal equations would
/// lose half of the digits.
fn damped(
    residuals: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    scale: &DVector<f64>,
    damping: f64,
    held: &[bool],
) -> DVector<f64> {
    let free: Vec<usize> = (0..held.len()).filter(|&i| !held[i]).collect();
    let mut step = DVector::zeros(held.len());
    if free.is_empty() {
        return step;
    }
    let (rows, columns) = (residuals.len(), free.len());
    let mut matrix = DMatrix::zeros(rows + columns, columns);
    let mut right = DVector::zeros(rows + columns);
    right.rows_mut(0, rows).copy_from(&-residuals);
    for (column, &i) in free.iter().enumerate() {
        // In units of the scale all columns are alike.
        matrix.view_mut((0, column), (rows, 1)).copy_from(&(jacobian.column(i) / scale[i]));
        matrix[(rows + column, column)] = damping.sqrt();
    }
    let qr = matrix.qr();
    qr.q_tr_mul(&mut right);
    let solved = qr.unpack_r().solve_upper_triangular(&right.rows(0, columns).clone_owned());
    for (column, &i) in free.iter().enumerate() {
        step[i] = solved.as_ref().map_or(0.0, |solved| solved[column] / scale[i]);
    }
    step
}
