//! Several packings of one recipe: their mean, and how far it can be trusted.
//!
//! A drop is a random draw: the next one of the same recipe has other grains on top. The mean over packings is
//! the recipe's own signature, and the spread between them its error, the noise of the rays included, since
//! each packing is traced with rays of its own.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::histogram::{Mean, T_95};
use crate::signature::Band;
use crate::table::Table;

/// Packings of a pilot, whose spread tells how many a tolerance takes.
pub const PILOT: usize = 6;

/// The most packings that a plan asks for.
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

/// How many packings a tolerance takes, by a pilot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Packings of the pilot; they are part of the result.
    pub pilot: usize,
    /// Standard deviation between them, in the band where it is greatest.
    pub spread: f64,
    /// Where that is, um.
    pub at_um: f64,
    /// Packings that the tolerance takes.
    pub wanted: usize,
    /// Packings that are dropped: no more than [`MOST`].
    pub packings: usize,
}

impl Plan {
    /// By Stein's two stages (Ann. Math. Statist. 16, 243 (1945)): with the quantile of the pilot's own degrees of
    /// freedom the mean of that many packings is within the tolerance at 95 %, however the pilot's spread came out. An
    /// interval from the spread of all packings, as results have it, may be a little wider or narrower.
    pub fn new(bands: &[Band], pilot: usize, tolerance: f64) -> Self {
        let (spread, at_um, room) = bands
            .iter()
            .filter_map(|band| {
                let e = band.emissivity;
                Some((e.spread?, band.wavelength_um, tolerance - e.trapped))
            })
            .max_by(|a, b| (a.0 / a.2.max(0.0)).total_cmp(&(b.0 / b.2.max(0.0))))
            .expect("a pilot has bands and a spread");
        let wanted = (quantile_95(pilot) * spread / room.max(0.0)).powi(2).ceil().min(1e9);
        let wanted = (wanted as usize).max(pilot);
        Self { pilot, spread, at_um, wanted, packings: wanted.min(MOST) }
    }
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
/// are replicates where a single packing is known by its rays alone.
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
    use crate::random::{Purpose, REPLICATES, Source};

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (packings, t) in
            [(2, 12.706_2), (3, 4.302_7), (5, 2.776_4), (11, 2.228_1), (121, 1.979_9)]
        {
            assert!((quantile_95(packings) - t).abs() < 1e-4, "{packings}");
        }
        assert!((quantile_95(REPLICATES) - T_95).abs() < 1e-6);
    }

    /// Pilots and results of normally distributed packings.
    #[test]
    fn a_planned_mean_is_within_the_tolerance_as_often_as_promised() {
        let mut random = Source::new(11, Purpose::Packing).stream(0);
        let mut normal = || {
            let [u, v] = random.pair();
            (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        };
        let (mut held, runs) = (0, 4000);
        for _ in 0..runs {
            let mut packings: Vec<Mean> = Vec::new();
            let mut drop = |packings: &mut Vec<Mean>, n: usize| {
                while packings.len() < n {
                    packings.push(Mean {
                        mean: 0.0066 * normal(),
                        standard_error: 0.0,
                        trapped: 0.0,
                    });
                }
            };
            drop(&mut packings, PILOT);
            let band = Band { emissivity: Estimate::of(&packings), ..Band::default() };
            let plan = Plan::new(&[band], PILOT, 0.002);
            drop(&mut packings, plan.packings);
            held += u32::from(Estimate::of(&packings).mean.abs() <= 0.002);
        }
        let share = f64::from(held) / f64::from(runs);
        // Two-sided 95 % of 4000 trials is +-.7 %; whole packings, and a pilot that is enough, make it hold more often.
        assert!((0.943..0.97).contains(&share), "{share}");
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
