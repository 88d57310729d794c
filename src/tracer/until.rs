//! Traces until the target is reached: a pilot estimates how many paths the tolerance needs, and
//! the result is traced with paths of its own.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::histogram::Histogram;
use crate::histogram::tally::Tally;
use crate::support::error::Error;
use crate::support::math;
use crate::support::monitor::Monitor;
use crate::support::random::{LOT, Purpose};
use crate::support::statistics::T_95;
use crate::table::stop::least_met;
use crate::table::{Precision, StopReason, Target};
use crate::tracer::rules::TracingRules;
use crate::tracer::{Tracer, WAVE};

/// Paths of the pilot.
const PILOT: u64 = 1024;
/// Least paths between two looks at the time.
const LEAST_WAVE: u64 = 512;
/// Paths of it that do if they show that half of [`LEAST`] would be enough.
const GLANCE: u64 = 256;
/// Least paths of a result.
const LEAST: u64 = 8192;
/// Paths after which a view that has met nothing is given up.
const MOST_MISSED: u64 = 1 << 20;
/// The variance of a mean over evenly spread paths falls with this power of their number
/// (docs/physics/sampling.md).
const EVENNESS: f64 = 1.2;
/// The pilot's estimate is multiplied by this, so that one round is mostly enough. The spreads of
/// the pilot and of the result are each known to a fifth. Where rounds end as soon as the spread is
/// small by chance, intervals contain the truth too seldom.
const MARGIN: f64 = 1.5;
/// Time after which the paths so far are saved.
const SAVE_EVERY: Duration = Duration::from_secs(10);

/// What to trace until the target is reached.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// How paths are traced.
    pub rules: &'a TracingRules,
    /// Random seed.
    pub seed: u64,
    /// The bands that are to reach the tolerance, each as one reflectance for each symbol.
    pub bands: &'a [Vec<f64>],
    /// What to reach, and what at most to spend.
    pub target: Target,
    /// What an earlier trace of the same kind saved.
    pub resume: Option<&'a TracedPaths>,
    /// Told how many paths are done and wanted; may stop the trace.
    pub monitor: &'a dyn Monitor,
    /// What the monitor is told is traced.
    pub what: &'a str,
    /// Given the paths so far, every few seconds and when the trace is interrupted.
    pub save: &'a (dyn Fn(&TracedPaths) -> Result<(), Error> + Sync),
}

impl<'a> Request<'a> {
    /// A trace from the beginning that saves nothing on its way.
    pub fn new(
        rules: &'a TracingRules,
        seed: u64,
        bands: &'a [Vec<f64>],
        target: Target,
        monitor: &'a dyn Monitor,
    ) -> Self {
        let (what, save) = ("paths", &|_: &TracedPaths| Ok(()));
        Self { rules, seed, bands, target, resume: None, monitor, what, save }
    }
}

/// Paths traced until the target was reached or could not be.
#[derive(Debug, Clone)]
pub struct TracedPaths {
    /// The counts.
    pub tally: Tally,
    /// Number of paths of the whole trace.
    pub wanted: u64,
    /// Why the trace stopped.
    pub reason: StopReason,
}

/// Traces until every band reaches the target.
///
/// # Errors
/// The monitor stopped it.
pub fn trace(tracer: &Tracer, request: &Request) -> Result<TracedPaths, Error> {
    let Request { rules, target, monitor, .. } = *request;
    let started = Instant::now();
    let first = target.exactly.map_or(0, |part| part.first);
    let fresh = |wanted| {
        let reason = StopReason::Interrupted;
        TracedPaths { tally: tracer.nothing(rules), wanted, reason }
    };
    // Paths traced since the start.
    let mut ended = 0;
    let mut traced = match (request.resume, target.exactly) {
        (Some(earlier), _) => earlier.clone(),
        (None, Some(part)) => fresh(part.of),
        (None, None) => {
            let (paths, wanted) = pilot(tracer, request)?;
            ended = paths;
            fresh(wanted.max(LEAST).min(target.max_paths))
        }
    };
    let mut last_saved = Instant::now();
    loop {
        let wanted = target.exactly.map_or(traced.wanted, |part| part.end) - first;
        while traced.tally.paths < wanted {
            let from = first + traced.tally.paths;
            let wave = target.max_seconds.map_or(WAVE, |most| wave_in(most, started, ended));
            let to = (from + wave).min(first + wanted);
            let done = AtomicU64::new(traced.tally.paths);
            let wave = tracer.trace(rules, request.seed, Purpose::Result, from..to, &|paths| {
                let sum = done.fetch_add(paths, Ordering::Relaxed) + paths;
                monitor.at(sum, wanted, request.what);
                monitor.check()
            });
            match wave {
                Ok(wave) => {
                    ended += wave.paths;
                    traced.tally.add(&wave);
                }
                Err(error) => {
                    (request.save)(&traced)?;
                    return Err(error.into());
                }
            }
            if target.max_seconds.is_some_and(|most| started.elapsed().as_secs_f64() >= most) {
                traced.reason = StopReason::MaxSeconds;
                traced.wanted = traced.tally.paths;
                return Ok(traced);
            }
            if last_saved.elapsed() >= SAVE_EVERY {
                (request.save)(&traced)?;
                last_saved = Instant::now();
            }
        }
        if target.exactly.is_some() {
            traced.reason = StopReason::Paths;
            return Ok(traced);
        }
        let (next, reached) = paths_needed(&traced.tally, request);
        let next = next.min(target.max_paths);
        if reached || next <= traced.tally.paths {
            traced.reason = if reached {
                StopReason::Tolerance
            } else if traced.tally.paths >= target.max_paths {
                StopReason::MaxPaths
            } else {
                StopReason::Trapped
            };
            return Ok(traced);
        }
        traced.wanted = next;
    }
}

