//! Dust as the pipeline reports it, with real Blenders.
//!
//! How fines sit is tested by tests/python/test_dust.py, inside Blender.

use std::path::Path;
use std::process::Output;

use insta::assert_snapshot;
use serde_json::{Value, json};

use crate::support::{Place, a_blender, real_blenders, without_numbers, without_places};

/// Standard error of a share of the silhouette by the drop's lines, and that of one that a recipe
/// asks for.
const BY_LINES: f64 = 0.014;
const BY_LINES_ASKED: f64 = 0.007;

fn pipeline(place: &Place, blender: &Path, fines: &[Value; 2], dust: &Value) -> Output {
    let scene = json!({
        "soilsig_scene": 1, "name": "dusty", "seed": 5, "temperature_k": 300,
        "view": {"zenith_deg": 0},
        "materials": [{"name": "fine", "spectrum": {"constant": 0.95}},
                      {"name": "coarse", "spectrum": {"constant": 0.8}},
                      {"name": "floor", "spectrum": {"constant": 0.9}}],
        "geometry": {"packing": {
            "seed": 5,
            "grains": [{"name": "little", "shape": "angular", "diameter_um": 400, "material": "coarse",
                        "count": 8, "fines": fines[0]},
                       {"name": "big", "shape": "worn", "diameter_um": 600, "material": "coarse",
                        "count": 4, "fines": fines[1]}],
            "fines": [{"name": "fine_50", "shape": "flake", "diameter_um": 50, "material": "fine", "share": 1}],
            "dust": dust, "variants": 1, "tray_um": [1600, 1600], "crop_um": 300,
            "floor_material": "floor"}}
    });
    place.write("dusty.json", scene.to_string());
    let args = ["pipeline", "--scene", "dusty.json", "--out", "r", "--range", "8-9", "--json"];
    let mut command = place.soilsig_with(blender, &args);
    command
        .args(["--packings", "1", "--tolerance", "0.02", "--no-cache"])
        .output()
        .expect("it runs")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn two_measures_of_cover_agree_and_a_cover_asked_for_is_reached() {
    let place = Place::new();
    for blender in real_blenders() {
        let fines = [json!({"silhouette": 0.55}), json!(150)];
        let output = pipeline(&place, &blender, &fines, &json!({"layers": 2, "overlap": 0.2}));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let record: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let drop = place.json("r/drop.json");
        let reached = &record["reached"]["dusty"];
        for prototype in drop["prototypes"].as_array().expect("prototypes") {
            let by_lines = number(&prototype["cover"]["silhouette"]);
            let by_rays = &reached["coverage"][prototype["name"].as_str().expect("a name")];
            let share = number(&by_rays["silhouette"]["fine"]);
            let asked = prototype["class"] == "little";
            let error = number(&by_rays["silhouette_standard_error"]).hypot(if asked {
                BY_LINES_ASKED
            } else {
                BY_LINES
            });
            assert!((share - by_lines).abs() < 4.0 * error, "{share} {by_lines} {prototype}");
            let rest = number(&by_rays["silhouette"]["coarse"]);
            assert!((share + rest - 1.0).abs() < 1e-9, "{by_rays}");
            if asked {
                assert!((0.55..0.56).contains(&by_lines), "{prototype}");
            } else {
                assert_eq!(prototype["fines"]["fine_50"], 150, "{prototype}");
            }
            assert!(prototype["layers"].as_array().expect("layers").len() <= 2, "{prototype}");
        }
        // What the sensor sees, by prototypes, is what the paths hit first.
        for material in ["fine", "coarse"] {
            let covers = reached["coverage"].as_object().expect("covers").values();
            let seen: f64 = covers.map(|cover| number(&cover["view"][material])).sum();
            let first = number(&reached["seen_first"][material]);
            assert!((seen - first).abs() < 0.03, "{material}: {seen} {first}");
        }
    }
}

#[test]
fn dust_that_does_not_fit_is_refused_with_what_would() {
    let place = Place::new();
    let Some(blender) = a_blender() else { return };
    let flat = json!({"layers": 1, "overlap": 0});
    let mut told = String::new();
    for fines in [json!({"silhouette": 0.97}), json!(2000)] {
        let output = pipeline(&place, &blender, &[json!(20), fines.clone()], &flat);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success());
        told += &format!("{fines}\n{}\n", without_numbers(&without_places(&errors)));
    }
    assert_snapshot!(told);
}
