//! Covariances across bands, and their roots.

use nalgebra::{Cholesky, DMatrix, Dyn};
use serde::{Deserialize, Serialize};

use crate::support::math;
use crate::support::statistics::{NORMAL_95, quantile_of};

/// How curves change from band to band.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Smoothness {
    /// With one derivative: Matérn's correlation of order 3/2
    #[default]
    Rough,
    /// With all derivatives: the correlation of Gauss's form, Matérn's of infinite order
    Smooth,
}

impl Smoothness {
    /// The correlation at a distance, of curves that forget themselves over a length.
    pub fn correlation(self, distance: f64, length: f64) -> f64 {
        let scaled = distance.abs() / length;
        match self {
            Self::Rough => {
                let scaled = 3.0_f64.sqrt() * scaled;
                (1.0 + scaled) * math::exp(-scaled)
            }
            Self::Smooth => math::exp(-0.5 * scaled * scaled),
        }
    }
}

/// The covariance of a curve with these standard deviations and a correlation length, um.
pub fn covariance(
    um: &[f64],
    standard_deviation: &[f64],
    length_um: f64,
    smoothness: Smoothness,
) -> DMatrix<f64> {
    let of = |i: usize, j: usize| smoothness.correlation(um[i] - um[j], length_um);
    let mut all = DMatrix::from_fn(um.len(), um.len(), of);
    for ((i, j), value) in indexed(um.len()).zip(all.iter_mut()) {
        *value *= standard_deviation[i] * standard_deviation[j];
    }
    all
}

/// Rows and columns of a square matrix in the order of its storage.
fn indexed(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |j| (0..n).map(move |i| (i, j)))
}

/// The covariance of the mean of these curves, all independent and alike. Their number is finite:
/// the 95 % intervals of a normal distribution with this covariance are those of Student's t.
pub fn of_mean(curves: &[Vec<f64>]) -> DMatrix<f64> {
    let (n, bands) = (curves.len() as f64, curves[0].len());
    let wider = (quantile_of(n - 1.0) / NORMAL_95).powi(2);
    let mean = |band: usize| curves.iter().map(|curve| curve[band]).sum::<f64>() / n;
    let off = DMatrix::from_fn(bands, curves.len(), |band, i| curves[i][band] - mean(band));
    &off * off.transpose() * (wider / (n * (n - 1.0)))
}

/// The Cholesky factor of a covariance. Where rounding makes it indefinite its diagonal is raised.
pub fn root(covariance: &DMatrix<f64>) -> Cholesky<f64, Dyn> {
    let mean = covariance.trace() / covariance.nrows() as f64;
    let mut raised = 1e-12;
    loop {
        if let Some(root) = covariance.clone().cholesky() {
            return root;
        }
        let more = DMatrix::identity(covariance.nrows(), covariance.ncols()) * (raised * mean);
        if let Some(root) = (covariance + more).cholesky() {
            return root;
        }
        raised *= 10.0;
    }
}

/// Solves a system with the lower factor: what has this covariance becomes white.
pub fn lower_solve<C: nalgebra::Dim>(
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_covariance_of_a_mean_is_that_of_its_curves_over_their_number() {
        // 1, 3 and 5 have variance 4; the second band is minus half of the first.
        let curves: Vec<Vec<f64>> = [1.0, 3.0, 5.0].map(|v| vec![v, -0.5 * v]).to_vec();
        let found = of_mean(&curves);
        // Student's t with two degrees of freedom: 4.303 in place of 1.960.
        let wider = (4.302_653_f64 / 1.959_964).powi(2);
        let expected = DMatrix::from_row_slice(2, 2, &[4.0, -2.0, -2.0, 1.0]) / 3.0 * wider;
        assert!((found / expected.norm() - &expected / expected.norm()).norm() < 1e-5);
    }

    #[test]
    fn correlations_fall_from_one_and_are_positive_definite() {
        let um: Vec<f64> = (0..40).map(|i| 8.0 + 0.02 * f64::from(i)).collect();
        let at_length = [
            (Smoothness::Rough, (1.0 + 3.0_f64.sqrt()) * math::exp(-3.0_f64.sqrt())),
            (Smoothness::Smooth, math::exp(-0.5)),
        ];
        for (smoothness, expected) in at_length {
            assert!((smoothness.correlation(-0.3, 0.3) - expected).abs() < 1e-15);
            let of = covariance(&um, &[2.0; 40], 0.3, smoothness);
            assert_eq!(of[(3, 3)], 4.0);
            assert!((of[(3, 18)] / 4.0 - expected).abs() < 1e-12);
            assert!((of + DMatrix::identity(40, 40) * 1e-10).cholesky().is_some());
        }
    }
}
