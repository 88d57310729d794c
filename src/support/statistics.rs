//! Quantiles and half-widths of 95 % intervals (Student's t).

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Quantile of Student's t, two-sided 95 %, with as many degrees of freedom as pairs of groups.
pub const T_95: f64 = 2.119_905_299;

/// Greatest difference of the sum of shares from 1: shares are given with few digits.
pub(crate) const SHARES_ROUNDING: f64 = 1e-6;

/// Quantile of Student's t, two-sided 95 %, with one degree of freedom less than packings. For one
/// packing it is [`T_95`].
pub fn quantile_95(packings: usize) -> f64 {
    if packings < 2 { T_95 } else { quantile_of((packings - 1) as f64) }
}

/// Quantile of Student's t, two-sided 95 %, with so many degrees of freedom, which need not be
/// whole.
///
/// # Panics
/// Without a degree of freedom.
pub fn quantile_of(freedom: f64) -> f64 {
    let t = StudentsT::new(0.0, 1.0, freedom).expect("degrees of freedom are above 0");
    // Beyond these digits it depends on the processor's instruction set (`support::math`).
    (t.inverse_cdf(0.975) * 1e9).round() / 1e9
}

/// The same of a normal distribution.
pub const NORMAL_95: f64 = 1.959_964;

/// Half-width of the 95 % interval of the mean of `values`, one per packing; `None` for fewer than
/// two.
pub fn half_width(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (values.len() > 1).then(|| quantile_95(values.len()) * (squares / (n - 1.0) / n).sqrt())
}

/// The number of packings that reach a half-width, given the standard deviation between packings;
/// `None` above a million.
pub fn wanted(spread: f64, half_width: f64) -> Option<usize> {
    let enough = |n: usize| quantile_95(n) * spread <= half_width * (n as f64).sqrt();
    let most = (2..=20).map(|power| 1 << power).find(|&n| enough(n))?;
    // The half-width falls with the number, so bisection finds the least.
    let (mut too_few, mut least) = (1, most);
    while least - too_few > 1 {
        let middle = usize::midpoint(too_few, least);
        if enough(middle) { least = middle } else { too_few = middle }
    }
    Some(least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::random::GROUPS;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (packings, t) in
            [(2, 12.706_2), (3, 4.302_7), (5, 2.776_4), (11, 2.228_1), (121, 1.979_9)]
        {
            assert!((quantile_95(packings) - t).abs() < 1e-4, "{packings}");
        }
        assert!((quantile_95(GROUPS / 2 + 1) - T_95).abs() < 1e-6);
    }

    #[test]
    fn the_number_of_packings_is_the_least_that_suffices() {
        for (spread, half_width) in [(0.0044, 0.01), (0.0044, 0.005), (0.0044, 0.001), (1e-9, 0.1)]
        {
            let n = wanted(spread, half_width).expect("few enough");
            let reached = |n: usize| quantile_95(n) * spread / (n as f64).sqrt();
            assert!(reached(n) <= half_width, "{n}");
            assert!(n == 2 || reached(n - 1) > half_width, "{n}");
        }
        assert_eq!(wanted(1.0, 1e-6), None);
    }
}
