//! Scene files traced in place.

use std::path::Path;

use soilsig::scene::{Grid, Scene};
use soilsig::signature;
use soilsig::support::monitor::Unwatched;
use soilsig::table::{Prepared, Table, Target};
use soilsig::tracer::trace::{self, Request};

/// Traces a scene file with a seed.
pub fn trace_file(path: &Path, seed: u64, tolerance: f64) -> Table {
    let mut scene = Scene::read(path).expect("the scene is sound");
    scene.seed = seed;
    let tracer = trace::tracer(&scene).expect("its meshes are sound");
    let band = Grid::new(9.0, 9.0, 0.01).expect("a grid");
    trace::trace(
        &tracer,
        &Prepared::new(scene.clone(), &band.wavelengths_um()).expect("spectra"),
        Request::new(&band, Target::of(tolerance)),
        &Unwatched,
    )
    .expect("traced")
}

/// The emissivity at 9 um, with its standard error.
pub fn emissivity(table: &Table) -> (f64, f64) {
    let bands = signature::evaluate(std::slice::from_ref(table), &[9.0]).expect("it holds 9 um");
    (bands[0].emissivity.mean, bands[0].emissivity.standard_error)
}
