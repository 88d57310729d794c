//! What a bed is warned of before it is traced, and what is no reason to warn.

use serde_json::{Value, json};
use soilsig::table::Table;
use soilsig::table::warning::Warning;

use crate::support::{PIT_CORNERS, Place, emissivity, pit_lines, scene_of, shipped, trace_file};

/// Cubes of the unit 1 um, placed by the upper rows of these matrices, in a wide open scene.
fn cubes(places: &[[f64; 12]]) -> Table {
    let place = Place::new();
    let vertices: String = PIT_CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces = "f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 7 8\n";
    place.write("m.obj", format!("{vertices}usemtl rock\n{faces}"));
    let mut scene: Value =
        serde_json::from_str(&scene_of(r#"{"name": "m", "file": "m.obj"}"#)).expect("JSON");
    let instances = places.iter().map(|m| json!({"prototype": "m", "transform": m}));
    scene["geometry"]["placed"]["instances"] = instances.collect();
    scene["materials"][0]["spectrum"] = json!({"constant": 0.9});
    place.write("scene.json", scene.to_string());
    trace_file(&place.path("scene.json"), 1, 0.05)
}

fn overlap(table: &Table) -> Option<f64> {
    table.warnings.iter().find_map(|warning| match warning {
        Warning::Overlap { share } => Some(*share),
        _ => None,
    })
}

/// A cube of this size, um, turned about the vertical, with its least corner here.
fn cube(size: f64, [x, y, z]: [f64; 3], turn_deg: f64) -> [f64; 12] {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    [size * cos, -size * sin, 0.0, x, size * sin, size * cos, 0.0, y, 0.0, 0.0, size, z]
}

#[test]
fn solids_that_only_touch_do_not_pass_through_each_other() {
    for turn_deg in [0.0_f64, 13.7] {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        // Side by side, half a side apart, and one upon the other.
        for [along, aside, up] in
            [[400.0, 0.0, 0.0], [400.0, 200.0, 0.0], [0.0, 0.0, 400.0], [400.0, 0.0, 400.0]]
        {
            let next = [along * cos - aside * sin, along * sin + aside * cos, up];
            for [first, second] in [[[0.0; 3], next], [next, [0.0; 3]]] {
                let table = cubes(&[cube(400.0, first, turn_deg), cube(400.0, second, turn_deg)]);
                assert_eq!(overlap(&table), None, "{turn_deg} {next:?}");
            }
        }
    }
    // A flake thinner than what counts as touching, on a cube.
    let flake = [400.0, 0.0, 0.0, 0.0, 0.0, 400.0, 0.0, 0.0, 0.0, 0.0, 0.1, 400.0];
    assert_eq!(overlap(&cubes(&[cube(400.0, [0.0; 3], 0.0), flake])), None);
}

#[test]
fn solids_that_reach_into_each_other_are_told() {
    for (reach, turn_deg) in [(0.02, 0.0), (0.02, 20.0), (0.4, 0.0), (0.9, 45.0)] {
        let (sin, cos) = f64::to_radians(turn_deg).sin_cos();
        let along = 400.0 * (1.0 - reach);
        let next = [along * cos, along * sin, 0.0];
        let large = cube(400.0, [0.0; 3], turn_deg);
        let small = cube(200.0, [next[0] - 100.0 * sin, next[1] + 100.0 * cos, 100.0], turn_deg);
        let share = overlap(&cubes(&[large, small])).expect("they do");
        // A face of the small cube, parts of four, and a quarter of one of the large cube; or all
        // six. There are twelve faces.
        let truth = if reach < 0.5 { (1.25 + 4.0 * 2.0 * reach) / 12.0 } else { 0.5 };
        assert!((share - truth).abs() < 0.03, "{reach}: {share} {truth}");
    }
    // A flake within a cube.
    let flake = [200.0, 0.0, 0.0, 100.0, 0.0, 200.0, 0.0, 100.0, 0.0, 0.0, 0.1, 200.0];
    assert!(overlap(&cubes(&[cube(400.0, [0.0; 3], 0.0), flake])).is_some());
}

#[test]
fn doubled_solids_count_once_and_are_told() {
    let repeated = |table: &Table| {
        table.warnings.iter().find_map(|warning| match warning {
            Warning::Repeated { placements } => Some(*placements),
            _ => None,
        })
    };
    let (one, other) = (cube(400.0, [0.0; 3], 0.0), cube(300.0, [500.0, 0.0, 0.0], 10.0));
    let alone = cubes(&[one, other]);
    let doubled = cubes(&[one, other, one, one, other]);
    assert_eq!((repeated(&alone), repeated(&doubled)), (None, Some(3)));
    assert_eq!(emissivity(&alone), emissivity(&doubled));
    // As many as a broken export may hold: this takes no longer than one.
    assert_eq!(repeated(&cubes(&vec![one; 20_000])), Some(19_999));
}

#[test]
fn a_pit_drawn_from_both_sides_gives_up_no_path() {
    let place = Place::new();
    let back = "f 4 3 2 1\nf 2 6 5 1\nf 3 7 6 2\nf 4 8 7 3\nf 1 5 8 4\n";
    place.write("m.obj", format!("{}\n{back}", pit_lines().join("\n")));
    let prototype = r#"{"name": "m", "file": "m.obj", "unit_um": 1000}"#;
    place.write("scene.json", scene_of(prototype));
    let table = trace_file(&place.path("scene.json"), 1, 0.004);
    assert!(table.inside.is_empty(), "{:?}", table.inside);
    let (mean, standard_error) = emissivity(&table);
    assert!((mean - 0.8454).abs() < 0.0023 + 3.0 * standard_error, "{mean} {standard_error}");
}

/// A warning means that something can be done; those of shipped scenes would teach to overlook it.
#[test]
fn the_shipped_patch_warns_of_nothing() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let args = ["pipeline", "--scene", &scene, "--out", "out", "--tolerance", "0.02"];
    let (out, said) = place.run(&args, 0);
    assert!(!format!("{out}{said}").contains("warning"), "{out}{said}");
}
