//! Several packings of one recipe, with real Blenders.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};
use soilsig::beds::HULLS;
use soilsig::support::random::seed_of;
use soilsig::support::statistics::quantile_95;

use crate::blender_control::fake::Fake;
use crate::support::{
    OfBlenders, Place, a_blender, real_blenders, shipped, shipped_json, with_script,
};

/// What a Blender made, and what the program said of it. The cache keeps its beds.
struct Made {
    place: Place,
    said: String,
}

/// Two packings of the small recipe in `two`, dropped one after the other without a word of a
/// tolerance.
fn two(blender: &Path) -> Arc<Made> {
    static TWO: OfBlenders<Made> = OfBlenders::new();
    TWO.of(blender, |blender| {
        let place = Place::kept();
        let scene = shipped("small.json");
        let args = ["pipeline", "--scene", &scene, "--packings", "2", "--out", "two"];
        let mut command = place.soilsig_with(blender, &args);
        command.args(["--threads", "1", "--range", "8-12", "--step", "0.5"]);
        let output = command.output().expect("it runs");
        let said = String::from_utf8_lossy(&[output.stderr, output.stdout].concat()).into_owned();
        assert!(output.status.success(), "{said}");
        Made { place, said }
    })
}

#[test]
fn the_interval_holds_the_spread_between_packings() {
    let Some(blender) = a_blender() else { return };
    let made = two(&blender);
    let place = &made.place;
    let run = |packings: &str| {
        let args =
            ["pipeline", "--scene", &shipped("small.json"), "--packings", packings, "--out", "r"];
        place.run_with(&blender, &[&args[..], &["--tolerance", "0.3", "--json"]].concat())
    };
    let record: Value = serde_json::from_str(&run("3")).expect("JSON");
    let reached = &record["reached"]["settled_patch"];
    assert_eq!(reached["packings"], 3);
    let out = place.path("r");
    let csv = fs::read_to_string(out.join("signature.csv")).expect("written");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    // A path is given up below a fifth of the tolerance, here of the packing's own, and counts with
    // half of that.
    let most_open = 0.3 * 3_f64.sqrt() / 2.0 / 5.0 / 2.0;
    for row in reader.records() {
        let row = row.expect("a row");
        let [error, half_width, rays, spread] =
            [2, 3, 5, 6].map(|i| row[i].parse::<f64>().expect("a number"));
        assert!((error - (spread / 3_f64.sqrt()).max(rays)).abs() < 2e-7, "{row:?}");
        let open = half_width - quantile_95(3) * error;
        assert!((-1e-5..most_open).contains(&open), "{row:?}");
        assert!(spread > 0.0 && rays > 0.0, "{row:?}");
    }
    // The tables alone give the same curve.
    let tables: Vec<String> = (1..=3).map(|i| format!("r/packings/{i}/table.json")).collect();
    let mut args = vec!["signature"];
    args.extend(tables.iter().map(String::as_str));
    assert_eq!(place.run_with(&blender, &args), csv);

    // One packing more: the three that are there are not dropped again.
    let times = |i: usize| place.json(format!("r/packings/{i}/drop.json"))["timings_s"].clone();
    let before: Vec<Value> = (1..=3).map(times).collect();
    run("4");
    assert_eq!((1..=3).map(times).collect::<Vec<_>>(), before);
    assert!(out.join("packings/4/scene.json").is_file());
    // Fewer: what is left over of the larger run goes.
    run("2");
    assert!(!out.join("packings/4/scene.json").exists());
}

/// A Blender makes several beds one after the other: none may know of those before it.
#[test]
fn a_packing_is_the_same_whatever_was_dropped_before_it() {
    for blender in real_blenders() {
        let made = two(&blender);
        let (place, seed) = (&made.place, seed_of(1, 1).to_string());
        let scene = shipped("small.json");
        let args = ["pipeline", "--scene", &scene, "--no-cache", "--seed", &seed, "--out", "alone"];
        let more = ["--packings", "1", "--tolerance", "0.3", "--range", "9-9"];
        place.run_with(&blender, &[&args[..], &more].concat());
        let (several, alone) = (place.path("two/packings/2"), place.path("alone"));
        let read = |folder: &Path| fs::read(folder.join("prototypes.obj")).expect("written");
        assert_eq!(read(&several), read(&alone));
        let geometry = |folder: &Path| place.json(folder.join("scene.json"))["geometry"].clone();
        assert_eq!(geometry(&several), geometry(&alone));
    }
}

