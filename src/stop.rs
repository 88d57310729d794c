//! When the rays are enough: a pilot tells how many paths the tolerance needs, the result is
//! traced with paths of its own.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::random::Purpose;
use crate::table::{Weight, Z_95, sorted, weight};
use crate::tally::Tally;
use crate::tracer::Tracer;

/// Paths of the pilot.
const PILOT: u64 = 4096;
/// Least paths of a result.
const LEAST: u64 = 8192;
/// Paths are traced in lots of this size.
const LOT: u64 = 1024;
/// What the pilot says is raised by so much, so that one round is nearly always enough.
const MARGIN: f64 = 1.1;

/// What to reach, and what at most to spend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Target {
    /// Half-width of the 95 % interval in emissivity that every band is to reach.
    pub tolerance: f64,
    /// Most paths.
    pub max_paths: u64,
}

/// Paths traced until the target was reached or could not be.
#[derive(Debug)]
pub struct Traced {
    /// The counts.
    pub tally: Tally,
    /// Widest half-width of any band.
    pub half_width: f64,
    /// The band that has it.
    pub widest: usize,
    /// What of it trapped paths leave open.
    pub trapped: f64,
    /// Whether the target was reached.
    pub reached: bool,
}

/// Traces until every band, given as one reflectance for each material, has its half-width.
///
/// `progress` is told how many paths are done and how many are wanted.
pub fn trace(
    tracer: &Tracer,
    seed: u64,
    bands: &[Vec<f64>],
    target: Target,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Traced, Error> {
    let pilot = tracer.trace(seed, Purpose::Pilot, 0, PILOT.min(target.max_paths), &|_| ())?;
    let mut wanted = more(&pilot, bands, target).clamp(LEAST, LEAST.max(target.max_paths));
    wanted = wanted.min(target.max_paths);
    let mut tally: Option<Tally> = None;
    loop {
        let first = tally.as_ref().map_or(0, |tally| tally.paths);
        let done = std::sync::atomic::AtomicU64::new(first);
        let lot = tracer.trace(seed, Purpose::Result, first, wanted - first, &|paths| {
            let sum = done.fetch_add(paths, std::sync::atomic::Ordering::Relaxed) + paths;
            progress(sum, wanted);
        })?;
        let so_far = match tally.take() {
            None => lot,
            Some(mut sum) => {
                sum.add(&lot);
                sum
            }
        };
        let (half_width, widest, weight) = widest(&so_far, bands);
        let next = more(&so_far, bands, target).min(target.max_paths);
        let met = (so_far.paths - so_far.missed) as f64;
        let reached = half_width <= target.tolerance && met >= least_met(target);
        if reached || next <= so_far.paths {
            let trapped = weight.trapped;
            return Ok(Traced { tally: so_far, half_width, widest, trapped, reached });
        }
        wanted = next;
        tally = Some(so_far);
    }
}

/// How many paths the target needs in all, by what these paths show. No more than there are where more
/// would not help: when what trapped paths leave open is wider than the tolerance.
fn more(tally: &Tally, bands: &[Vec<f64>], target: Target) -> u64 {
    let met = (tally.paths - tally.missed) as f64;
    let (_, _, weight) = widest(tally, bands);
    let room = target.tolerance - weight.trapped;
    if met < 2.0 {
        // A small target in a wide view: look on.
        return 16 * tally.paths;
    }
    if room <= 0.0 {
        return tally.paths;
    }
    let ratio = Z_95 * weight.standard_error / room;
    let needed = (met * ratio * ratio).max(least_met(target)) * MARGIN;
    let paths = needed * tally.paths as f64 / met;
    (paths.min(1e18) as u64).div_ceil(LOT) * LOT
}

/// What no path saw of n has a probability of up to 3 / n (95 %): even without any spread the paths
/// must be as many as that asks for.
fn least_met(target: Target) -> f64 {
    3.0 / target.tolerance
}

fn widest(tally: &Tally, bands: &[Vec<f64>]) -> (f64, usize, Weight) {
    let (escaped, trapped) = (sorted(&tally.escaped), sorted(&tally.trapped));
    bands
        .par_iter()
        .enumerate()
        .map(|(band, reflectance)| {
            let weight = weight(
                escaped.iter().map(|(state, count)| (&**state, *count)),
                trapped.iter().map(|(state, count)| (&**state, *count)),
                reflectance,
            );
            (weight.half_width(), band, weight)
        })
        .reduce_with(|a, b| if (b.0, a.1) > (a.0, b.1) { b } else { a })
        .expect("there is at least one band")
}
