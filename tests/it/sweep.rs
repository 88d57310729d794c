//! Sweeps: points, parts, resumption, failures, and results that others can make again.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use insta::assert_snapshot;
use serde_json::{Value, json};

use crate::support::{Place, Tool, a_blender, killed_after, left_over, shipped_json, tool};

/// A patch that is traced in a moment, over the view and the temperature.
fn study() -> Value {
    json!({
        "soilsig_study": 1,
        "name": "view",
        "source": {"scene": "scenes/patch.json"},
        "axes": [
            {"name": "zenith_deg", "key": "view.zenith_deg",
             "range": {"from": 0, "to": 40, "number": 3}},
            {"name": "fine", "cases": [
                {"name": "quartz", "set": ["temperature_k=300"]},
                {"name": "grey", "set": ["materials.fine.spectrum={\"constant\": 0.9}"]}
            ]}
        ],
        "seeds": [1, 2],
        "tolerance": 0.1,
        "bands": {"from_um": 8, "to_um": 12, "step_um": 0.5}
    })
}

fn place(study: &Value) -> Place {
    let place = Place::new();
    fs::create_dir(place.path("scenes")).expect("made");
    let patch = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/settled_patch.obj");
    fs::copy(patch, place.path("scenes/settled_patch.obj")).expect("copied");
    let mut scene = shipped_json("settled_patch.json");
    for prototype in scene["geometry"]["placed"]["prototypes"].as_array_mut().expect("a list") {
        prototype["file"] = "settled_patch.obj".into();
    }
    place.write("scenes/patch.json", scene.to_string());
    place.write("study.json", study.to_string());
    place
}

fn rows(place: &Place, file: &str) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(place.path(file)).expect("a CSV file");
    let headings = reader.headers().expect("headings").clone();
    let rows = reader.records().map(|row| row.expect("a row"));
    std::iter::once(headings)
        .chain(rows)
        .map(|row| row.iter().map(str::to_owned).collect())
        .collect()
}

/// The bytes of every result that is the same each time.
fn results(place: &Place, out: &str) -> Vec<(String, Vec<u8>)> {
    let record = place.json(format!("{out}/sweep.json"));
    let outputs = record["outputs"].as_object().expect("outputs");
    let read = |name: &String| (name.clone(), fs::read(place.path(out).join(name)).expect("there"));
    outputs.keys().map(read).collect()
}

#[test]
fn every_value_of_an_axis_meets_every_value_of_the_others() {
    let place = place(&study());
    let (said, _) = place.run(&["sweep", "study.json", "-o", "out"], 0);
    assert!(said.starts_with("6 points, 12 beds; emissivity "), "{said}");
    let points = rows(&place, "out/results.csv");
    assert_eq!(points[0][..4], ["point", "zenith_deg", "fine", "beds"]);
    let of_axes: Vec<String> = points[1..].iter().map(|row| row[1..4].join(" ")).collect();
    let wanted = ["0 quartz 2", "0 grey 2", "20 quartz 2", "20 grey 2", "40 quartz 2", "40 grey 2"];
    assert_eq!(of_axes, wanted);
    let beds = rows(&place, "out/beds.csv");
    assert_eq!(beds.len(), 13);
    // A point is what the pipeline makes of the same values.
    let bed = &beds[1 + 2 * 2];
    assert_eq!(bed[..4], ["3", "20", "quartz", "1"]);
    let folder = &bed[bed.len() - 2];
    let alone = ["--set", "view.zenith_deg=20", "--set", "temperature_k=300", "--seed", "1"];
    // The rays of two beds share the tolerance.
    let tolerance = (0.1 * 2_f64.sqrt() / 2.0).to_string();
    let to = ["--tolerance", &tolerance, "--range", "8-12", "--step", "0.5", "-o", "one"];
    let run = ["pipeline", "--scene", "scenes/patch.json"];
    place.run(&[&run[..], &alone, &to].concat(), 0);
    let mut tables =
        [format!("out/{folder}/table.json"), "one/table.json".into()].map(|file| place.json(file));
    // What is given up depends on the tolerance of the mean.
    for table in &mut tables {
        table["stop"] = Value::Null;
    }
    assert_eq!(tables[0]["view"], tables[1]["view"]);
    assert_eq!(tables[0]["scene_sha256"], tables[1]["scene_sha256"]);
    for file in ["results.nc", "chart.png", "spectra.svg", "report.html", "inputs/study.json"] {
        assert!(place.path("out").join(file).is_file(), "{file}");
    }
}