/// Where the hulls rested, before fines touched: the very bed that hulls alone give.
#[test]
fn a_bed_that_touches_comes_with_its_bed_of_hulls() {
    let place = Place::new();
    let mut scene = shipped_json("small.json");
    let packing = &mut scene["geometry"]["packing"];
    packing["drop"] = json!({
        "substeps": 6, "iterations": 30, "max_frames": 400,
        "scale": 6.5, "gravity": 98.1, "margin": 0.04,
    });
    packing["dust"] = json!({"layers": 8, "overlap": 0});
    packing["grains"][0]["fines"] = json!(60);
    packing["grains"].as_array_mut().expect("classes").truncate(1);
    for (number, blender) in real_blenders().into_iter().enumerate() {
        let drop = |collision: &str| {
            let mut scene = scene.clone();
            scene["geometry"]["packing"]["drop"]["collision"] = collision.into();
            let recipe = format!("{collision}{number}.json");
            place.write(&recipe, scene.to_string());
            let out = place.path(format!("{collision}{number}"));
            let mut command = with_script(&blender, "blender_scripts/drop.py");
            command.arg("--").arg("--scene").arg(place.path(&recipe));
            let output = command.arg("--out").arg(&out).output().expect("it runs");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
            out.join(format!("{collision}{number}"))
        };
        let (hulls, touching) = (drop("hull"), drop("hull_then_fines"));
        let read = |folder: &Path, name: &str| fs::read(folder.join(name)).expect("written");
        assert_eq!(read(&hulls, "prototypes.obj"), read(&touching, "prototypes.obj"));
        assert_eq!(read(&hulls, "scene.json"), read(&touching, HULLS));
        assert_ne!(read(&hulls, "scene.json"), read(&touching, "scene.json"));
        assert!(!hulls.join(HULLS).exists());
    }
}

/// Nobody asked the beds to agree.
#[test]
fn a_number_of_packings_without_a_tolerance_draws_no_warning_of_one() {
    let Some(blender) = a_blender() else { return };
    let Made { place, said } = &*two(&blender);
    assert!(!said.contains("warning"), "{said}");
    let record = place.json("two/run.json");
    let reached = record["reached"].as_object().expect("scenes").values().next().expect("one");
    assert_eq!(
        (&reached["tolerance_of"], &record["options"]["tolerance"]),
        (&"rays".into(), &Value::Null)
    );
    assert!(reached["half_width"].as_f64() > reached["tolerance"].as_f64(), "{reached}");
}

#[test]
fn packings_replay_to_the_byte() {
    let Some(blender) = a_blender() else { return };
    let said = two(&blender).place.run_with(&blender, &["replay", "two/run.json"]);
    for file in ["packings/2/scene.json", "packings/2/table.json", "signature.csv"] {
        assert!(said.contains(file), "{said}");
    }
}

/// The small recipe with so many fines on each grain, and so many grains of each class.
fn dusted(place: &Place, fines: u32, grains: u32) -> String {
    let mut scene = shipped_json("small.json");
    for class in scene["geometry"]["packing"]["grains"].as_array_mut().expect("classes") {
        class["fines"] = fines.into();
        class["count"] = grains.into();
    }
    place.write("dusted.json", scene.to_string());
    "dusted.json".into()
}

/// The record of a run of a scene within a tolerance, into a folder.
fn planned(place: &Place, blender: &Path, scene: &str, tolerance: &str, out: &str) -> Value {
    let args = ["pipeline", "--scene", scene, "--out", out, "--json"];
    let run = place.run_with(blender, &[&args[..], &["--tolerance", tolerance]].concat());
    serde_json::from_str(&run).expect("JSON")
}

/// The widest total is one number, in the record and in the curve.
fn total(place: &Place, out: &str, reached: &Value) -> f64 {
    let csv = fs::read_to_string(place.path(out).join("signature.csv")).expect("written");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let headings = reader.headers().expect("headings").clone();
    let at = headings.iter().position(|h| h == "emissivity_total_half_width_95").expect("there");
    let totals = reader.records().map(|row| row.expect("a row")[at].parse().expect("a number"));
    let widest = totals.fold(0.0, f64::max);
    let said = reached["half_width"].as_f64().expect("a number");
    assert!((widest - said).abs() < 1e-7, "{widest} and {said}");
    assert_eq!(reached["budget"]["total"], reached["half_width"]);
    said
}

/// A planned run into `refused` whose first drop is refused, and its record. The cache keeps the
/// beds after it.
fn with_a_bed_refused(blender: &Path) -> Arc<(Place, Value)> {
    static REFUSED: OfBlenders<(Place, Value)> = OfBlenders::new();
    REFUSED.of(blender, |blender| {
        let place = Place::kept();
        let name = blender.file_name().expect("a program").to_string_lossy();
        let refused = r#"{"event":"error","kind":"sunk","message":"a grain sank","hint":null}"#;
        let body = format!(
            "case \"$*\" in *drop.py*) mkdir \"$here/once\" 2>/dev/null && \
             {{ echo '@soilsig {refused}'; exit 13; }};; esac\nexec '{}' \"$@\"",
            blender.display()
        );
        let fake = Fake::named(&name, &body);
        let record = planned(&place, &fake.path, &dusted(&place, 0, 6), "0.015", "refused");
        (place, record)
    })
}

