//! The settings of placed geometry: the tracing of its rays and the choice of its bands.

use super::{REPEATS, Reference, Run, Setting, Trade, timed};
use crate::geometry;
use crate::histogram::Histogram;
use crate::histogram::tally::Tally;
use crate::scene::{Grid, Scene, Sides};
use crate::support::error::Error;
use crate::support::linear::interpolate;
use crate::support::monitor::Monitor;
use crate::support::random::{Purpose, Sampler};
use crate::table::{Prepared, Target};
use crate::tracer::rules::TracingRules;
use crate::tracer::{Tracer, trace};

/// Paths of the reference: at least a hundred times as many as of any setting, with another seed.
const REFERENCE: u64 = 1 << 21;
const REFERENCE_SEED: u64 = 1 << 40;
/// Paths of the reference of a quick chart.
const QUICK_REFERENCE: u64 = 1 << 19;
/// Paths of the settings with other steps between bands.
const STEP_PATHS: u64 = 4096;
/// The tolerance of the rule that ends paths.
const TOLERANCE: f64 = 0.002;

/// A way to trace the scene: name, power of two of the fewest paths, change of the rules.
type Level = (&'static str, u32, fn(&mut TracingRules));

const LEVELS: [Level; 6] = [
    ("as shipped", 8, |_| ()),
    ("independent numbers", 8, |rules| rules.sampler = Sampler::Independent),
    ("up to 1 hit", 9, |rules| rules.most_hits = 1),
    ("up to 2 hits", 9, |rules| rules.most_hits = 2),
    ("up to 3 hits", 9, |rules| rules.most_hits = 3),
    ("up to 5 hits", 9, |rules| rules.most_hits = 5),
];

const SIDES: [(&str, Sides); 4] = [
    ("mirror sides", Sides::Mirror),
    ("periodic sides", Sides::Periodic),
    ("field of 1e9 particles", Sides::Field { particles: 1e9, seed: 0 }),
    ("open sides", Sides::Open),
];

/// Measures the settings of a placed scene.
pub fn patch(
    scene: &Scene,
    grid: &Grid,
    quick: bool,
    monitor: &dyn Monitor,
) -> Result<Trade, Error> {
    let say = |what: &str| monitor.say(&format!("measuring: {what}"));
    let tracer = trace::tracer(scene)?;
    let wavelengths_um = grid.wavelengths_um();
    let prepared = Prepared::new(scene.clone(), &wavelengths_um)?;
    let bands = prepared.reflectances.to_vec();
    let rules = TracingRules::new(&prepared);
    say("reference");
    let paths = if quick { QUICK_REFERENCE } else { REFERENCE };
    let exact_rules = rules.clone().ending_below(TOLERANCE / 500.0, &bands);
    let exact = Histogram::of(&tally(&tracer, &exact_rules, REFERENCE_SEED, paths)?);
    let means: Vec<_> = bands.iter().map(|band| exact.weight(band)).collect();
    let reference = Reference {
        made_of: format!("{paths} paths of another seed"),
        emissivity: means.iter().map(|mean| 1.0 - mean.mean).collect(),
        standard_error: means.iter().map(|mean| mean.standard_error + mean.trapped).collect(),
    };
    let mut settings = Vec::new();
    let mut measure = |level: &str, setting: String, run: &dyn Fn(u64) -> Emissivities| {
        let runs = (1..=REPEATS as u64).map(|seed| {
            let (emissivity, took) = timed(|| run(seed))?;
            Ok(Run { took, emissivity })
        });
        let runs = runs.collect::<Result<Vec<_>, Error>>()?;
        settings.push(Setting::of(level, setting, &runs, &reference));
        Ok::<(), Error>(())
    };
    let numbers = |fewest: u32| (fewest..=if quick { 12 } else { 14 }).map(|power| 1 << power);
    let shipped = rules.clone().ending_below(Target::of(TOLERANCE).least_weight, &bands);
    let traced = |tracer: &Tracer, rules: &TracingRules, seed, paths| {
        let histogram = Histogram::of(&tally(tracer, rules, seed, paths)?);
        Ok(bands.iter().map(|band| 1.0 - histogram.weight(band).mean).collect())
    };
    for (level, fewest, change) in LEVELS {
        say(level);
        let mut rules = shipped.clone();
        change(&mut rules);
        for paths in numbers(fewest) {
            let run = |seed| traced(&tracer, &rules, seed, paths);
            measure(level, format!("{paths} paths"), &run)?;
        }
    }
    for (level, sides) in SIDES {
        let too_large = matches!(sides, Sides::Field { particles, .. }
            if geometry::patches(tracer.bed(), particles).is_none());
        if sides == tracer.bed().domain.sides || too_large {
            continue;
        }
        say(level);
        let tracer = tracer.within(sides);
        for paths in numbers(9) {
            let run = |seed| traced(&tracer, &shipped, seed, paths);
            measure(level, format!("{paths} paths"), &run)?;
        }
    }
    let level = "areal mixture";
    say(level);
    let first_hits = TracingRules { most_hits: 1, ..rules.clone() };
    for paths in numbers(9) {
        let run = |seed| Ok(mixture(&tally(&tracer, &first_hits, seed, paths)?, &rules, &bands));
        measure(level, format!("{paths} paths"), &run)?;
    }
    let level = "spectral step";
    say(level);
    for stride in [2, 5, 10, 20, 50] {
        let step = format!("{:.3} um, {STEP_PATHS} paths", grid.step_um() * stride as f64);
        let run = |seed| {
            let histogram = Histogram::of(&tally(&tracer, &shipped, seed, STEP_PATHS)?);
            let emissivity = |band: usize| 1.0 - histogram.weight(&bands[band]).mean;
            Ok(interpolated(&wavelengths_um, stride, emissivity))
        };
        measure(level, step, &run)?;
    }
    Ok(Trade { scene: scene.name.clone(), reference, settings })
}

/// The emissivity in each band.
type Emissivities = Result<Vec<f64>, Error>;

fn tally(tracer: &Tracer, rules: &TracingRules, seed: u64, paths: u64) -> Result<Tally, Error> {
    Ok(tracer.trace(rules, seed, Purpose::Result, 0..paths, &|_| Ok(()))?)
}

/// The linear mixing model: the emissivities of the visible materials, by their share of the view.
fn mixture(tally: &Tally, rules: &TracingRules, bands: &[Vec<f64>]) -> Vec<f64> {
    let hits: u64 = tally.first_hits.iter().sum();
    let each = rules.kept.of_material();
    let of = |band: &Vec<f64>| {
        let shares = tally.first_hits.iter().zip(band.chunks(each));
        let reflected = shares
            .map(|(&of, rho)| of as f64 * rho.iter().sum::<f64>() / each as f64 / hits as f64);
        1.0 - reflected.sum::<f64>()
    };
    bands.iter().map(of).collect()
}

/// The emissivity in every n-th band and the last one, with straight lines between them.
fn interpolated(um: &[f64], stride: usize, emissivity: impl Fn(usize) -> f64) -> Vec<f64> {
    let last = um.len() - 1;
    let bands = (0..last).step_by(stride).chain([last]);
    let (at, values): (Vec<f64>, Vec<f64>) = bands.map(|band| (um[band], emissivity(band))).unzip();
    um.iter().map(|&um| interpolate(&at, &values, um)).collect()
}
