//! The rules that paths go by, and what of them has to be kept.

use crate::histogram::tally::Kept;
use crate::support::random::Sampler;
use crate::table::{Prepared, TableMaterial};

/// Hits after which a path is given up, however much it may still carry: two mirrors face to face would hold it for
/// ever.
pub const MOST_HITS: u16 = 128;

/// How a facet sends on what it reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facet {
    /// The share that is specular, 0 to 1; the rest is Lambertian.
    pub specular: f64,
    /// Whether its reflectance depends on the angle of the hit.
    pub by_angle: bool,
}

impl Facet {
    /// Reflects alike into all directions, alike from all.
    pub const LAMBERTIAN: Self = Self { specular: 0.0, by_angle: false };
}

/// The rules that paths go by.
#[derive(Debug, Clone, PartialEq)]
pub struct TracingRules {
    /// What is kept of a path.
    pub kept: Kept,
    /// The facets of each material.
    pub facets: Vec<Facet>,
    /// Where paths take their numbers from.
    pub sampler: Sampler,
    /// Hits after which a path is given up.
    pub most_hits: u16,
    /// The greatest reflectance of each symbol in any of the bands that matter.
    pub greatest: Vec<f64>,
    /// A path is given up when the product of those, times the share of it that is under way and the paths that it stands for, is
    /// below this weight.
    pub least_weight: f64,
}

impl TracingRules {
    /// The rules of a scene: records the least that serves it. Paths go on to the last hit.
    pub fn new(prepared: &Prepared) -> Self {
        let of =
            |m: &TableMaterial| Facet { specular: m.specular, by_angle: m.spectrum.is_angular() };
        let facets: Vec<Facet> = prepared.materials.iter().map(of).collect();
        let kept = prepared.kept;
        let greatest = vec![1.0; kept.symbols(facets.len())];
        let sampler = Sampler::Even;
        Self { kept, facets, sampler, most_hits: MOST_HITS, greatest, least_weight: 0.0 }
    }

    /// Gives paths up whose weight is below `least_weight` in each of the bands, which are given as a reflectance for
    /// each symbol.
    #[must_use]
    pub fn ending_below(mut self, least_weight: f64, bands: &[Vec<f64>]) -> Self {
        for (symbol, greatest) in self.greatest.iter_mut().enumerate() {
            *greatest = bands.iter().map(|band| band[symbol]).fold(0.0, f64::max);
        }
        self.least_weight = least_weight;
        self
    }
}