#[test]
fn parts_side_by_side_give_the_bytes_of_one_run_and_no_bed_is_made_twice() {
    let place = place(&study());
    place.run(&["sweep", "study.json", "-o", "whole"], 0);
    for part in ["2/3", "1/3", "3/3"] {
        let (said, _) = place.run(&["sweep", "study.json", "-o", "parts", "--part", part], 0);
        assert!(said.contains("of 12 beds are finished"), "{said}");
        assert!(!place.path("parts/results.csv").exists());
    }
    let folders = || {
        let rows = rows(&place, "parts/beds.csv");
        let folder = |row: &Vec<String>| place.path("parts").join(&row[row.len() - 2]);
        let made = |folder: std::path::PathBuf| {
            fs::metadata(folder.join("table.json")).expect("there").modified().expect("a time")
        };
        rows[1..].iter().map(folder).map(made).collect::<Vec<_>>()
    };
    place.run(&["sweep", "study.json", "-o", "parts"], 0);
    assert_eq!(results(&place, "whole"), results(&place, "parts"));
    let before = folders();
    place.run(&["sweep", "study.json", "-o", "parts", "--no-cache"], 0);
    assert_eq!(before, folders());
    // Another value of an axis adds beds, and keeps the others.
    let mut more = study();
    more["axes"][0]["range"] = json!({"from": 0, "to": 60, "number": 4});
    place.write("study.json", more.to_string());
    let (_, told) = place.run(&["sweep", "study.json", "-o", "parts"], 0);
    assert!(told.contains("  4 beds\n"), "{told}");
    assert_eq!(rows(&place, "parts/results.csv").len(), 9);
}

#[test]
fn a_killed_sweep_goes_on_where_it_was() {
    let place = place(&study());
    fs::create_dir(place.path("tmp")).expect("made");
    let command = |out: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
        command.args(["sweep", "study.json", "-o", out, "--threads", "1"]);
        command.current_dir(place.folder()).env("TMPDIR", place.path("tmp"));
        command.env("SOILSIG_CACHE", place.path("cache"));
        command
    };
    let tables = || {
        let count =
            |folder: fs::DirEntry| fs::read_dir(folder.path()).into_iter().flatten().count();
        let shards = fs::read_dir(place.path("out/beds")).into_iter().flatten().flatten();
        shards
            .filter(|s| !s.file_name().to_string_lossy().starts_with('.'))
            .map(count)
            .sum::<usize>()
    };
    let mut before = 0;
    for kill in 1..=5 {
        killed_after(&mut command("out"), Duration::from_millis(150 * kill));
        let now = tables();
        assert!(now >= before, "a finished bed is gone");
        before = now;
    }
    assert_eq!(command("out").output().expect("it runs").status.code(), Some(0));
    assert_eq!(tables(), 12);
    let folders = ["out", "cache", "tmp"].map(|name| place.path(name));
    assert_eq!(left_over(&folders), [""; 0].map(std::path::PathBuf::from));
    let _ = fs::remove_dir_all(place.path("cache"));
    command("fresh").output().expect("it runs");
    assert_eq!(results(&place, "out"), results(&place, "fresh"));
}

