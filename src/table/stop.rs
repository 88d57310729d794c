//! What a trace is asked to reach, and what it reached.

use serde::{Deserialize, Serialize};

use crate::histogram::{Histogram, Mean};
use crate::scene::Grid;
use crate::support::random::LOT;

/// What to reach, and what at most to spend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Target {
    /// Half-width of the 95 % interval in emissivity that every band is to reach.
    pub tolerance: f64,
    /// Most paths.
    pub max_paths: u64,
    /// Longest time, seconds.
    pub max_seconds: Option<f64>,
    /// The weight below which a path is given up.
    pub least_weight: f64,
    /// The paths of these numbers and no others, whatever they reach: all of a trace, or a part of it.
    pub exactly: Option<Part>,
}

impl Target {
    /// A tolerance, with no limits that matter. Half of what a path that is given up might still carry, at most a tenth of the
    /// tolerance and that of some of the paths only, is added to the interval: on dusty beds less than a hundredth of the
    /// tolerance.
    pub fn of(tolerance: f64) -> Self {
        let least_weight = tolerance / 5.0;
        Self { tolerance, max_paths: 1 << 40, max_seconds: None, least_weight, exactly: None }
    }
}

/// Some of the paths of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Part {
    /// Number of the first path.
    pub first: u64,
    /// One more than that of the last.
    pub end: u64,
    /// How many paths the whole trace has.
    pub of: u64,
}

impl Part {
    /// One of several parts of about equal size, counted from 1; each a multiple of [`LOT`] but for the rest.
    pub fn shard(number: u64, shards: u64, of: u64) -> Self {
        let lots = of.div_ceil(LOT);
        let edge =
            |shard: u64| (u128::from(lots) * u128::from(shard) / u128::from(shards)) as u64 * LOT;
        Self { first: edge(number - 1).min(of), end: edge(number).min(of), of }
    }
}

/// What no path saw of n has a probability of up to 3 / n (95 %): even without any spread the paths
/// must be as many as that asks for.
pub(crate) fn least_met(tolerance: f64) -> f64 {
    3.0 / tolerance
}

/// What was asked of the trace and what it reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Half-width asked for, emissivity, at 95 %.
    pub tolerance: f64,
    /// The bands that were to reach it.
    pub grid: Grid,
    /// Most paths that were allowed; `None` where exactly so many were asked for.
    pub max_paths: Option<u64>,
    /// What ended the trace.
    pub ended_by: Ended,
    /// How many paths the whole trace has, of which this table may hold a part.
    pub wanted: u64,
    /// Widest half-width of any of the bands.
    pub half_width: f64,
    /// Where it is, um.
    pub widest_at_um: f64,
    /// Whether the tolerance was reached.
    pub reached: bool,
    /// What of the half-width paths that were given up leave open: more paths do not lessen it.
    pub trapped: f64,
    /// Weight, with all that it stood for, below which a path was given up: in none of the bands could it bring more to the sky.
    pub least_weight: f64,
}

impl Stop {
    /// Of a trace that has still to begin.
    pub fn new(target: &Target, grid: Grid) -> Self {
        Self {
            tolerance: target.tolerance,
            max_paths: target.exactly.is_none().then_some(target.max_paths),
            widest_at_um: grid.wavelengths_um()[0],
            grid,
            ended_by: Ended::Interrupted,
            wanted: 0,
            half_width: 1.0,
            reached: false,
            trapped: 0.0,
            least_weight: target.least_weight,
        }
    }

    /// What was asked, without what came of it.
    pub(super) fn asked(&self) -> Self {
        Self {
            widest_at_um: self.grid.wavelengths_um()[0],
            ended_by: Ended::Interrupted,
            wanted: 0,
            half_width: 1.0,
            reached: false,
            trapped: 0.0,
            ..self.clone()
        }
    }
}

/// What ends a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// The tolerance was reached.
    Tolerance,
    /// More paths would not help: those that were given up leave too much open.
    Trapped,
    /// All paths that were allowed are traced.
    MaxPaths,
    /// The time that was allowed is over.
    MaxSeconds,
    /// As many paths as were asked for are traced, whatever they reach.
    Paths,
    /// It was interrupted, or is still under way.
    Interrupted,
}

/// How sure a histogram is in the band where it is least so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sureness {
    /// The band.
    pub widest: usize,
    /// The mean weight there.
    pub weight: Mean,
    /// Whether it reaches the tolerance, with enough paths to say so.
    pub reached: bool,
}

impl Sureness {
    /// Of the bands, given as one reflectance for each symbol.
    pub fn of(histogram: &Histogram, bands: &[Vec<f64>], tolerance: f64) -> Self {
        let weights = histogram.weight_in(bands);
        let wider = |a: &(usize, Mean), b: &(usize, Mean)| {
            // The first of several that are as wide.
            a.1.half_width().total_cmp(&b.1.half_width()).then(b.0.cmp(&a.0))
        };
        let (widest, weight) =
            weights.into_iter().enumerate().max_by(wider).expect("there is at least one band");
        let enough = histogram.paths() >= least_met(tolerance);
        Self { widest, weight, reached: weight.half_width() <= tolerance && enough }
    }
}
