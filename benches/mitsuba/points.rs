//! Mitsuba 3 as a level of `soilsig chart`: error against time by number of paths, in the columns
//! of `chart.csv`.
//!
//! A film has as many pixels as there are paths: so Mitsuba spreads its paths most evenly. The
//! reference is our result with open sides, so that the error is Mitsuba's noise alone.

use std::fs;

use soilsig::histogram::{Histogram, Mean};
use soilsig::studies::chart::{self, Reference, Run, Setting, Took};
use soilsig::support::random::Purpose;
use soilsig::table::Target;

use super::{ALL_BY_SOME, BANDS_UM, Done, Film, Ours, theirs};

/// Pixels of a film's side: 2^10 to 2^16 paths.
const SIDES: [u64; 4] = [32, 64, 128, 256];
const REFERENCE: u64 = 1 << 21;
/// The tolerance of the rule that ends its paths.
const TOLERANCE: f64 = 0.0002;
const REFERENCE_SEED: u64 = 1 << 40;

/// Measures each number of paths and writes them to a file.
pub fn write(python: &str, ours: &Ours, file: &str) -> Done<()> {
    let bands = ours.bands(&BANDS_UM)?;
    let rules = ours.rules().ending_below(Target::of(TOLERANCE).least_weight, &bands);
    eprintln!("measuring: reference");
    let paths = 0..REFERENCE;
    let tally = ours.tracer.trace(&rules, REFERENCE_SEED, Purpose::Result, paths, &|_| Ok(()))?;
    let histogram = Histogram::of(&tally);
    let exact: Vec<Mean> = bands.iter().map(|band| histogram.weight(band)).collect();
    let reference = Reference {
        made_of: format!("{REFERENCE} paths with open sides"),
        emissivity: exact.iter().map(|mean| 1.0 - mean.mean).collect(),
        standard_error: exact.iter().map(|mean| mean.standard_error + mean.trapped).collect(),
    };
    let mut settings = Vec::new();
    for (number, pixels) in (0..).zip(SIDES) {
        let paths = pixels * pixels;
        eprintln!("measuring: {paths} paths");
        let repeats = chart::REPEATS as u64;
        let seeds = number * repeats..(number + 1) * repeats;
        let renders = theirs(python, ours, &bands, &Film { pixels, samples: 1 }, seeds, None)?;
        let times = renders.cpu_s.iter().zip(&renders.wall_s);
        let run = |((cpu_s, wall_s), means): ((&f64, &f64), &Vec<f64>)| Run {
            took: Took { wall_s: wall_s * ALL_BY_SOME, cpu_s: cpu_s * ALL_BY_SOME },
            emissivity: means.iter().map(|mean| 1.0 - mean).collect(),
        };
        let runs: Vec<Run> = times.zip(&renders.means).map(run).collect();
        let level = format!(
            "Mitsuba {}, open sides, 651 bands counted from {}",
            renders.version,
            BANDS_UM.len()
        );
        settings.push(Setting::of(&level, format!("{paths} paths"), &runs, &reference));
    }
    Ok(fs::write(file, chart::csv(&settings, &reference))?)
}
