//! Drops that go wrong: settings that cause it, the second try, and what the user is told.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::{Value, json};

use crate::support::real_blenders;

/// What a run said and wrote.
struct Outcome {
    status: i32,
    said: String,
    report: Option<Value>,
}

/// Drops a few grains with few fines.
fn drop(blender: &Path, settings: &Value, grains: u32, tray_um: f64) -> Outcome {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scene: Value =
        serde_json::from_str(include_str!("../../scenes/small.json")).expect("JSON");
    let packing = &mut scene["geometry"]["packing"];
    let mut class = packing["grains"][0].clone();
    class["count"] = json!(grains);
    class["fines"] = json!(20);
    packing["grains"] = json!([class]);
    packing["tray_um"] = json!([tray_um, tray_um]);
    packing["crop_um"] = json!(0);
    packing["drop"] = settings.clone();
    fs::write(folder.path().join("scene.json"), scene.to_string()).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
    command.args(["pipeline", "--scene", "scene.json", "--out", "r", "--tolerance", "0.05"]);
    command.args(["--range", "9-11", "--step", "1"]).current_dir(folder.path());
    command.env("SOILSIG_CACHE", folder.path().join("cache")).env("SOILSIG_BLENDER", blender);
    let output = command.output().expect("it runs");
    let text = [output.stdout, output.stderr].concat();
    let report = fs::read_to_string(folder.path().join("r/drop.json")).ok();
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

/// Settings that spoil the first try; the second, with safer ones, makes a bed of it.
fn assert_cured(settings: &Value, grains: u32, tray_um: f64, failure: &str, words: &str) {
    for blender in real_blenders() {
        let outcome = drop(&blender, settings, grains, tray_um);
        assert_eq!(tries(&outcome), [failure, "settled"], "{settings} {}", outcome.said);
        assert!(outcome.said.contains(words), "{settings}: {}", outcome.said);
        assert!(outcome.said.contains("dropped again with safer settings"), "{}", outcome.said);
        let report = outcome.report.expect("a report");
        let attempts = &report["attempts"];
        assert!(attempts[0]["reason"].as_str().expect("a reason").contains(words));
        let substeps = |i: usize| attempts[i]["settings"]["substeps"].as_u64().expect("a count");
        assert!(substeps(1) >= 12.max(2 * substeps(0)), "{attempts}");
        assert_eq!(report["settle"]["settled"], true);
        assert_eq!(report["checks"]["escaped"], 0);
        let overlaps = &report["checks"]["overlaps"];
        let depth_um = |key: &str| overlaps[key].as_f64().expect("a depth");
        for key in ["max_depth_um", "floor_depth_um", "wall_depth_um"] {
            assert!(depth_um(key) <= depth_um("depth_limit_um"), "{overlaps}");
        }
    }
}

#[test]
fn a_drop_that_is_cut_short_is_given_twice_the_frames() {
    assert_cured(&json!({"max_frames": 38}), 4, 1600.0, "not_settled", "after 38 frames");
}

#[test]
fn a_drop_that_does_not_settle_twice_is_refused_with_both_reasons() {
    for blender in real_blenders() {
        let outcome = drop(&blender, &json!({"max_frames": 5}), 4, 1600.0);
        assert_eq!(outcome.status, 16, "{}", outcome.said);
        assert!(outcome.report.is_none());
        for words in
            ["refused", "after 5 frames", "after 10 frames", "max_frames 10", "substeps 12"]
        {
            assert!(outcome.said.contains(words), "{words}: {}", outcome.said);
        }
    }
}

/// A hundred times the gravity in one step a frame: grains are through the floor before it is seen.
#[test]
fn grains_that_fall_through_the_floor_have_escaped() {
    let settings = json!({"gravity": 9810, "substeps": 1});
    assert_cured(&settings, 4, 1600.0, "escaped", "left the tray");
}

/// Grains a thousandth of Bullet's scale, with a margin many times their size.
#[test]
fn a_bad_scale_flings_grains_off() {
    assert_cured(&json!({"scale": 0.0065}), 4, 1600.0, "escaped", "4 of 4 grains left the tray");
}

/// A margin of half a grain: the hulls stay so far apart, and the bed hangs in the air, at rest.
#[test]
fn a_bed_that_floats_is_found() {
    assert_cured(&json!({"margin": 4}), 4, 1600.0, "floating", "off the floor");
}

#[test]
fn grains_that_sink_into_the_floor_are_found() {
    let settings = json!({"gravity": 250, "substeps": 1, "margin": 0});
    assert_cured(&settings, 4, 4000.0, "sunk", "into the floor");
}

#[test]
fn grains_that_sink_into_each_other_are_found() {
    let settings = json!({"gravity": 250, "substeps": 1, "margin": 0});
    assert_cured(&settings, 24, 1300.0, "overlap", "contacts overlap");
}

/// The three models of collision: each settles, and fines stand closer to fines than hulls let them.
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
