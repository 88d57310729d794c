//! The settings of placed geometry: how its rays are traced and its bands chosen.

use super::{REPEATS, Reference, Run, Setting, Trade, timed};
use crate::geometry;
use crate::histogram::Histogram;
use crate::scene::{Grid, Scene, Sides};
use crate::support::error::Error;
use crate::support::linear::interpolate;
use crate::support::monitor::Monitor;
use crate::support::random::{Purpose, Sampler};
use crate::table::Prepared;
use crate::table::Target;
use crate::tracer::rules::TracingRules;
use crate::tracer::{Tracer, trace};

/// Paths of the reference: a hundred and more times as many as of any setting, from a seed of its own.
const REFERENCE: u64 = 1 << 21;
const REFERENCE_SEED: u64 = 1 << 40;
/// The same where the chart is wanted at once.
const QUICK_REFERENCE: u64 = 1 << 19;
/// Paths on which steps between bands are tried.
const STEP_PATHS: u64 = 4096;
/// The tolerance whose rule gives paths up.
const TOLERANCE: f64 = 0.002;

struct Patch<'a> {
    tracer: &'a Tracer,
    rules: TracingRules,
    bands: Vec<Vec<f64>>,
    wavelengths_um: Vec<f64>,
}

/// A level and the paths that are spent on it.
struct Level<'a> {
    name: &'static str,
    sides: Option<Sides>,
    rules: &'a dyn Fn(&mut TracingRules),
    paths: Vec<u64>,
}

/// Measures the settings of a placed scene.
pub fn patch(
    scene: &Scene,
    grid: &Grid,
    quick: bool,
    monitor: &dyn Monitor,
) -> Result<Trade, Error> {
    let told = |what: &str| monitor.say(&format!("measuring: {what}"));
    let tracer = trace::tracer(scene)?;
    let wavelengths_um = grid.wavelengths_um();
    let prepared = Prepared::new(scene.clone(), &wavelengths_um)?;
    let rules = TracingRules::new(&prepared);
    let bands = prepared.reflectances.to_vec();
    let patch = Patch { tracer: &tracer, rules, bands, wavelengths_um };
    told("reference");
    let paths = if quick { QUICK_REFERENCE } else { REFERENCE };
    let rules = patch.rules.clone().ending_below(TOLERANCE / 500.0, &patch.bands);
    let exact = histogram(&tracer, &rules, REFERENCE_SEED, paths)?;
    let means: Vec<_> = patch.bands.iter().map(|band| exact.weight(band)).collect();
    let reference = Reference {
        made_of: format!("{paths} paths of another seed"),
        emissivity: means.iter().map(|mean| 1.0 - mean.mean).collect(),
        standard_error: means.iter().map(|mean| mean.standard_error + mean.trapped).collect(),
    };
    let sweep = |from: u32, to: u32| (from..=to).map(|power| 1 << power).collect::<Vec<u64>>();
    let most = if quick { 12 } else { 14 };
    let hits = |most_hits| move |rules: &mut TracingRules| rules.most_hits = most_hits;
    let (one, two, three, five) = (hits(1), hits(2), hits(3), hits(5));
    let whole: &dyn Fn(&mut TracingRules) = &|_| ();
    let independent: &dyn Fn(&mut TracingRules) = &|rules| rules.sampler = Sampler::Independent;
    let level = |name, rules, paths| Level { name, sides: None, rules, paths };
    let beside = |name, sides| Level { sides: Some(sides), ..level(name, whole, sweep(9, most)) };
    let mut levels = vec![
        level("as shipped", whole, sweep(8, most)),
        level("independent numbers", independent, sweep(8, most)),
        level("up to 1 hit", &one, sweep(9, most)),
        level("up to 2 hits", &two, sweep(9, most)),
        level("up to 3 hits", &three, sweep(9, most)),
        level("up to 5 hits", &five, sweep(9, most)),
    ];
    let own = tracer.bed().domain.sides;
    for (name, sides) in [
        ("mirror sides", Sides::Mirror),
        ("periodic sides", Sides::Periodic),
        ("field of 1e9 particles", Sides::Field { particles: 1e9, seed: 0 }),
        ("open sides", Sides::Open),
    ] {
        let too_large = matches!(sides, Sides::Field { particles, .. }
            if geometry::patches(tracer.bed(), particles).is_none());
        if sides != own && !too_large {
            levels.push(beside(name, sides));
        }
    }
    let mut settings = Vec::new();
    for level in &levels {
        told(level.name);
        let within = level.sides.map(|sides| tracer.within(sides));
        let tracer = within.as_ref().unwrap_or(&tracer);
        let mut rules =
            patch.rules.clone().ending_below(Target::of(TOLERANCE).least_weight, &patch.bands);
        (level.rules)(&mut rules);
        for &paths in &level.paths {
            let runs = repeated(|seed| patch.traced(tracer, &rules, seed, paths))?;
            settings.push(Setting::of(level.name, format!("{paths} paths"), &runs, &reference));
        }
    }
    told("areal mixture");
    for paths in sweep(9, most) {
        let runs = repeated(|seed| patch.mixed(seed, paths))?;
        settings.push(Setting::of("areal mixture", format!("{paths} paths"), &runs, &reference));
    }
    told("spectral step");
    let rules = patch.rules.clone().ending_below(Target::of(TOLERANCE).least_weight, &patch.bands);
    for stride in [2, 5, 10, 20, 50] {
        let runs = repeated(|seed| {
            let histogram = histogram(&tracer, &rules, seed, STEP_PATHS)?;
            Ok(patch.interpolated(&histogram, stride))
        })?;
        let step = format!("{:.3} um, {STEP_PATHS} paths", grid.step_um() * stride as f64);
        settings.push(Setting::of("spectral step", step, &runs, &reference));
    }
    Ok(Trade { scene: scene.name.clone(), reference, settings })
}