#[test]
fn as_many_beds_are_dropped_as_the_tolerance_takes() {
    let Some(blender) = a_blender() else { return };
    let (place, _) = &*with_a_bed_refused(&blender);
    let record = planned(place, &blender, "dusted.json", "0.015", "r");
    let reached = &record["reached"]["settled_patch"];
    let plan = &reached["plan"];
    assert_eq!(record["options"]["packings"], "auto");
    assert!(total(place, "r", reached) <= 0.015, "{reached}");
    assert_eq!(
        (&reached["tolerance_of"], &reached["tolerance_reached"]),
        (&"total".into(), &true.into())
    );
    assert_eq!((&plan["by"], &plan["total"]), (&plan["next"], &reached["half_width"]));
    // Nothing keeps fines apart where there are none.
    assert_eq!((&plan["by"]["pairs"], &reached["budget"]["apart"]), (&0.into(), &Value::Null));
    let beds = fs::read_dir(place.path("r/packings")).expect("written").count();
    assert_eq!(plan["by"]["drops"], beds);
    assert_eq!(reached["packings"], beds);
    assert!(beds > 4, "{plan}");
    // A loose tolerance takes one bed.
    let one = planned(place, &blender, "dusted.json", "0.3", "r");
    let reached = &one["reached"]["settled_patch"];
    assert!(total(place, "r", reached) <= 0.3, "{reached}");
    assert_eq!(reached["packings"], 1);
    assert!(!place.path("r/packings").exists() && place.path("r/table.json").exists());
}

#[test]
fn the_next_bed_stands_for_one_that_blender_refuses() {
    let Some(blender) = a_blender() else { return };
    let (place, record) = &*with_a_bed_refused(&blender);
    let reached = &record["reached"]["settled_patch"];
    let refused = reached["refused"][0].as_str().expect("a text");
    assert!(refused.contains("stands for bed") && refused.contains("a grain sank"), "{refused}");
    assert!(total(place, "refused", reached) <= 0.015, "{reached}");
    let beds = fs::read_dir(place.path("refused/packings")).expect("written").count();
    assert_eq!(reached["packings"], beds);
    // No log of the refused bed is left.
    let files = fs::read_dir(place.path("refused")).expect("written");
    let logs =
        files.filter(|f| f.as_ref().is_ok_and(|f| f.path().extension() == Some("log".as_ref())));
    assert_eq!(logs.count(), 0);
}

/// Hulls carry the spread, pairs of the same drop what touching fines change.
#[test]
fn some_beds_are_dropped_until_fines_touch_where_hulls_keep_them_apart() {
    let place = Place::new();
    let Some(blender) = a_blender() else { return };
    let record = planned(&place, &blender, &dusted(&place, 10, 6), "0.03", "r");
    let reached = &record["reached"]["settled_patch"];
    assert!(total(&place, "r", reached) <= 0.03, "{reached}");
    assert!(reached["budget"]["apart"].is_null());
    let beds = &reached["plan"]["by"];
    let [drops, pairs] = ["drops", "pairs"].map(|of| beds[of].as_u64().expect("a number"));
    assert!(pairs >= 2 && drops > pairs, "{beds}");
    assert_eq!(reached["packings"], drops);
    let bed = place.json("r/packings/2-touching/drop.json");
    assert_eq!(bed["attempts"][0]["settings"]["collision"], "hull_then_fines");
    let scene = |folder: &str| {
        place.json(format!("r/packings/{folder}/scene.json"))["geometry"]["placed"].clone()
    };
    let (hulls, touching) = (scene("2"), scene("2-touching"));
    assert_eq!((&hulls["origin"], &touching["origin"]), (&"drawn_apart".into(), &"drawn".into()));
    assert_eq!(hulls["drop"], touching["drop"]);
    assert_ne!(hulls["instances"], touching["instances"]);
    // One bed told that: it is not part of the result, and the record says so.
    let stages = record["stages"].as_array().expect("a list");
    let names: Vec<&str> = stages.iter().filter_map(|stage| stage["name"].as_str()).collect();
    assert!(names.starts_with(&["pilot drop", "pilot trace"]), "{names:?}");

    // The tables alone give the same curve; some of both kinds do not go together.
    let table = |folder: String| format!("r/packings/{folder}/table.json");
    let of_bed = |bed: u64| {
        let has_both = place.path(format!("r/packings/{bed}-touching")).exists();
        [Some(bed.to_string()), has_both.then(|| format!("{bed}-touching"))]
    };
    let tables: Vec<String> = (1..=drops).flat_map(of_bed).flatten().map(table).collect();
    assert_eq!(tables.len() as u64, drops + pairs);
    let args: Vec<&str> =
        ["signature"].into_iter().chain(tables.iter().map(String::as_str)).collect();
    let csv = fs::read_to_string(place.path("r/signature.csv")).expect("written");
    assert_eq!(place.run_with(&blender, &args), csv);
    let (_, said) = place.run(&["signature", &tables[2], &tables[0]], 3);
    assert!(said.contains("leave out one of both kinds"), "{said}");

    let said = place.run_with(&blender, &["replay", "r/run.json"]);
    for file in ["packings/2-touching/table.json", "packings/2/table.json", "signature.csv"] {
        assert!(said.contains(file), "{said}");
    }
}