/// Paths to trace before the time is looked at again: those that are likely to end by a limit,
/// seconds since a start, by the time that `ended` paths took.
fn wave_in(limit_s: f64, started: Instant, ended: u64) -> u64 {
    let taken_s = started.elapsed().as_secs_f64();
    let more = ended as f64 * (limit_s / taken_s - 1.0);
    (more as u64).clamp(LEAST_WAVE, WAVE)
}

/// Traces a few paths, which are thrown away: how many, and how many the target needs by them.
fn pilot(tracer: &Tracer, request: &Request) -> Result<(u64, u64), Error> {
    let Request { rules, seed, target, monitor, .. } = *request;
    let mut pilot = tracer.nothing(rules);
    let mut wanted = 0;
    for end in [GLANCE, PILOT] {
        let numbers = pilot.paths..end.min(target.max_paths);
        pilot.add(&tracer.trace(rules, seed, Purpose::Pilot, numbers, &|_| monitor.check())?);
        (wanted, _) = paths_needed(&pilot, request);
        if wanted < LEAST / 2 {
            break;
        }
    }
    Ok((pilot.paths, wanted))
}

/// Estimates from these paths how many the target needs in all, and whether they reach it. Returns
/// their own number if paths given up alone exceed the tolerance: more would not help.
fn paths_needed(tally: &Tally, request: &Request) -> (u64, bool) {
    let tolerance = request.target.tolerance;
    let met = (tally.paths - tally.missed) as f64;
    if met == 0.0 && tally.paths >= MOST_MISSED {
        return (tally.paths, false);
    }
    if met < 2.0 {
        // A small target in a wide view: look on.
        return (16 * tally.paths, false);
    }
    let Precision { weight, reached, .. } =
        Precision::of(&Histogram::of(tally), request.bands, tolerance);
    let room = tolerance - weight.trapped;
    if room <= 0.0 {
        return (tally.paths, reached);
    }
    let ratio = T_95 * weight.standard_error / room;
    let needed = (met * math::pow(ratio, 2.0 / EVENNESS)).max(least_met(tolerance)) * MARGIN;
    let paths = needed * tally.paths as f64 / met;
    ((paths.min(1e18) as u64).div_ceil(LOT) * LOT, reached)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Bed, Domain};
    use crate::histogram::kept::Kept;
    use crate::scene::Sides;
    use crate::support::monitor::Unwatched;
    use crate::tracer::rules::Facet;
    use glam::DVec3;

    /// Nothing but a floor, or not even that.
    fn bare(floor: Option<(f64, u16)>) -> Tracer {
        let domain = Domain::new(DVec3::ZERO, DVec3::ONE, Sides::Mirror);
        let domain = Domain { floor, ..domain };
        let (meshes, placements) = (Vec::new(), Vec::new());
        Tracer::new(Bed {
            meshes,
            placements,
            repeated: 0,
            domain,
            to_sensor: DVec3::Z,
            materials: 1,
        })
    }

    fn rules() -> TracingRules {
        let rules = TracingRules::of_facets(Kept::PLAIN, vec![Facet::LAMBERTIAN]);
        TracingRules { greatest: vec![0.5], ..rules }
    }

    #[test]
    fn a_view_that_meets_nothing_ends() {
        let bands = [vec![0.5]];
        let (tracer, rules) = (bare(None), rules());
        let request = Request::new(&rules, 1, &bands, Target::of(0.01), &Unwatched);
        let traced = trace(&tracer, &request).expect("nothing interrupts it");
        assert_eq!(traced.tally.missed, traced.tally.paths);
        assert!((MOST_MISSED..32 * MOST_MISSED).contains(&traced.tally.paths));
    }

    #[test]
    fn the_pilot_is_short_where_the_least_number_of_paths_is_twice_enough() {
        // A bare floor: all paths weigh the same, and must number 3 / tolerance.
        let (tracer, rules) = (bare(Some((0.0, 0))), rules());
        let of = |tolerance: f64| {
            let bands = [vec![0.5]];
            let request = Request::new(&rules, 1, &bands, Target::of(tolerance), &Unwatched);
            pilot(&tracer, &request).expect("nothing interrupts it")
        };
        assert_eq!(of(0.01), (GLANCE, LOT));
        let (paths, wanted) = of(1e-4);
        assert_eq!(paths, PILOT);
        assert!((45_000..46_000).contains(&wanted), "{wanted}");
    }
}
