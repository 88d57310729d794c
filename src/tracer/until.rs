//! When the rays are enough: a pilot tells how many paths the tolerance needs, the result is
//! traced with paths of its own.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::histogram::Histogram;
use crate::histogram::tally::Tally;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::random::{LOT, Purpose};
use crate::support::statistics::T_95;
use crate::table::stop::least_met;
use crate::table::{Ended, Sureness, Target};
use crate::tracer::rules::TracingRules;
use crate::tracer::{Tracer, WAVE};

/// Paths of the pilot.
const PILOT: u64 = 1024;
/// Paths of it that do where they show that half of [`LEAST`] would be enough.
const GLANCE: u64 = 256;
/// Least paths of a result.
const LEAST: u64 = 8192;
/// The power of their number with which the variance of a mean over evenly spread paths falls (docs/tracer.md).
const EVENNESS: f64 = 1.2;
/// What the pilot says is raised by so much, so that one round is mostly enough: the pilot's spread and the result's own are each
/// known to a fifth, and where rounds end as soon as the spread is small by chance, intervals hold the truth too seldom.
const MARGIN: f64 = 1.5;
/// Time after which what is traced so far is kept.
const KEEP_EVERY: Duration = Duration::from_secs(10);

/// Paths traced until the target was reached or could not be.
#[derive(Debug, Clone)]
pub struct Traced {
    /// The counts.
    pub tally: Tally,
    /// How many paths the whole trace has.
    pub wanted: u64,
    /// What ended it.
    pub ended_by: Ended,
}

/// Work that is done while a trace is under way.
pub struct Watch<'a> {
    /// Told how many paths are done and how many are wanted; may stop the trace.
    pub monitor: &'a dyn Monitor,
    /// What the monitor is told that these are: paths, or those of a bed.
    pub what: &'a str,
    /// Given what is traced so far, every few seconds and when the trace is interrupted.
    pub keep: &'a (dyn Fn(&Traced) -> Result<(), Error> + Sync),
}

/// Traces until every band, given as one reflectance for each symbol, has its half-width.
///
/// `kept` is what an earlier trace of the same kind kept when it was interrupted.
pub fn trace(
    tracer: &Tracer,
    rules: &TracingRules,
    seed: u64,
    bands: &[Vec<f64>],
    target: Target,
    kept: Option<Traced>,
    watch: &Watch,
) -> Result<Traced, Error> {
    let started = Instant::now();
    let first = target.exactly.map_or(0, |part| part.first);
    let end = |wanted: u64| target.exactly.map_or(wanted, |part| part.end);
    let mut traced = match (kept, target.exactly) {
        (Some(kept), _) => kept,
        (None, Some(part)) => fresh(tracer, rules, part.of),
        (None, None) => {
            let (_, wanted) = pilot(tracer, rules, seed, bands, target, watch.monitor)?;
            fresh(tracer, rules, wanted.max(LEAST).min(target.max_paths))
        }
    };
    let mut last_kept = Instant::now();
    loop {
        let wanted = end(traced.wanted) - first;
        while traced.tally.paths < wanted {
            let from = first + traced.tally.paths;
            let to = (from + WAVE).min(first + wanted);
            let done = AtomicU64::new(traced.tally.paths);
            let wave = tracer.trace(rules, seed, Purpose::Result, from..to, &|paths| {
                let sum = done.fetch_add(paths, Ordering::Relaxed) + paths;
                watch.monitor.at(sum, wanted, watch.what);
                watch.monitor.check()
            });
            match wave {
                Ok(wave) => traced.tally.add(&wave),
                Err(error) => {
                    (watch.keep)(&traced)?;
                    return Err(error.into());
                }
            }
            if target.max_seconds.is_some_and(|most| started.elapsed().as_secs_f64() >= most) {
                traced.ended_by = Ended::MaxSeconds;
                traced.wanted = traced.tally.paths;
                return Ok(traced);
            }
            if last_kept.elapsed() >= KEEP_EVERY {
                (watch.keep)(&traced)?;
                last_kept = Instant::now();
            }
        }
        if target.exactly.is_some() {
            traced.ended_by = Ended::Paths;
            return Ok(traced);
        }
        let (next, reached) = more(&traced.tally, bands, target);
        let next = next.min(target.max_paths);
        if reached || next <= traced.tally.paths {
            traced.ended_by = if reached {
                Ended::Tolerance
            } else if traced.tally.paths >= target.max_paths {
                Ended::MaxPaths
            } else {
                Ended::Trapped
            };
            return Ok(traced);
        }
        traced.wanted = next;
    }
}

