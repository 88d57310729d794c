//! What a trace says of its own error is what traces of other seeds differ by. How often intervals hold the truth:
//! `make intervals`.

use std::path::Path;

use soilsig::histogram::{Histogram, Mean};
use soilsig::scene::Scene;
use soilsig::support::random::{Purpose, Sampler};
use soilsig::table::Prepared;
use soilsig::tracer::rules::TracingRules;
use soilsig::tracer::trace;

const SEEDS: u64 = 80;
const PATHS: u64 = 8192;

/// The variance of the means of all seeds, and the mean of the variances that each states.
fn variances(means: &[Mean]) -> (f64, f64) {
    let n = means.len() as f64;
    let mean = means.iter().map(|of| of.mean).sum::<f64>() / n;
    let squares: f64 = means.iter().map(|of| (of.mean - mean).powi(2)).sum();
    (squares / (n - 1.0), means.iter().map(|of| of.standard_error.powi(2)).sum::<f64>() / n)
}

/// Of 80 seeds the variance is known to a sixth. Independent paths are told as surely as evenly spread ones, of which the means
/// differ by less.
#[test]
fn what_two_nets_differ_by_is_what_seeds_differ_by() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/settled_patch.json");
    let scene = Scene::read(&path).expect("a shipped scene");
    let tracer = trace::tracer(&scene).expect("its meshes");
    let prepared = Prepared::new(scene, &[9.0, 11.0]).expect("shipped spectra");
    let of = |sampler: Sampler| {
        let bands = &prepared.reflectances;
        let rules =
            TracingRules { sampler, ..TracingRules::new(&prepared) }.ending_below(0.001, bands);
        let run = |seed: u64| {
            let traced = tracer.trace(&rules, seed, Purpose::Result, 0..PATHS, &|_| Ok(()));
            Histogram::of(&traced.expect("traced"))
        };
        let seeds: Vec<Histogram> = (1..=SEEDS).map(run).collect();
        let found = |rho: &Vec<f64>| {
            let means: Vec<Mean> = seeds.iter().map(|of| of.weight(rho)).collect();
            let (found, stated) = variances(&means);
            let ratio = stated / found;
            assert!((0.6..1.8).contains(&ratio), "{sampler:?}: {stated} stated, {found} found");
            found
        };
        bands.iter().map(found).collect::<Vec<f64>>()
    };
    let (even, independent) = (of(Sampler::Even), of(Sampler::Independent));
    assert!(even.iter().zip(&independent).all(|(even, alone)| 1.5 * even < *alone));
}
