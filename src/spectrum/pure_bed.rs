//! A bed of one powder alone: what it makes of the reflectance of its facets, and the way back.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::SpectrumError;
use crate::histogram::Mean;
use crate::packings::Estimate;
use crate::table::Table;
use crate::tally::Kept;

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
    /// Reads the bounce tables of one bed or of several packings of one.
    ///
    /// # Errors
    /// Tables that cannot be read, of more than one material, or of other than Lambertian facets.
    pub fn read(tables: &[PathBuf]) -> Result<Self, SpectrumError> {
        let beds = Table::read_packings(tables).map_err(SpectrumError::PureBedTable)?;
        for (table, path) in beds.iter().zip(tables) {
            let problem = if table.materials.len() != 1 {
                format!(
                    "a pure bed is of one material, its floor too, not of {}",
                    table.materials.len()
                )
            } else if table.histogram.kept != Kept::PLAIN || table.materials[0].specular != 0.0 {
                "the facets of a pure bed are Lambertian, of one temperature under an isotropic sky"
                    .into()
            } else {
                continue;
            };
            return Err(SpectrumError::PureBed { path: path.clone(), problem });
        }
        let name = &beds[0].scene;
        let title = match beds.len() {
            1 => format!("{name}, one bed"),
            n => format!("{name}, the mean of {n} packings"),
        };
        let bed = Self::of(title, &beds);
        match bed.problem() {
            Some(problem) => Err(SpectrumError::PureBed { path: tables[0].clone(), problem }),
            None => Ok(bed),
        }
    }

    /// The mean of beds that all are of one material.
    fn of(title: String, beds: &[Table]) -> Self {
        let (mut escaped, mut given_up) = (Vec::new(), Vec::new());
        for bed in beds {
            let states =
                [(&mut escaped, &bed.histogram.escaped), (&mut given_up, &bed.histogram.trapped)];
            let all = bed.histogram.paths() * bed.histogram.parts as f64;
            for (shares, of) in states {
                for (state, counts) in of {
                    let hits = usize::from(state[0]);
                    if shares.len() <= hits {
                        shares.resize(hits + 1, 0.0);
                    }
                    shares[hits] += count(counts) as f64 / all / beds.len() as f64;
                }
            }
        }
        let error = |percent: u32| {
            let facet = [f64::from(percent) / 100.0];
            let means: Vec<Mean> = beds.iter().map(|bed| bed.weight(&facet)).collect();
            Estimate::of(&means).standard_error
        };
        let standard_error = (0..=100).map(error).fold(0.0, f64::max);
        Self { title, escaped, given_up, standard_error }
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
    pub(super) fn problem(&self) -> Option<String> {
        let shares = || self.escaped.iter().chain(&self.given_up);
        let sum: f64 = shares().sum();
        (!shares().all(|share| (0.0..=1.0).contains(share)) || (sum - 1.0).abs() > BY_CHANCE)
            .then(|| format!("the shares of paths of the pure bed {} do not make 1", self.title))
    }
}

fn count(counts: &[(u16, i64)]) -> i64 {
    counts.iter().map(|(_, count)| count).sum()
}
