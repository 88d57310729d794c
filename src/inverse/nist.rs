//! The solver on problems of NIST's Statistical Reference Datasets for nonlinear regression
//! (itl.nist.gov/div898/strd/nls/nls_main.shtml): data, starts and certified values are NIST's, in
//! the public domain. Misra1a is of lower difficulty, Thurber and MGH09 are of higher.

use nalgebra::{DMatrix, DVector};

use super::solver::{Residuals, minimise};
use crate::support::math;

struct Problem {
    name: &'static str,
    /// Predictor and response, divided by commas.
    data: &'static str,
    /// The model and its derivatives in the parameters.
    model: fn(f64, &[f64]) -> (f64, Vec<f64>),
    starts: [&'static [f64]; 2],
    /// Certified parameters and their standard deviations.
    certified: &'static [(f64, f64)],
    /// Certified residual sum of squares.
    squares: f64,
}

fn misra(x: f64, b: &[f64]) -> (f64, Vec<f64>) {
    let fade = math::exp(-b[1] * x);
    (b[0] * (1.0 - fade), vec![1.0 - fade, b[0] * x * fade])
}

/// A ratio of two cubic polynomials.
fn thurber(x: f64, b: &[f64]) -> (f64, Vec<f64>) {
    let powers = [1.0, x, x * x, x * x * x];
    let upper: f64 = (0..4).map(|i| b[i] * powers[i]).sum();
    let lower = 1.0 + (1..4).map(|i| b[3 + i] * powers[i]).sum::<f64>();
    let of_upper = powers.iter().map(|power| power / lower);
    let of_lower = powers[1..].iter().map(|power| -upper / (lower * lower) * power);
    (upper / lower, of_upper.chain(of_lower).collect())
}

fn kowalik_osborne(x: f64, b: &[f64]) -> (f64, Vec<f64>) {
    let (upper, lower) = (x * x + x * b[1], x * x + x * b[2] + b[3]);
    let of_lower = -b[0] * upper / (lower * lower);
    (b[0] * upper / lower, vec![upper / lower, b[0] * x / lower, of_lower * x, of_lower])
}

const MISRA1A: Problem = Problem {
    name: "Misra1a",
    data: "77.6 10.07, 114.9 14.73, 141.1 17.94, 190.8 23.93, 239.9 29.61, 289.0 35.18, \
           332.8 40.02, 378.4 44.82, 434.8 50.76, 477.3 55.05, 536.8 61.01, 593.1 66.40, \
           689.1 75.47, 760.0 81.78",
    model: misra,
    starts: [&[500.0, 1e-4], &[250.0, 5e-4]],
    certified: &[(2.389_421_291_8e2, 2.707_007_524_1), (5.501_564_318_1e-4, 7.266_868_843_6e-6)],
    squares: 1.245_513_889_4e-1,
};

const THURBER: Problem = Problem {
    name: "Thurber",
    data: "-3.067 80.574, -2.981 84.248, -2.921 87.264, -2.912 87.195, -2.840 89.076, \
           -2.797 89.608, -2.702 89.868, -2.699 90.101, -2.633 92.405, -2.481 95.854, \
           -2.363 100.696, -2.322 101.060, -1.501 401.672, -1.460 390.724, -1.274 567.534, \
           -1.212 635.316, -1.100 733.054, -1.046 759.087, -0.915 894.206, -0.714 990.785, \
           -0.566 1090.109, -0.545 1080.914, -0.400 1122.643, -0.309 1178.351, \
           -0.109 1260.531, -0.103 1273.514, 0.010 1288.339, 0.119 1327.543, 0.377 1353.863, \
           0.790 1414.509, 0.963 1425.208, 1.006 1421.384, 1.115 1442.962, 1.572 1464.350, \
           1.841 1468.705, 2.047 1447.894, 2.200 1457.628",
    model: thurber,
    starts: [
        &[1000.0, 1000.0, 400.0, 40.0, 0.7, 0.3, 0.03],
        &[1300.0, 1500.0, 500.0, 75.0, 1.0, 0.4, 0.05],
    ],
    certified: &[
        (1.288_139_680_0e3, 4.664_796_334_4),
        (1.491_079_253_5e3, 3.957_115_608_6e1),
        (5.832_383_687_7e2, 2.869_869_610_2e1),
        (7.541_664_429_1e1, 5.567_537_027_0),
        (9.662_950_286_4e-1, 3.133_334_068_7e-2),
        (3.979_728_579_7e-1, 1.498_492_819_8e-2),
        (4.972_729_734_9e-2, 6.584_234_462_3e-3),
    ],
    squares: 5.642_708_239_7e3,
};

const MGH09: Problem = Problem {
    name: "MGH09",
    data: "4.0 1.957e-1, 2.0 1.947e-1, 1.0 1.735e-1, 0.5 1.6e-1, 0.25 8.44e-2, 0.167 6.27e-2, \
           0.125 4.56e-2, 0.1 3.42e-2, 0.0833 3.23e-2, 0.0714 2.35e-2, 0.0625 2.46e-2",
    model: kowalik_osborne,
    starts: [&[25.0, 39.0, 41.5, 39.0], &[0.25, 0.39, 0.415, 0.39]],
    certified: &[
        (1.928_069_345_8e-1, 1.143_531_222_7e-2),
        (1.912_823_287_3e-1, 1.963_322_091_1e-1),
        (1.230_565_069_3e-1, 8.084_203_123_2e-2),
        (1.360_623_306_8e-1, 9.002_554_230_8e-2),
    ],
    squares: 3.075_056_038_5e-4,
};

impl Problem {
    fn data(&self) -> Vec<[f64; 2]> {
        let texts = self.data.split([',', ' ']).filter(|text| !text.is_empty());
        let numbers: Vec<f64> = texts.map(|text| text.parse().expect("a number")).collect();
        numbers.as_chunks().0.to_vec()
    }

