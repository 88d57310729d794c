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
    /// Weight below which a path is given up.
    pub least_weight: f64,
    /// Trace exactly these paths, whatever they reach: all of a trace, or a part of it.
    pub exactly: Option<Part>,
}

impl Target {
    /// A tolerance, without limits that matter.
    ///
    /// Half of what a path given up might still carry widens the interval. That is at most a tenth
    /// of the tolerance for some of the paths; on dusty beds less than a hundredth in all.
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
    /// Number of paths of the whole trace.
    pub of: u64,
}

impl Part {
    /// One of several parts of about equal size, counted from 1; each but the last is a multiple of
    /// [`LOT`].
    pub fn shard(number: u64, shards: u64, of: u64) -> Self {
        let lots = of.div_ceil(LOT);
        let edge =
            |shard: u64| (u128::from(lots) * u128::from(shard) / u128::from(shards)) as u64 * LOT;
        Self { first: edge(number - 1).min(of), end: edge(number).min(of), of }
    }
}

/// The fewest paths that can show a tolerance. What none of n paths saw has a probability of up to
/// 3 / n (95 %), however small their spread.
pub(crate) fn least_met(tolerance: f64) -> f64 {
    3.0 / tolerance
}

/// What was asked of the trace and what it reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Keys", into = "Keys")]
pub struct Stop {
    /// What was asked.
    pub asked: Asked,
    /// What came of it.
    pub reached: Reached,
    /// Weight, times the paths that a path stands for, below which it was given up: it could bring
    /// no more than this to the sky in any band.
    pub least_weight: f64,
}

/// What is asked of a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct Asked {
    /// Half-width of the 95 % interval, emissivity.
    pub tolerance: f64,
    /// The bands that are to reach it.
    pub grid: Grid,
    /// Most paths; `None` where an exact number of paths is asked for.
    pub max_paths: Option<u64>,
}

/// What a trace reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reached {
    /// Why the trace stopped.
    pub reason: StopReason,
    /// Number of paths of the whole trace, of which this table may hold a part.
    pub wanted: u64,
    /// Widest half-width of any of the bands.
    pub half_width: f64,
    /// Wavelength of that band, um.
    pub widest_at_um: f64,
    /// Whether it is within the tolerance.
    pub tolerance: bool,
    /// The part of the half-width that paths given up leave open: more paths do not lessen it.
    pub trapped: f64,
}

/// The keys of `stop` in a file. A flattened struct would take unknown keys in silence.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    tolerance: f64,
    grid: Grid,
    max_paths: Option<u64>,
    ended_by: StopReason,
    wanted: u64,
    half_width: f64,
    widest_at_um: f64,
    reached: bool,
    trapped: f64,
    least_weight: f64,
}

impl From<Stop> for Keys {
    fn from(Stop { asked, reached, least_weight }: Stop) -> Self {
        let Asked { tolerance, grid, max_paths } = asked;
        let Reached { reason, wanted, half_width, widest_at_um, tolerance: is_met, trapped } =
            reached;
        Self {
            tolerance,
            grid,
            max_paths,
            ended_by: reason,
            wanted,
            half_width,
            widest_at_um,
            reached: is_met,
            trapped,
            least_weight,
        }
    }
}

impl From<Keys> for Stop {
    fn from(keys: Keys) -> Self {
        Self {
            asked: Asked { tolerance: keys.tolerance, grid: keys.grid, max_paths: keys.max_paths },
            reached: Reached {
                reason: keys.ended_by,
                wanted: keys.wanted,
                half_width: keys.half_width,
                widest_at_um: keys.widest_at_um,
                tolerance: keys.reached,
                trapped: keys.trapped,
            },
            least_weight: keys.least_weight,
        }
    }
}

impl Stop {
    /// Of a trace that has not begun.
    pub fn new(target: &Target, grid: Grid) -> Self {
        let reached = Reached::nothing(&grid);
        let max_paths = target.exactly.is_none().then_some(target.max_paths);
        let asked = Asked { tolerance: target.tolerance, grid, max_paths };
        Self { asked, reached, least_weight: target.least_weight }
    }
}

impl Reached {
    /// By no path.
    pub(super) fn nothing(grid: &Grid) -> Self {
        Self {
            reason: StopReason::Interrupted,
            wanted: 0,
            half_width: 1.0,
            widest_at_um: grid.wavelengths_um()[0],
            tolerance: false,
            trapped: 0.0,
        }
    }
}

/// Why a trace stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum StopReason {
    /// It reached the tolerance.
    Tolerance,
    /// More paths would not help: those given up leave too much open.
    Trapped,
    /// It traced all paths that were allowed.
    MaxPaths,
    /// It took all the time that was allowed.
    MaxSeconds,
    /// It traced exactly as many paths as were asked for.
    Paths,
    /// It was interrupted, or is still under way.
    Interrupted,
}

/// How precise a histogram is in its least precise band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// The band.
    pub widest: usize,
    /// The mean weight there.
    pub weight: Mean,
    /// Whether it reaches the tolerance, with enough paths to show it.
    pub reached: bool,
}

impl Precision {
    /// Of the bands, each given as one reflectance for each symbol.
    pub fn of(histogram: &Histogram, bands: &[Vec<f64>], tolerance: f64) -> Self {
        let wider = |a: &(usize, Mean), b: &(usize, Mean)| {
            // Of several equally wide bands the first.
            a.1.half_width().total_cmp(&b.1.half_width()).then(b.0.cmp(&a.0))
        };
        let weights = histogram.weight_in(bands).into_iter().enumerate();
        let (widest, weight) = weights.max_by(wider).expect("there is at least one band");
        let enough = histogram.paths() >= least_met(tolerance);
        Self { widest, weight, reached: weight.half_width() <= tolerance && enough }
    }
}