#[test]
fn sampled_axes_are_coordinates_of_their_points() {
    let mut study = study();
    study["axes"] = json!([
        {"name": "sky_k", "key": "sky_temperature_k", "range": {"from": 200, "to": 280}},
        {"name": "temperature_k", "key": "temperature_k",
         "range": {"from": 290, "to": 320, "whole": true}},
        {"name": "facets", "key": "facets", "values": ["library", "inverted"]}
    ]);
    study["seeds"] = json!([1]);
    for method in ["sobol", "latin_hypercube"] {
        study["sample"] = json!({"method": method, "points": 4, "seed": 3});
        let place = place(&study);
        place.run(&["sweep", "study.json", "-o", "out"], 0);
        let rows = rows(&place, "out/results.csv");
        assert_eq!(rows.len(), 9);
        let number = |row: &Vec<String>, i: usize| row[i].parse::<f64>().expect("a number");
        let mut quarters: Vec<usize> = rows[1..]
            .iter()
            .step_by(2)
            .map(|row| ((number(row, 1) - 200.0) / 20.0) as usize)
            .collect();
        quarters.sort_unstable();
        assert_eq!(quarters, [0, 1, 2, 3], "{method}");
        assert!(rows[1..].iter().all(|row| number(row, 2).fract() == 0.0), "{method}");
        // Facets of another meaning are another emissivity; temperatures of the target are not.
        let emissivity: Vec<&String> = rows[1..].iter().map(|row| &row[5]).collect();
        assert_ne!(emissivity[0], emissivity[1]);
        assert_eq!(emissivity[0], emissivity[2]);
    }
}

#[test]
fn a_study_that_cannot_be_done_is_refused_before_any_work() {
    let place = place(&study());
    let mut told = String::new();
    let mut refused = |change: &dyn Fn(&mut Value)| {
        let mut study = study();
        change(&mut study);
        place.write("study.json", study.to_string());
        told += &place.refused(&["sweep", "study.json", "-o", "out"], 3);
    };
    refused(&|study| study["axes"][0]["key"] = "view.zenit_deg".into());
    refused(&|study| study["axes"][0]["range"] = json!({"from": 0, "to": 95, "number": 2}));
    refused(&|study| study["axes"][0]["range"] = json!({"from": 0, "to": 40}));
    refused(&|study| study["axes"][0]["values"] = json!([1]));
    refused(&|study| study["axes"][1]["key"] = "seed".into());
    refused(&|study| study["axes"][1]["name"] = "zenith_deg".into());
    refused(&|study| study["axes"][1]["name"] = "a/b".into());
    refused(&|study| study["seeds"] = json!([3, 3]));
    refused(&|study| study["sample"] = json!({"method": "sobol", "points": 8}));
    refused(&|study| study["source"] = json!({"coverage": "thick"}));
    refused(&|study| study["saeds"] = json!([1]));
    refused(&|study| study["axes"][0]["range"]["number"] = json!(2_000_000));
    refused(&|study| study["axes"][0]["range"]["number"] = json!(1_u64 << 50));
    refused(&|study| {
        study["axes"][0]["range"] = json!({"from": 0, "to": 40});
        study["sample"] = json!({"method": "sobol", "points": 1_u64 << 40});
    });
    let twice = json!({"name": "again", "key": "view.zenith_deg", "values": [10]});
    refused(&|study| study["axes"][1] = twice.clone());
    refused(&|study| study["axes"][1]["key"] = json!(5));
    let listed =
        |values: Value| json!({"name": "zenith", "key": "view.zenith_deg", "values": values});
    refused(&|study| study["axes"][0] = listed(json!([10, 20, 10.0])));
    refused(&|study| {
        study["axes"][0]["range"] = json!({"from": 0, "to": 2, "number": 4, "whole": true});
    });
    assert!(!place.path("out/beds").exists());
    assert_snapshot!(told);
}

#[test]
fn the_format_of_studies_is_that_of_its_schema() {
    let place = Place::new();
    let schema: Value =
        serde_json::from_str(&place.run(&["schema", "study"], 0).0).expect("a schema");
    let schema = jsonschema::validator_for(&schema).expect("a valid schema");
    assert!(schema.is_valid(&study()));
    for (key, value) in [("seeds", json!([])), ("keep", json!("all")), ("tolerance", json!(0))] {
        let mut study = study();
        study[key] = value;
        assert!(!schema.is_valid(&study), "{key}");
    }
}

