//! Scenes made in place, and their traces.

use std::fs;
use std::path::{Path, PathBuf};

use soilsig::scene::Scene;
use soilsig::signature::Grid;
use soilsig::stop::Target;
use soilsig::table::Table;
use soilsig::trace;
use tempfile::TempDir;

/// A scene in a folder of its own.
pub struct Case {
    folder: TempDir,
}

impl Case {
    /// An .obj file and a scene about it; `placed` is the JSON of `geometry.placed`, `emissivities` those
    /// of the materials `m0`, `m1`, ...
    pub fn new(obj: &str, placed: &str, emissivities: &[f64]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("mesh.obj"), obj).expect("written");
        let materials: Vec<String> = emissivities
            .iter()
            .enumerate()
            .map(|(i, e)| format!(r#"{{"name": "m{i}", "spectrum": {{"constant": {e}}}}}"#))
            .collect();
        let scene = format!(
            r#"{{"soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300,
                 "view": {{"zenith_deg": 0}}, "materials": [{}],
                 "geometry": {{"placed": {placed}}}}}"#,
            materials.join(",")
        );
        fs::write(folder.path().join("scene.json"), scene).expect("written");
        Self { folder }
    }

    /// The scene file.
    pub fn path(&self) -> PathBuf {
        self.folder.path().join("scene.json")
    }

    /// The scene's table, traced until the half-width is `tolerance`.
    pub fn trace(&self, tolerance: f64) -> Table {
        trace_file(&self.path(), 1, tolerance)
    }
}

/// Traces a scene file with a seed.
pub fn trace_file(path: &Path, seed: u64, tolerance: f64) -> Table {
    let mut scene = Scene::read(path).expect("the scene is sound");
    scene.seed = seed;
    let tracer = trace::tracer(&scene, path).expect("its meshes are sound");
    let target = Target { tolerance, max_paths: 1 << 26 };
    let bands = Grid::new(9.0, 9.0, 0.01).expect("a grid").wavelengths_um();
    trace::trace(&tracer, &scene, path, &bands, target, &|_, _| ()).expect("traced")
}
