//! What scene files must give to the last digit, or by symmetry.

use std::fs;

use soilsig::scene::Sky;
use soilsig::table::Table;
use soilsig::{radiometry, signature};
use tempfile::TempDir;

use crate::support::{emissivity, trace_file};

/// A scene in a folder of its own.
struct Case {
    folder: TempDir,
}

impl Case {
    /// An .obj file and a scene about it; `placed` is the JSON of `geometry.placed`, `emissivities`
    /// those of the materials `m0`, `m1`, ...
    fn new(obj: &str, placed: &str, emissivities: &[f64]) -> Self {
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

    /// The scene's table, traced until the half-width is `tolerance`.
    fn trace(&self, tolerance: f64) -> Table {
        trace_file(&self.folder.path().join("scene.json"), 1, tolerance)
    }
}

const ALONE: &str = r#"{"prototypes": [{"name": "mesh", "file": "mesh.obj"}]}"#;

#[test]
fn a_flat_plate_has_the_emissivity_of_its_facets() {
    let plate = "v 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nusemtl m0\nf 1 2 3 4\n";
    let table = Case::new(plate, ALONE, &[0.37]).trace(0.005);
    let (value, error) = emissivity(&table);
    assert!((value - 0.37).abs() < 1e-12 && error < 1e-9, "{value} +- {error}");
    assert_eq!((table.missed, table.hits), (0, table.paths));
}

#[test]
fn an_isothermal_box_under_a_sky_of_its_own_temperature_looks_black() {
    // An open box: four walls and a floor, of two materials.
    let open_box = "v 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nv 0 0 400\nv 500 0 400\n\
        v 500 500 400\nv 0 500 400\nusemtl m0\nf 1 2 3 4\nusemtl m1\nf 1 2 6 5\nf 2 3 7 6\n\
        f 3 4 8 7\nf 4 1 5 8\n";
    let mut table = Case::new(open_box, ALONE, &[0.6, 0.2]).trace(0.005);
    table.sky_temperature_k = Some(Sky::Isotropic(300.0));
    for um in [7.5, 10.0, 14.0] {
        let one = std::slice::from_ref(&table);
        let band = signature::evaluate(one, &[um]).expect("constant spectra")[0];
        let black = radiometry::planck(um, 300.0);
        assert!((band.l_target.mean / black - 1.0).abs() < 1e-12);
        let emissivity = band.emissivity.mean;
        assert!(emissivity > 0.65 && emissivity < 1.0, "it is a cavity: {emissivity}");
    }
}

#[test]
fn two_materials_are_told_apart_by_what_the_sensor_sees_first() {
    let halves = "v 0 0 0\nv 250 0 0\nv 500 0 0\nv 500 500 0\nv 250 500 0\nv 0 500 0\n\
        usemtl m0\nf 1 2 5 6\nusemtl m1\nf 2 3 4 5\n";
    let table = Case::new(halves, ALONE, &[0.9, 0.6]).trace(0.001);
    let (value, error) = emissivity(&table);
    // As many paths of each group see either half: then there is no spread.
    assert!((value - 0.75).abs() <= 3.0 * error, "{value} +- {error}");
    let share = table.materials[0].first_hits as f64 / table.paths as f64;
    assert!((share - 0.5).abs() < 0.01, "{share}");
}

/// The mirror sides of a domain are the infinite bed of mirror images: a scene and its explicit
/// mirror image beside it give the same answer.
#[test]
fn mirror_sides_equal_explicit_mirror_images() {
    let step = "v 0 0 0\nv 300 0 200\nv 300 400 0\nv 0 400 0\nv 150 100 350\nv 250 300 300\n\
        v 100 250 250\nusemtl m0\nf 1 2 3 4\nusemtl m1\nf 5 6 7\n";
    let placed = |instances: &str, x: f64| {
        format!(
            r#"{{"prototypes": [{{"name": "mesh", "file": "mesh.obj"}}], "instances": [{instances}],
                "domain": {{"min_um": [0, 0], "max_um": [{x}, 400], "sides": "mirror",
                            "floor": {{"z_um": -50, "material": "m0"}}}}}}"#
        )
    };
    let as_it_is = r#"{"prototype": "mesh", "transform": [1,0,0,0, 0,1,0,0, 0,0,1,0]}"#;
    let image = r#"{"prototype": "mesh", "transform": [-1,0,0,600, 0,1,0,0, 0,0,1,0]}"#;
    let one = Case::new(step, &placed(as_it_is, 300.0), &[0.5, 0.2]).trace(0.001);
    let two =
        Case::new(step, &placed(&format!("{as_it_is},{image}"), 600.0), &[0.5, 0.2]).trace(0.001);
    let ((a, ea), (b, eb)) = (emissivity(&one), emissivity(&two));
    assert!((a - b).abs() < 3.0 * ea.hypot(eb), "{a} +- {ea} and {b} +- {eb}");
    let open = placed(as_it_is, 300.0).replace("mirror", "open");
    let (c, ec) = emissivity(&Case::new(step, &open, &[0.5, 0.2]).trace(0.001));
    assert!(a - c > 10.0 * ea.hypot(ec), "open sides lose what mirrors keep: {a} and {c}");
}
