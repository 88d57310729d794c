//! Other values of a scene by the command line.

use insta::assert_snapshot;
use serde_json::{Value, json};

use crate::support::{Place, shipped, shipped_json};

#[test]
fn a_change_on_the_command_line_is_one_in_the_file() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let few = ["--paths", "4096", "--range", "8-12", "--step", "0.5"];
    let sets = ["--set", "view.zenith_deg=35", "--set", "temperature_k=310"];
    place.run(&[&["trace", &scene, "--out", "set.json"], &few[..], &sets].concat(), 0);
    let mut edited = shipped_json("settled_patch.json");
    edited["view"]["zenith_deg"] = 35.into();
    edited["temperature_k"] = 310.into();
    place.write("edited_scene.json", edited.to_string());
    place.run(&[&["trace", "edited_scene.json", "--out", "edited.json"], &few[..]].concat(), 0);
    place.run(&[&["trace", &scene, "--out", "plain.json"], &few[..]].concat(), 0);
    let table = |name: &str| {
        let mut table = place.json(name);
        let sum = table["scene_sha256"].take();
        (table, sum)
    };
    let (set, of_set) = table("set.json");
    assert!(set == table("edited.json").0, "the same as by an edit of the file");
    let (plain, of_plain) = table("plain.json");
    assert!(set["histogram"] != plain["histogram"] && of_set != of_plain);
}

#[test]
fn a_run_with_changes_is_recorded_replayed_and_told_from_others_in_the_cache() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let bands = ["--range", "8-12", "--step", "0.5", "--tolerance", "0.05"];
    let run = |out: &str, more: &[&str]| {
        let args = [&["pipeline", "--scene", &scene, "--out", out], &bands[..], more].concat();
        place.run(&args, 0);
        place.read(format!("{out}/signature.csv"))
    };
    let plain = run("plain", &[]);
    let tilted = run("tilted", &["--set", "view.zenith_deg=60", "--set", "sky_temperature_k=290"]);
    let inverted = run("inverted", &["--facets", "inverted"]);
    assert!(plain != tilted && plain != inverted && tilted != inverted);
    let options = |out: &str| place.json(format!("{out}/run.json"))["options"].take();
    let sets = json!(["view.zenith_deg=60", "sky_temperature_k=290"]);
    assert_eq!(options("tilted")["set"], sets);
    assert_eq!(options("inverted")["facets"], "inverted");
    assert_eq!(options("plain").get("set"), None);
    for out in ["tilted", "inverted"] {
        place.run(&["replay", &format!("{out}/run.json")], 0);
    }
    // The same as inverted spectra given to the plain table.
    let spectra = ["fine=inverted:quartz_fine", "coarse=inverted:quartz_coarse"];
    let spectra = spectra.iter().chain(&["floor=inverted:quartz_fine"]);
    let spectra = spectra.flat_map(|spectrum| ["--spectrum", *spectrum]);
    let given: Vec<&str> = ["signature", "plain/table.json", "--range", "8-12", "--step", "0.5"]
        .into_iter()
        .chain(spectra)
        .collect();
    let (csv, _) = place.run(&given, 0);
    let level = |csv: &str| -> Vec<f64> {
        let rows = csv.lines().skip(1).map(|row| row.split(',').nth(1).expect("emissivity"));
        rows.map(|field| field.parse().expect("a number")).collect()
    };
    for (by_run, by_table) in level(&inverted).into_iter().zip(level(&csv)) {
        // Paths are given up by other spectra.
        assert!((by_run - by_table).abs() < 2e-3, "{by_run} {by_table}");
    }
}

#[test]
fn what_a_scene_does_not_know_is_refused_with_the_change() {
    let place = Place::new();
    place.write("scene.json", shipped_json("settled_patch.json").to_string());
    let mut told = String::new();
    for (change, status) in [
        ("view.zenit_deg=35", 3),
        ("view.zenith_deg=95", 3),
        ("temperature_k=warm", 3),
        ("materials.dust.temperature_k=310", 3),
        ("temperature_k.max=3", 3),
        ("temperature_k=null", 3),
        ("sky_temperature_k", 2),
        ("view..zenith_deg=3", 2),
    ] {
        told +=
            &place.refused(&["trace", "scene.json", "--out", "t.json", "--set", change], status);
    }
    let args = ["pipeline", "--scene", "scene.json", "--out", "r", "--set", "name=7"];
    told += &place.refused(&args, 3);
    assert_snapshot!(told);
    assert!(!place.path("t.json").exists() && !place.path("r/run.json").exists());
    // Every command that reads a scene takes changes.
    let picture = ["picture", "patch", "scene.json", "--out", "p.png", "--width-px", "64"];
    place.run(&[&picture[..], &["--set", "view.zenith_deg=30"]].concat(), 0);
    let folder = ["export", "scene.json", "out", "--to", "dirsig", "--set", "seed=3"];
    place.run(&folder, 0);
    let image = ["image", "scene.json", "--out", "image", "--range", "9-9", "--noise", "0.2"];
    place.run(&[&image[..], &["--set", "sensor.pixels=[4,2]"]].concat(), 0);
    let made: Value = place.json("scene.json");
    assert_eq!(made["seed"], 1, "the file stays as it is");
}