fn repeated(run: impl Fn(u64) -> Result<Vec<f64>, Error>) -> Result<Vec<Run>, Error> {
    (1..=REPEATS as u64)
        .map(|seed| {
            let (emissivity, took) = timed(|| run(seed))?;
            Ok(Run { took, emissivity })
        })
        .collect()
}

fn histogram(
    tracer: &Tracer,
    rules: &TracingRules,
    seed: u64,
    paths: u64,
) -> Result<Histogram, Error> {
    let tally = tracer.trace(rules, seed, Purpose::Result, 0..paths, &|_| Ok(()))?;
    Ok(Histogram::of(&tally))
}

impl Patch<'_> {
    fn traced(
        &self,
        tracer: &Tracer,
        rules: &TracingRules,
        seed: u64,
        paths: u64,
    ) -> Result<Vec<f64>, Error> {
        let histogram = histogram(tracer, rules, seed, paths)?;
        Ok(self.bands.iter().map(|band| 1.0 - histogram.weight(band).mean).collect())
    }

    /// The emissivities of what is seen, by its share of the view: the linear mixing model.
    fn mixed(&self, seed: u64, paths: u64) -> Result<Vec<f64>, Error> {
        let rules = TracingRules { most_hits: 1, ..self.rules.clone() };
        let tally = self.tracer.trace(&rules, seed, Purpose::Result, 0..paths, &|_| Ok(()))?;
        let met: u64 = tally.first_hits.iter().sum();
        let cosines = usize::from(rules.kept.cosines);
        let of = |band: &Vec<f64>| {
            let shares = tally.first_hits.iter().zip(band.chunks(cosines));
            let reflected = shares.map(|(&hits, rho)| {
                hits as f64 * rho.iter().sum::<f64>() / cosines as f64 / met as f64
            });
            1.0 - reflected.sum::<f64>()
        };
        Ok(self.bands.iter().map(of).collect())
    }

    /// Evaluates only every n-th band, with straight lines between them.
    fn interpolated(&self, histogram: &Histogram, stride: usize) -> Vec<f64> {
        let last = self.bands.len() - 1;
        let (um, emissivity): (Vec<f64>, Vec<f64>) = (0..last)
            .step_by(stride)
            .chain([last])
            .map(|band| (self.wavelengths_um[band], 1.0 - histogram.weight(&self.bands[band]).mean))
            .unzip();
        self.wavelengths_um.iter().map(|&at| interpolate(&um, &emissivity, at)).collect()
    }
}
