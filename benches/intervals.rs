//! Counts how often the 95 % interval of a trace holds the truth: independent runs of the shipped
//! patch against a far longer reference.
//!
//! `make intervals` prints the table of docs/measurements/intervals.md.

use std::path::Path;

use soilsig::histogram::{Histogram, Mean};
use soilsig::scene::{Grid, Scene};
use soilsig::support::monitor::Unwatched;
use soilsig::table::{Part, Prepared, Target};
use soilsig::tracer::rules::TracingRules;
use soilsig::tracer::trace;
use soilsig::tracer::until::{self, Request};

/// Independent runs.
const RUNS: u64 = 1600;
/// Paths of the reference: its error is a tenth of that of the runs.
const REFERENCE: u64 = 1 << 22;
/// The wavelengths that are compared, um: two troughs, the peak between them, a slope, two
/// beyond 10 um.
const BANDS_UM: [f64; 6] = [8.2, 8.5, 8.63, 8.97, 11.0, 12.5];

fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/settled_patch.json");
    let scene = Scene::read(&path).expect("a shipped scene");
    let tracer = trace::tracer(&scene).expect("its meshes");
    let prepared =
        |um: &[f64]| Prepared::new(scene.clone(), um).expect("shipped spectra hold the bands");
    let of_result = prepared(&Grid::PAPER.wavelengths_um());
    let rules = TracingRules::new(&of_result);
    let (bands, looked_at) = (of_result.reflectances, prepared(&BANDS_UM).reflectances);
    let run = |seed: u64, target: Target| -> Vec<Mean> {
        let rules = rules.clone().ending_below(target.least_weight, &bands);
        let request = Request::new(&rules, seed, &bands, target, &Unwatched);
        let traced = until::trace(&tracer, &request);
        let histogram = Histogram::of(&traced.expect("traced").tally);
        looked_at.iter().map(|reflectance| histogram.weight(reflectance)).collect()
    };
    let exactly = |paths, tolerance| {
        let part = Part { first: 0, end: paths, of: paths };
        Target { exactly: Some(part), ..Target::of(tolerance) }
    };
    let reference = run(1 << 40, exactly(REFERENCE, 1e-4));

    println!(
        "| what ends a run | wavelength, um | intervals that hold the reference, % | 95 % | \
         standard error stated : found |"
    );
    println!("|---|---|---|---|---|");
    for (row, (what, target)) in (0..).zip([
        ("a tolerance of 0.01", Target::of(0.01)),
        ("a tolerance of 0.004", Target::of(0.004)),
        ("a tolerance of 0.001", Target::of(0.001)),
        ("4096 paths", exactly(4096, 0.005)),
    ]) {
        let mut held = [0; BANDS_UM.len()];
        // Sums of squares: of the stated standard error, of the true error.
        let mut squares = [[0.0; 2]; BANDS_UM.len()];
        for number in 1..=RUNS {
            let found = run(row * RUNS + number, target);
            for (band, (truth, found)) in reference.iter().zip(&found).enumerate() {
                let off = found.mean - truth.mean;
                held[band] += u64::from(off.abs() <= found.half_width());
                squares[band][0] += found.standard_error.powi(2);
                squares[band][1] += off.powi(2);
            }
        }
        for ((um, held), [stated, found]) in BANDS_UM.iter().zip(held).zip(squares) {
            let (share, n) = (held as f64 / RUNS as f64, RUNS as f64);
            let error = 196.0 * (share * (1.0 - share) / n).sqrt();
            let ratio = (stated / found).sqrt();
            println!("| {what} | {um} | {:.1} | +- {error:.1} | {ratio:.2} |", 100.0 * share);
        }
    }
}
