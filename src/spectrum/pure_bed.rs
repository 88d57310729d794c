//! A bed of one powder alone: its reflectance from that of its facets, and the inverse.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

/// Bisections of the interval from 0 to 1 that separate neighbouring numbers above 0.001.
const BISECTIONS: u32 = 64;

/// Largest difference of the sum of a bed's shares from 1.
const BY_CHANCE: f64 = 0.1;

/// A bed of Lambertian facets of one material.
///
/// A path that hits n facets brings their reflectance to the power of n to the sky. So the bed's
/// reflectance is a power series, which rises with that of the facets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PureBed {
    /// Which bed it is.
    pub title: String,
    /// Share of the paths that reached the sky after 0, 1, 2, ... hits, the mean over beds.
    pub escaped: Vec<f64>,
    /// The same for paths that were given up.
    pub given_up: Vec<f64>,
    /// Standard error of the bed's reflectance, the largest over all reflectances of the facets. It
    /// comes from the spread between several beds, or from the rays of one.
    pub standard_error: f64,
}

impl PureBed {
    /// The shipped pure bed.
    pub fn shipped() -> &'static Self {
        static BED: LazyLock<PureBed> = LazyLock::new(|| {
            serde_json::from_str(include_str!("../../spectra/pure_bed.json"))
                .expect("a test reads the bed")
        });
        &BED
    }

    /// The bed's reflectance for facets of a reflectance from 0 to 1. Paths that were given up
    /// count half of what they may still bring, as in every signature.
    pub fn reflectance(&self, facet: f64) -> f64 {
        let series =
            |shares: &[f64]| shares.iter().rev().fold(0.0, |sum, share| sum * facet + share);
        series(&self.escaped) + series(&self.given_up) / 2.0
    }

    /// The facets' reflectance that gives the bed the reflectance `needed`; `None` if even white
    /// facets give less.
    pub fn facet(&self, needed: f64) -> Option<f64> {
        if needed > self.reflectance(1.0) + 1e-12 {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = f64::midpoint(low, high);
            if self.reflectance(middle) < needed { low = middle } else { high = middle }
        }
        Some(high)
    }

    /// Why it is not a valid bed, if it is not: its file may be of another origin. The shares of
    /// paths add up to 1, except for what Russian roulette ended or added by chance.
    pub(crate) fn problem(&self) -> Option<String> {
        let shares = || self.escaped.iter().chain(&self.given_up);
        let sum: f64 = shares().sum();
        (!shares().all(|share| (0.0..=1.0).contains(share)) || (sum - 1.0).abs() > BY_CHANCE)
            .then(|| format!("the path shares of the pure bed {} do not add up to 1", self.title))
    }
}