/// How many paths tell how many the target needs, and what they tell. They are thrown away.
fn pilot(
    tracer: &Tracer,
    rules: &TracingRules,
    seed: u64,
    bands: &[Vec<f64>],
    target: Target,
    monitor: &dyn Monitor,
) -> Result<(u64, u64), Error> {
    let mut pilot = tracer.nothing(rules);
    let mut wanted = 0;
    for end in [GLANCE, PILOT] {
        let numbers = pilot.paths..end.min(target.max_paths);
        pilot.add(&tracer.trace(rules, seed, Purpose::Pilot, numbers, &|_| monitor.check())?);
        (wanted, _) = more(&pilot, bands, target);
        if wanted < LEAST / 2 {
            break;
        }
    }
    Ok((pilot.paths, wanted))
}

fn fresh(tracer: &Tracer, rules: &TracingRules, wanted: u64) -> Traced {
    Traced { tally: tracer.nothing(rules), wanted, ended_by: Ended::Interrupted }
}

/// How many paths the target needs in all, by what these paths show, and whether they reach it. No more than there are where more would not help: when what trapped paths leave open is
/// wider than the tolerance.
fn more(tally: &Tally, bands: &[Vec<f64>], target: Target) -> (u64, bool) {
    let met = (tally.paths - tally.missed) as f64;
    if met < 2.0 {
        // A small target in a wide view: look on.
        return (16 * tally.paths, false);
    }
    let Sureness { weight, reached, .. } =
        Sureness::of(&Histogram::of(tally), bands, target.tolerance);
    let room = target.tolerance - weight.trapped;
    if room <= 0.0 {
        return (tally.paths, reached);
    }
    let ratio = T_95 * weight.standard_error / room;
    let needed = (met * ratio.powf(2.0 / EVENNESS)).max(least_met(target.tolerance)) * MARGIN;
    let paths = needed * tally.paths as f64 / met;
    ((paths.min(1e18) as u64).div_ceil(LOT) * LOT, reached)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Bed, Domain};
    use crate::histogram::tally::Kept;
    use crate::scene::Sides;
    use crate::support::monitor::Unwatched;
    use crate::support::random::Sampler;
    use crate::tracer::rules::{Facet, MOST_HITS};
    use glam::DVec3;

    #[test]
    fn the_pilot_is_short_where_the_least_number_of_paths_is_twice_enough() {
        // A bare floor: all paths weigh the same, and must number 3 / tolerance.
        let domain = Domain {
            min_um: DVec3::ZERO,
            max_um: DVec3::ONE,
            sides: Sides::Mirror,
            patches: [1, 1],
            floor: Some((0.0, 0)),
        };
        let (meshes, placements) = (Vec::new(), Vec::new());
        let bed = Bed { meshes, placements, domain, to_sensor: DVec3::Z, materials: 1 };
        let tracer = Tracer::new(bed);
        let rules = TracingRules {
            kept: Kept::PLAIN,
            facets: vec![Facet::LAMBERTIAN],
            sampler: Sampler::Even,
            most_hits: MOST_HITS,
            greatest: vec![0.5],
            least_weight: 0.0,
        };
        let of = |tolerance: f64| {
            let target = Target::of(tolerance);
            pilot(&tracer, &rules, 1, &[vec![0.5]], target, &Unwatched)
                .expect("nothing interrupts it")
        };
        assert_eq!(of(0.01), (GLANCE, LOT));
        let (paths, wanted) = of(1e-4);
        assert_eq!(paths, PILOT);
        assert!((45_000..46_000).contains(&wanted), "{wanted}");
    }
}
