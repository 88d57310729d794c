//! Drops that go wrong: settings that cause it, the second try, and what the user is told.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use insta::assert_snapshot;
use serde_json::{Value, json};

use crate::support::{Place, real_blenders, shipped_json, without_numbers, without_places};

/// What a run said and wrote.
struct Outcome {
    status: i32,
    said: String,
    report: Option<Value>,
}

/// Drops a few grains with few fines.
fn drop(blender: &Path, settings: &Value, grains: u32, tray_um: f64) -> Outcome {
    let place = Place::new();
    let mut scene = shipped_json("small.json");
    let packing = &mut scene["geometry"]["packing"];
    let mut class = packing["grains"][0].clone();
    class["count"] = json!(grains);
    class["fines"] = json!(20);
    packing["grains"] = json!([class]);
    packing["tray_um"] = json!([tray_um, tray_um]);
    packing["crop_um"] = json!(0);
    packing["drop"] = settings.clone();
    place.write("scene.json", scene.to_string());
    let args = ["pipeline", "--scene", "scene.json", "--out", "r", "--tolerance", "0.05"];
    let mut command = place.soilsig_with(blender, &args);
    command.args(["--packings", "1", "--range", "9-11", "--step", "1"]);
    let output = command.output().expect("it runs");
    let text = [output.stdout, output.stderr].concat();
    let report = fs::read_to_string(place.path("r/drop.json")).ok();
    Outcome {
        status: output.status.code().expect("an exit status"),
        said: String::from_utf8_lossy(&text).into_owned(),
        report: report.map(|text| serde_json::from_str(&text).expect("JSON")),
    }
}

/// The tries of a run that came to a result, each as its outcome.
fn tries(outcome: &Outcome) -> Vec<String> {
    assert_eq!(outcome.status, 0, "{}", outcome.said);
    let report = outcome.report.as_ref().expect("a report");
    let attempts = report["attempts"].as_array().expect("tries");
    let name = |attempt: &Value| attempt["outcome"].as_str().expect("an outcome").to_owned();
    attempts.iter().map(name).collect()
}

/// Settings that spoil the first try; the second, with safer ones, makes a bed of it. Returns what
/// is said of that in each Blender.
fn cured(settings: &Value, grains: u32, tray_um: f64, failure: &str) -> BTreeSet<String> {
    let said_of = |blender: PathBuf| {
        let outcome = drop(&blender, settings, grains, tray_um);
        assert_eq!(tries(&outcome), [failure, "settled"], "{settings} {}", outcome.said);
        let report = outcome.report.expect("a report");
        let attempts = &report["attempts"];
        let substeps = |i: usize| attempts[i]["settings"]["substeps"].as_u64().expect("a count");
        assert!(substeps(1) >= 12.max(2 * substeps(0)), "{attempts}");
        assert_eq!(report["settle"]["settled"], true);
        assert_eq!(report["checks"]["escaped"], 0);
        let overlaps = &report["checks"]["overlaps"];
        let depth_um = |key: &str| overlaps[key].as_f64().expect("a depth");
        for key in ["max_depth_um", "floor_depth_um", "wall_depth_um"] {
            assert!(depth_um(key) <= depth_um("depth_limit_um"), "{overlaps}");
        }
        let reason = attempts[0]["reason"].as_str().expect("a reason");
        let mut lines = outcome.said.lines();
        let line = lines.find(|line| line.contains(reason));
        without_numbers(line.unwrap_or_else(|| panic!("{reason:?} is not in {}", outcome.said)))
    };
    real_blenders().into_iter().map(said_of).collect()
}

/// Every Blender says the same, and that.
macro_rules! assert_said {
    ($said:expr) => {
        for said in $said {
            assert_snapshot!(said);
        }
    };
}

#[test]
fn a_drop_that_is_cut_short_is_given_twice_the_frames() {
    assert_said!(cured(&json!({"max_frames": 38}), 4, 1600.0, "not_settled"));
}

#[test]
fn a_drop_that_does_not_settle_twice_is_refused_with_both_reasons() {
    let refused = |blender: PathBuf| {
        let outcome = drop(&blender, &json!({"max_frames": 5}), 4, 1600.0);
        assert_eq!(outcome.status, 16, "{}", outcome.said);
        assert!(outcome.report.is_none());
        let (_, error) = outcome.said.split_once("error:").expect("an error");
        let reasons = without_places(error);
        for frames in ["5 frames", "10 frames"] {
            assert!(reasons.contains(frames), "{reasons}");
        }
        without_numbers(&reasons)
    };
    assert_said!(real_blenders().into_iter().map(refused).collect::<BTreeSet<_>>());
}

/// A hundred times the gravity in one step a frame: grains are through the floor before it is seen.
#[test]
fn grains_that_fall_through_the_floor_have_escaped() {
    let settings = json!({"gravity": 9810, "substeps": 1});
    assert_said!(cured(&settings, 4, 1600.0, "escaped"));
}

/// Grains a thousandth of Bullet's scale, with a margin many times their size.
#[test]
fn a_bad_scale_flings_grains_off() {
    assert_said!(cured(&json!({"scale": 0.0065}), 4, 1600.0, "escaped"));
}

/// A margin of half a grain: the hulls stay so far apart, and the bed hangs in the air, at rest.
#[test]
fn a_bed_that_floats_is_found() {
    assert_said!(cured(&json!({"margin": 4}), 4, 1600.0, "floating"));
}

#[test]
fn grains_that_sink_into_the_floor_are_found() {
    let settings = json!({"gravity": 250, "substeps": 1, "margin": 0});
    assert_said!(cured(&settings, 4, 4000.0, "sunk"));
}

#[test]
fn grains_that_sink_into_each_other_are_found() {
    let settings = json!({"gravity": 250, "substeps": 1, "margin": 0});
    assert_said!(cured(&settings, 24, 1300.0, "overlap"));
}

/// The three models of collision: each settles, and fines stand closer to fines than hulls let
/// them.
#[test]
fn every_model_of_collision_settles() {
    for blender in real_blenders() {
        let mut gaps = Vec::new();
        for collision in ["hull", "hull_then_fines", "mesh"] {
            let outcome = drop(&blender, &json!({"collision": collision}), 6, 1300.0);
            assert_eq!(tries(&outcome), ["settled"], "{collision}: {}", outcome.said);
            let report = outcome.report.expect("a report");
            let overlaps = &report["checks"]["overlaps"];
            assert!(overlaps["contacts"].as_u64().expect("a count") > 0, "{overlaps}");
            gaps.push(overlaps["median_gap_um"].as_f64().expect("a gap"));
        }
        assert!(gaps[1] < gaps[0] && gaps[2] < gaps[0], "{gaps:?}");
    }
}