    fn residuals(&self, b: &DVector<f64>) -> Residuals {
        let data = self.data();
        let of: Vec<_> = data.iter().map(|[x, _]| (self.model)(*x, b.as_slice())).collect();
        let off = DVector::from_fn(data.len(), |i, _| of[i].0 - data[i][1]);
        (off, DMatrix::from_fn(data.len(), b.len(), |i, j| of[i].1[j]))
    }
}

#[test]
fn certified_parameters_deviations_and_sums_of_squares_are_reached_from_both_starts() {
    for problem in [MISRA1A, THURBER, MGH09] {
        for start in problem.starts {
            let start = DVector::from_row_slice(start);
            let free = vec![[f64::NEG_INFINITY, f64::INFINITY]; start.len()];
            let found = minimise(&|b| problem.residuals(b), &start, &free);
            let name = problem.name;
            assert!(found.converged, "{name}");
            assert!((found.squares() / problem.squares - 1.0).abs() < 1e-9, "{name}");
            let (_, jacobian) = problem.residuals(&found.x);
            let covariance = jacobian.tr_mul(&jacobian).try_inverse().expect("it is regular");
            let freedom = (problem.data().len() - start.len()) as f64;
            for (i, (value, deviation)) in problem.certified.iter().enumerate() {
                assert!((found.x[i] / value - 1.0).abs() < 1e-6, "{name} {i}: {}", found.x[i]);
                let ours = (covariance[(i, i)] * found.squares() / freedom).sqrt();
                assert!((ours / deviation - 1.0).abs() < 1e-5, "{name} {i}: {ours}");
            }
        }
    }
}

/// The derivatives of the problems themselves are right, so that they test the solver.
#[test]
fn the_problems_derivatives_are_those_of_differences() {
    for problem in [MISRA1A, THURBER, MGH09] {
        let b = DVector::from_row_slice(problem.starts[1]);
        let (_, jacobian) = problem.residuals(&b);
        for place in 0..b.len() {
            let step = 1e-6 * b[place];
            let moved = |step: f64| {
                let mut b = b.clone();
                b[place] += step;
                problem.residuals(&b).0
            };
            let differences = (moved(step) - moved(-step)) / (2.0 * step);
            let off = (differences - jacobian.column(place)).norm();
            assert!(off < 1e-6 * jacobian.column(place).norm(), "{} {place}", problem.name);
        }
    }
}

/// With a bound below its best value a parameter stays there, and the others are best for it.
#[test]
fn a_bound_holds_a_parameter_and_the_others_are_best_beside_it() {
    let start = DVector::from_row_slice(MISRA1A.starts[1]);
    let bounds = [[0.0, 230.0], [0.0, 1.0]];
    let found = minimise(&|b| MISRA1A.residuals(b), &start, &bounds);
    assert_eq!((found.x[0], found.held), (230.0, vec![true, false]));
    let (off, jacobian) = MISRA1A.residuals(&found.x);
    let slope = jacobian.column(1).dot(&off);
    assert!(slope.abs() < 1e-6 * jacobian.column(1).norm() * off.norm(), "{slope}");
}
