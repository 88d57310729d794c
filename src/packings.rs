//! Several packings of one recipe: their mean, and how far it can be trusted.
//!
//! A drop is a random draw: the next one of the same recipe has other grains on top. The mean over packings is
//! the recipe's own signature, and the spread between them its error, the noise of the rays included, since
//! each packing is traced with rays of its own.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::histogram::{Mean, T_95};
use crate::table::Table;

/// The most packings of a result.
pub const MOST: usize = 1000;

/// How many packings are dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum HowMany {
    /// So many.
    Number(usize),
    /// As many as the tolerance takes.
    Planned(Auto),
}

/// The word for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Auto {
    /// As many as the tolerance takes.
    Auto,
}

/// What packings say of a quantity in one band.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// Mean over the packings, which all weigh alike.
    pub mean: f64,
    /// Standard error of the mean, from the spread between packings; of a single packing from its rays.
    pub standard_error: f64,
    /// Half-width of the 95 % interval, by Student's t. What paths given up leave open is in it.
    pub half_width: f64,
    /// What of the standard error the rays make.
    pub rays_standard_error: f64,
    /// Standard deviation between packings; `None` of a single one.
    pub spread: Option<f64>,
    /// What of the half-width paths given up leave open.
    pub trapped: f64,
}

impl Estimate {
    /// The estimate from each packing's own mean.
    pub fn of(packings: &[Mean]) -> Self {
        let n = packings.len() as f64;
        let mean = packings.iter().map(|p| p.mean).sum::<f64>() / n;
        let trapped = packings.iter().map(|p| p.trapped).sum::<f64>() / n;
        let rays = packings.iter().map(|p| p.standard_error.powi(2)).sum::<f64>().sqrt() / n;
        let (spread, standard_error) = if packings.len() > 1 {
            let squares: f64 = packings.iter().map(|p| (p.mean - mean).powi(2)).sum();
            let spread = (squares / (n - 1.0)).sqrt();
            // Packings that happen to agree are no surer than their rays.
            (Some(spread), (spread / n.sqrt()).max(rays))
        } else {
            (None, rays)
        };
        Self {
            mean,
            standard_error,
            half_width: quantile_95(packings.len()) * standard_error + trapped,
            rays_standard_error: rays,
            spread,
            trapped,
        }
    }

    /// The emissivity for one reflectance of each symbol of the tables.
    pub fn emissivity(packings: &[Table], reflectance: &[f64]) -> Self {
        let of = |packing: &Table| {
            let weight = packing.weight(reflectance);
            Mean { mean: 1.0 - weight.mean, ..weight }
        };
        Self::of(&packings.iter().map(of).collect::<Vec<_>>())
    }
}

/// Quantile for two-sided 95 %: Student's t with one degree of freedom less than there are packings, or than there
/// are pairs of groups where a single packing is known by its rays alone.
pub fn quantile_95(packings: usize) -> f64 {
    if packings < 2 {
        return T_95;
    }
    let t =
        StudentsT::new(0.0, 1.0, (packings - 1) as f64).expect("at least one degree of freedom");
    t.inverse_cdf(0.975)
}

/// Half-width of the 95 % interval of the mean of one number of each packing; `None` of fewer than two.
pub fn half_width(of_each: &[f64]) -> Option<f64> {
    let n = of_each.len() as f64;
    let mean = of_each.iter().sum::<f64>() / n;
    let squares: f64 = of_each.iter().map(|value| (value - mean).powi(2)).sum();
    (of_each.len() > 1).then(|| quantile_95(of_each.len()) * (squares / (n - 1.0) / n).sqrt())
}

/// How many packings of that spread it takes to get to a half-width; `None` if it is more than a million.
pub fn wanted(spread: f64, half_width: f64) -> Option<usize> {
    let enough = |n: usize| quantile_95(n) * spread <= half_width * (n as f64).sqrt();
    let most = (2..=20).map(|power| 1 << power).find(|&n| enough(n))?;
    // More packings never do worse, so halving finds the least.
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
    use crate::random::GROUPS;

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
    fn the_packings_wanted_are_the_fewest_that_do() {
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
