//! A bed of one powder alone: what it makes of the reflectance of its facets, and the way back.

use serde::{Deserialize, Serialize};

/// Halvings of the interval from 0 to 1 that leave nothing between two neighbouring numbers above .001.
const HALVINGS: u32 = 64;

/// What the sum of a bed's shares is off 1 by, at most.
const BY_CHANCE: f64 = 0.1;

/// A bed of Lambertian facets of one material. The path that hits n of them brings their reflectance to the power of n
/// to the sky: the bed's reflectance is a power series, rising with that of the facets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PureBed {
    /// What bed it is.
    pub title: String,
    /// Share of the paths that reached the sky after 0, 1, 2, ... hits, the mean over beds.
    pub escaped: Vec<f64>,
    /// The same of paths that were given up.
    pub given_up: Vec<f64>,
    /// Standard error of the bed's reflectance, the greatest of any reflectance of the facets: of several beds from the
    /// spread between them, of one from its rays.
    pub standard_error: f64,
}

impl PureBed {
    /// The shipped pure bed.
    pub fn shipped() -> &'static Self {
        super::shipped::pure_bed()
    }

    /// The bed's reflectance for that of its facets, 0 to 1. Paths that were given up count with half of what they may
    /// still bring, as in every signature.
    pub fn reflectance(&self, facet: f64) -> f64 {
        let series =
            |shares: &[f64]| shares.iter().rev().fold(0.0, |sum, share| sum * facet + share);
        series(&self.escaped) + series(&self.given_up) / 2.0
    }

    /// The reflectance of facets of which the bed has the one wanted; `None` where white facets do not suffice.
    pub fn facet(&self, wanted: f64) -> Option<f64> {
        let white = self.reflectance(1.0);
        if wanted > white + 1e-12 {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            if self.reflectance(middle) < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(high)
    }

    /// What makes it no bed: it may have been written by other hands. Shares of paths make 1 but for what Russian roulette
    /// happened to end or add.
    pub(crate) fn problem(&self) -> Option<String> {
        let shares = || self.escaped.iter().chain(&self.given_up);
        let sum: f64 = shares().sum();
        (!shares().all(|share| (0.0..=1.0).contains(share)) || (sum - 1.0).abs() > BY_CHANCE)
            .then(|| format!("the shares of paths of the pure bed {} do not make 1", self.title))
    }
}