#[test]
fn a_bundle_is_made_again_with_nothing_else_at_hand() {
    let mut study = study();
    study["seeds"] = json!([1]);
    study["axes"] = json!([{
        "name": "spectrum", "key": "materials.coarse.spectrum",
        "values": [{"file": "../spectra/mine.csv"}, {"builtin": "quartz_coarse"}]
    }]);
    let here = place(&study);
    fs::create_dir(here.path("spectra")).expect("made");
    here.write("spectra/mine.csv", "7,0.8\n9,0.5\n15,0.9\n");
    here.run(&["sweep", "study.json", "-o", "study"], 0);
    let set = "materials.coarse.spectrum={\"file\": \"../spectra/mine.csv\"}";
    let run = ["pipeline", "--scene", "scenes/patch.json", "--set", set, "--tolerance", "0.1"];
    let run = [&run[..], &["--range", "8-12", "--step", "0.5", "-o", "run"]].concat();
    // Made without some instruction sets.
    let without = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL,-AVX";
    let output = here.soilsig(&run).env("GLIBC_TUNABLES", without).output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(here.path("run/inputs/spectra/mine.csv").is_file());
    let there = Place::new();
    for result in ["run", "study"] {
        here.run(&["bundle", result], 0);
        let bundle = format!("{result}.zip");
        fs::rename(here.path(&bundle), there.path(&bundle)).expect("moved");
    }
    drop(here);
    for (bundle, files) in [("run.zip", "results.csv"), ("study.zip", "signature.csv")] {
        let (said, _) = there.run(&["replay", bundle, "--out", bundle.trim_end_matches(".zip")], 0);
        assert!(said.starts_with("the same result: "), "{said}");
        assert!(!said.contains(files));
    }
    // A folder and its crate are replayed too.
    there.run(&["replay", "run"], 0);
    there.run(&["replay", "study/ro-crate-metadata.json"], 0);
    // An input that was changed in the folder is no copy any more, and its file is gone.
    there.write("run/inputs/spectra/mine.csv", "7,0.9\n15,0.9\n");
    there.refused(&["bundle", "run"], 3);
    there.write("no.zip", "no");
    assert_snapshot!(there.refused(&["replay", "no.zip"], 3));
}

#[test]
fn a_scene_that_names_places_of_this_machine_is_not_bundled() {
    let place = place(&study());
    let mut scene = place.json("scenes/patch.json");
    let mesh = place.path("scenes/settled_patch.obj").display().to_string();
    scene["geometry"]["placed"]["prototypes"][0]["file"] = mesh.into();
    place.write("scenes/patch.json", scene.to_string());
    let run = ["pipeline", "--scene", "scenes/patch.json", "--tolerance", "0.2", "-o", "run"];
    place.run(&[&run[..], &["--range", "8-12", "--step", "1"]].concat(), 0);
    let told = place.refused(&["bundle", "run"], 3);
    assert!(told.contains("name it relative to the scene file"), "{told}");
}

#[test]
fn crates_pass_their_validator() {
    let Some(python) = tool(Tool::Readers) else { return };
    let place = place(&study());
    place.run(&["sweep", "study.json", "-o", "study"], 0);
    let run = ["pipeline", "--scene", "scenes/patch.json", "--tolerance", "0.2", "-o", "run"];
    place.run(&[&run[..], &["--range", "8-12", "--step", "1"]].concat(), 0);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers/crate.py");
    let output = Command::new(python)
        .arg(script)
        .args(["run", "study"])
        .current_dir(place.folder())
        .output()
        .expect("it starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}{errors}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn the_cache_is_shown_and_cleared() {
    let place = place(&study());
    place.run(&["sweep", "study.json", "-o", "out"], 0);
    let (said, _) = place.run(&["cache"], 0);
    assert!(said.contains("of at most 20.0 GB in") && said.contains("trace "), "{said}");
    assert!(said.contains("12 results"), "{said}");
    assert!(place.run(&["cache", "--clear", "drop"], 0).0.starts_with("0 results"));
    assert!(place.run(&["cache", "--clear"], 0).0.starts_with("12 results removed"));
    assert!(!place.run(&["cache"], 0).0.contains("trace"));
}

/// A recipe in Blender, over fines, view and temperature.
fn recipes() -> Value {
    json!({
        "soilsig_study": 1,
        "name": "fines",
        "source": {"scene": "small.json"},
        "axes": [
            {"name": "fines", "key": "geometry.packing.grains.grain_500.fines", "values": [0, 60]},
            {"name": "zenith_deg", "key": "view.zenith_deg", "values": [0, 30]}
        ],
        "seeds": [1, 2],
        "tolerance": 0.1,
        "bands": {"from_um": 8, "to_um": 12, "step_um": 0.5}
    })
}

#[test]
fn one_blender_drops_many_recipes_and_views_share_their_bed() {
    let Some(blender) = a_blender() else { return };
    let place = Place::new();
    let blender = place.counted(&blender);
    place.write("small.json", shipped_json("small.json").to_string());
    place.write("study.json", recipes().to_string());
    let sweep = |out: &str| {
        let args = ["sweep", "study.json", "-o", out, "--threads", "1"];
        let output = place.soilsig_with(&blender, &args).output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!([Some(0), Some(4)].contains(&output.status.code()), "{said}");
        place.starts()
    };
    let drops = || {
        let entries = fs::read_dir(place.path("cache")).expect("a cache").flatten();
        entries.filter(|e| e.file_name().to_string_lossy().starts_with("drop-")).count()
    };
    let starts = sweep("out");
    assert_eq!(drops(), 4, "two recipes of two seeds");
    // One looks whether it will do, and one drops all.
    assert_eq!(starts, 2);
    assert_eq!(rows(&place, "out/results.csv").len(), 5);
    // Temperature, sky and facets do not touch the bed.
    let mut study = recipes();
    study["axes"][1] = json!({"name": "light", "cases": [
        {"name": "warm", "set": ["temperature_k=320"]},
        {"name": "sky", "set": ["sky_temperature_k=250"]},
        {"name": "inverted", "set": ["facets=inverted"]}
    ]});
    place.write("study.json", study.to_string());
    assert_eq!(sweep("light"), starts);
    assert_eq!(drops(), 4);
    assert_eq!(rows(&place, "light/beds.csv").len(), 13);
}

#[test]
fn beds_that_fail_are_listed_and_the_others_are_finished() {
    let Some(blender) = a_blender() else { return };
    let place = Place::new();
    let blender = place.counted(&blender);
    place.write("small.json", shipped_json("small.json").to_string());
    let mut study = recipes();
    study["axes"] = json!([
        {"name": "frames", "key": "geometry.packing.drop.max_frames", "values": [400, 1]}
    ]);
    study["keep"] = "beds".into();
    place.write("study.json", study.to_string());
    let args = ["sweep", "study.json", "-o", "out", "--threads", "1"];
    let run = || {
        let output = place.soilsig_with(&blender, &args).output().expect("it runs");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(7), "{}", String::from_utf8_lossy(&output.stderr));
        text
    };
    let said = run();
    assert!(said.contains("2 beds failed, as failures.csv says"), "{said}");
    let failed = rows(&place, "out/failures.csv");
    assert_eq!(failed.len(), 3);
    assert_eq!(failed[1][..4], ["2", "1", "1", "16"]);
    let points = rows(&place, "out/results.csv");
    assert_eq!((&*points[1][2], &*points[2][2]), ("2", "0"));
    // A bed that is refused is refused again: it is not tried.
    let starts = place.starts();
    run();
    assert_eq!(place.starts(), starts);
    // A bed that was kept is traced as any other.
    let beds = rows(&place, "out/beds.csv");
    let folder = &beds[1][beds[1].len() - 2];
    let scene = format!("out/{folder}/scene.json");
    place.run(&["trace", &scene, "-o", "t.json", "--tolerance", "0.2"], 0);
}
