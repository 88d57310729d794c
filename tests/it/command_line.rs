//! The program as a user meets it: exit statuses, messages, files written or not.

use std::fs;

use serde_json::{Value, json};

use insta::assert_snapshot;

use crate::support::{Place, shipped, shipped_json, told};

#[test]
fn trace_and_signature_turn_the_shipped_patch_into_a_curve() {
    let place = Place::new();
    let (out, _) =
        place.run(&["trace", &shipped("settled_patch.json"), "--out", "t.json", "--json"], 0);
    let reached: Value = serde_json::from_str(&out).expect("JSON");
    assert!(reached["half_width"].as_f64().expect("a number") <= 0.005);
    place.run(&["signature", "t.json", "--out", "s.csv", "--plot", "s.svg"], 0);
    place.run(&["signature", "t.json", "--plot", "s.png"], 0);
    let csv = fs::read_to_string(place.path("s.csv")).expect("written");
    assert_eq!(csv.lines().count(), 652);
    assert!(csv.starts_with("wavelength_um,emissivity,emissivity_standard_error,"));
    assert!(fs::read_to_string(place.path("s.svg")).expect("written").starts_with("<svg"));
    assert!(fs::read(place.path("s.png")).expect("written").starts_with(b"\x89PNG"));
}

#[test]
fn the_table_is_the_same_for_any_number_of_threads() {
    let place = Place::new();
    let mut tables = Vec::new();
    for threads in ["1", "2", "16"] {
        place.run(
            &["trace", &shipped("settled_patch.json"), "--out", "t.json", "--threads", threads],
            0,
        );
        tables.push(fs::read(place.path("t.json")).expect("written"));
    }
    assert!(tables.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn a_table_is_evaluated_with_other_spectra_without_tracing() {
    let place = Place::new();
    place.run(&["trace", &shipped("settled_patch.json"), "--out", "t.json"], 0);
    let level = |spectra: &[&str]| {
        let args = [&["signature", "t.json", "--range", "9-9"], spectra].concat();
        let (out, _) = place.run(&args, 0);
        let row = out.lines().nth(1).expect("a band").to_owned();
        row.split(',').nth(1).expect("emissivity").parse::<f64>().expect("a number")
    };
    let black = ["--spectrum", "fine=1", "--spectrum", "coarse=1", "--spectrum", "floor=1"];
    assert!((level(&black) - 1.0).abs() < 1e-12);
    fs::write(place.path("mine.csv"), "8,0.2\n10,0.2\n").expect("written");
    assert!(level(&["--spectrum", "fine=mine.csv"]) < level(&["--spectrum", "fine=0.9"]));
    assert!(level(&["--spectrum", "fine=quartz_coarse"]) < level(&[]));
}

/// A change of a scene file.
type Edit<'a> = &'a dyn Fn(&mut Value);

/// Whatever a table keeps of a path: order, zenith angle, cosines.
#[test]
fn a_table_of_any_kind_is_read_as_it_was_written() {
    let place = Place::new();
    let patch = shipped_json("settled_patch.json");
    let warm = |scene: &mut Value| scene["materials"][0]["temperature_k"] = 310.into();
    let by_zenith = |scene: &mut Value| {
        let at = |zenith: i32, k: i32| json!({"zenith_deg": zenith, "temperature_k": k});
        scene["sky_temperature_k"] = json!([at(0, 220), at(90, 280)]);
    };
    let fresnel = |scene: &mut Value| {
        for material in scene["materials"].as_array_mut().expect("a list") {
            material["spectrum"] = json!({"fresnel": "quartz"});
        }
    };
    let kinds: [(&str, &[Edit]); 5] = [
        ("order", &[&warm]),
        ("zenith", &[&by_zenith]),
        ("cosines", &[&fresnel]),
        ("order and zenith", &[&warm, &by_zenith]),
        ("all", &[&warm, &by_zenith, &fresnel]),
    ];
    for (kind, edits) in kinds {
        let mut scene = patch.clone();
        for edit in edits {
            edit(&mut scene);
        }
        fs::write(place.path("scene.json"), scene.to_string()).expect("written");
        let traced = place.run(&["trace", "scene.json", "--out", "t.json", "--paths", "4096"], 0);
        let (csv, _) = place.run(&["signature", "t.json", "--range", "9-9"], 0);
        assert_eq!(csv.lines().count(), 2, "{kind}: {traced:?}");
    }
}

/// A material with a temperature of its own, which is the scene's: the order of hits is not kept.
#[test]
fn another_temperature_is_refused_where_paths_do_not_tell_what_it_does() {
    let place = Place::new();
    let mut scene = shipped_json("settled_patch.json");
    scene["materials"][0]["temperature_k"] = scene["temperature_k"].clone();
    fs::write(place.path("scene.json"), scene.to_string()).expect("written");
    place.run(&["trace", "scene.json", "--out", "t.json", "--paths", "2048"], 0);
    place.run(&["signature", "t.json", "--range", "9-9"], 0);
    let other = ["signature", "t.json", "--range", "9-9", "--temperature", "310"];
    let mut told = place.refused(&other, 2);
    let table = fs::read_to_string(place.path("t.json")).expect("written");
    let by_hand = table.replacen("\"temperature_k\": 300", "\"temperature_k\": 310", 1);
    assert_ne!(by_hand, table);
    fs::write(place.path("t.json"), by_hand).expect("written");
    told += &place.refused(&["signature", "t.json"], 3);
    assert_snapshot!(told);
}

#[test]
fn no_result_is_written_over_what_it_is_made_of() {
    let place = Place::new();
    let trace =
        ["trace", &shipped("settled_patch.json"), "--paths", "2048", "--tolerance", "0.0005"];
    for shard in ["1", "2"] {
        let (part, out) = (format!("{shard}/2"), format!("{shard}.json"));
        place.run(&[&trace[..], &["--shard", &part, "--out", &out]].concat(), 0);
    }
    place.refused(&["merge", "1.json", "2.json", "--out", "1.json"], 1);
    // As many paths as were asked for, whatever they reach.
    place.run(&["merge", "1.json", "2.json", "--out", "t.json"], 0);
    let whole = fs::read(place.path("t.json")).expect("written");
    for args in [
        &["signature", "t.json", "--out", "t.json"][..],
        &["signature", "t.json", "--out", "s.csv", "--budget", "s.csv"],
        &["signature", "t.json", "--out", "s.csv", "--plot", "t.json"],
    ] {
        place.refused(args, 1);
    }
    assert_eq!(fs::read(place.path("t.json")).expect("still there"), whole);
    assert!(!place.path("s.csv").exists());
    fs::write(place.path("m.csv"), "8,0.2\n10,0.3\n").expect("written");
    place.refused(&["spectra", "convert", "m.csv", "--step", "0.5", "--out", "m.csv"], 1);
}

#[test]
fn what_lies_beyond_a_kilometre_and_beds_of_other_sides_are_refused() {
    let place = Place::new();
    fs::write(place.path("m.obj"), "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nusemtl m\nf 1 2 3 4\n")
        .expect("written");
    let trace = |name: &str, z_um: f64, sides: &str, status: i32| {
        let scene = json!({
            "soilsig_scene": 1, "name": "plate", "seed": 1, "temperature_k": 300,
            "view": {"zenith_deg": 0}, "materials": [{"name": "m", "spectrum": {"constant": 0.7}}],
            "geometry": {"placed": {
                "prototypes": [{"name": "p", "file": "m.obj", "unit_um": 1, "up": "z"}],
                "domain": {"min_um": [0, 0], "max_um": [2, 2], "sides": sides,
                           "floor": {"z_um": z_um, "material": "m"}}}},
        });
        fs::write(place.path("scene.json"), scene.to_string()).expect("written");
        let args = ["trace", "scene.json", "--paths", "2048", "--range", "9-9", "--out", name];
        let (_, err) = place.run(&args, status);
        told(&args, status, &err)
    };
    let mut told = trace("far.json", -1e30, "mirror", 3);
    trace("mirror.json", -1.0, "mirror", 0);
    trace("open.json", -2.0, "open", 0);
    told += &place.refused(&["signature", "mirror.json", "open.json", "--range", "9-9"], 3);
    assert_snapshot!(told);
}

/// At 80 degrees a sky of 250 K at 60 and 290 K at 90 degrees changes by 1.6 % of a black body's
/// radiance in half a degree.
#[test]
fn mirrors_under_a_sky_of_degrees_are_told_how_well_they_are_known() {
    let place = Place::new();
    fs::write(place.path("m.obj"), "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nusemtl m\nf 1 2 3 4\n")
        .expect("written");
    let said = |specular: f64| {
        let at = |zenith: i32, k: i32| json!({"zenith_deg": zenith, "temperature_k": k});
        let scene = json!({
            "soilsig_scene": 1, "name": "plate", "seed": 1, "temperature_k": 300,
            "sky_temperature_k": [at(0, 220), at(60, 250), at(90, 290)],
            "view": {"zenith_deg": 80},
            "materials": [{"name": "m", "spectrum": {"constant": 0}, "specular": specular}],
            "geometry": {"placed": {
                "prototypes": [{"name": "p", "file": "m.obj", "unit_um": 1, "up": "z"}],
                "domain": {"min_um": [0, 0], "max_um": [2, 2], "sides": "mirror"}}},
        });
        fs::write(place.path("scene.json"), scene.to_string()).expect("written");
        let trace = ["trace", "scene.json", "--paths", "2048", "--range", "8-9", "--out", "t.json"];
        place.run(&trace, 0);
        place.run(&["signature", "t.json", "--range", "8-9"], 0).1
    };
    let [mirror, matt] = [1.0, 0.0].map(said);
    let warnings = |said: &str| said.lines().filter(|line| line.starts_with("warning")).count();
    assert_eq!([warnings(&mirror), warnings(&matt)], [2, 1]);
    assert_snapshot!(mirror);
}

/// Before Blender is looked for.
#[test]
fn a_run_does_not_write_over_its_own_recipe_or_spectrum() {
    let place = Place::new();
    let mut scene = shipped_json("small.json");
    scene["materials"][0]["spectrum"] = json!({"file": "budget.csv"});
    let mut told = String::new();
    fs::create_dir(place.path("o")).expect("made");
    fs::write(place.path("o/budget.csv"), "7,0.9\n15,0.9\n").expect("written");
    for (recipe, inputs) in [("o/mine.json", "budget.csv"), ("o/scene.json", "scene.json")] {
        if inputs == "scene.json" {
            scene["materials"][0]["spectrum"] = json!({"constant": 0.9});
        }
        fs::write(place.path(recipe), scene.to_string()).expect("written");
        let args = ["pipeline", "--scene", recipe, "--out", "o", "--blender", "/no/such/blender"];
        told += &place.refused(&args, 1);
        assert_eq!(fs::read_to_string(place.path(recipe)).expect("there"), scene.to_string());
    }
    assert!(place.read("o/budget.csv").starts_with("7,0.9"));
    assert_snapshot!(told);
}

/// Narrower than a quick-look is drawn, and much longer.
#[test]
fn an_image_may_be_of_any_shape_and_show_bands_that_are_close() {
    let place = Place::new();
    let patch = shipped("settled_patch.json");
    let args = ["image", &patch, "--out", "i", "--pixels", "1x40", "--noise", "0.5"];
    let bands = ["--range", "8.99-9.01", "--step", "0.001", "--show", "9,9.003"];
    place.run(&[&args[..], &bands].concat(), 0);
    for file in [
        "radiance.img",
        "image.nc",
        "false_colour.png",
        "brightness_9.000um.png",
        "brightness_9.003um.png",
    ] {
        assert!(place.path("i").join(file).is_file(), "{file}");
    }
}

/// An exported scene that is read again lies beside what it reads.
#[test]
fn an_export_does_not_write_over_the_scene_that_it_is_made_of() {
    let place = Place::new();
    place.run(
        &["export", &shipped("settled_patch.json"), "b", "--to", "dirsig", "--range", "8-12"],
        0,
    );
    place.run(&["import", "b/scene.odb", "--out", "b/scene.json"], 0);
    let mesh = fs::read(place.path("b/mesh_0.obj")).expect("written");
    place.refused(&["export", "b/scene.json", "b", "--to", "dirsig", "--range", "8-12"], 1);
    assert_eq!(fs::read(place.path("b/mesh_0.obj")).expect("still there"), mesh);
    place.run(&["export", "b/scene.json", "c", "--to", "dirsig", "--range", "8-12"], 0);
    place.refused(&["import", "b/scene.odb", "--out", "b/scene.odb"], 1);
}

#[test]
fn a_chart_shows_measured_spectra_beside_the_signature() {
    let place = Place::new();
    let args = ["trace", &shipped("settled_patch.json"), "--out", "t.json", "--paths", "2048"];
    place.run(&args, 0);
    fs::write(place.path("mine.csv"), "8,0.2\n10,0.3\n").expect("written");
    let chart = |beside: &[&str]| {
        let plot = ["signature", "t.json", "--out", "s.csv", "--plot", "s.svg"];
        place.run(&[&plot, beside].concat(), 0);
        fs::read_to_string(place.path("s.svg")).expect("written")
    };
    let (alone, both) = (chart(&[]), chart(&["--beside", "quartz_fine", "--beside", "mine.csv"]));
    for shown in [">mine.csv</text>", ">quartz_fine</text>"] {
        assert!(!alone.contains(shown) && both.contains(shown), "{shown}");
    }
    let far =
        ["signature", "t.json", "--plot", "n.svg", "--beside", "mine.csv", "--range", "11-12"];
    let mut told = place.refused(&far, 3);
    told += &place.refused(&["signature", "t.json", "--sensor", "aster", "--plot", "n.svg"], 2);
    assert_snapshot!(told);
    assert!(!place.path("n.svg").exists());
}

#[test]
fn wrong_input_is_refused_with_file_place_and_remedy() {
    let place = Place::new();
    let patch = fs::read_to_string(shipped("settled_patch.json")).expect("shipped");
    let write = |name: &str, text: &str| fs::write(place.path(name), text).expect("written");
    write("misspelt.json", &patch.replacen("\"seed\"", "\"sead\"", 1));
    write("cold.json", &patch.replacen("\"temperature_k\": 300", "\"temperature_k\": -3", 1));
    write("gone.json", &patch);
    write("torn.json", &patch[..patch.len() / 2]);
    let told: String = [
        &["trace", "misspelt.json", "-o", "t.json"][..],
        &["trace", "cold.json", "-o", "t.json"],
        &["trace", "gone.json", "-o", "t.json"],
        &["trace", "torn.json", "-o", "t.json"],
        &["trace", "absent.json", "-o", "t.json"],
        &["trace", &shipped("sparse.json"), "-o", "t.json"],
        &["signature", "torn.json"],
        &["replay", "torn.json"],
        &["trace", &shipped("settled_patch.json"), "-o", "t.json", "--range", "7-14"],
    ]
    .map(|args| place.refused(args, 3))
    .concat();
    assert_snapshot!(told);
    assert!(!place.path("t.json").exists());
}

#[test]
fn a_wrong_command_line_says_what_there_is() {
    let place = Place::new();
    let told: String = [
        &["pipeline", "--coverage", "thick"][..],
        &["pipeline"],
        &["trace", "a", "-o", "b", "--range", "9"],
        &["trace", "a", "-o", "b", "--range", "9-8"],
        &["trace", "a", "-o", "b", "--tolerance", "0"],
        &["trace", "a", "-o", "b", "--threads", "0"],
        &["signature", "t", "--step", "-1"],
    ]
    .map(|args| place.refused(args, 2))
    .concat();
    assert_snapshot!(told);
}

#[test]
fn a_place_that_cannot_be_written_to_is_named() {
    let place = Place::new();
    fs::write(place.path("file"), "").expect("written");
    let args = ["trace", &shipped("settled_patch.json"), "-o", "file/t.json"];
    assert_snapshot!(place.refused(&args, 1));
}

#[test]
fn a_full_standard_output_is_an_error_and_a_closed_one_is_not() {
    let place = Place::new();
    let full = || fs::File::create("/dev/full").expect("a device that is always full");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_soilsig"));
    let status = command.args(["schema", "scene"]).stdout(full()).status().expect("it runs");
    assert_eq!(status.code(), Some(1));
    let text = "\"$0\" schema scene | head -1";
    let mut shell = std::process::Command::new("sh");
    let status = shell.args(["-c", text, env!("CARGO_BIN_EXE_soilsig")]).output().expect("it runs");
    assert!(status.status.success() && status.stderr.is_empty(), "{status:?}");
    drop(place);
}

#[test]
fn a_path_that_no_record_can_hold_is_refused() {
    use std::os::unix::ffi::OsStrExt;
    let place = Place::new();
    let out = std::ffi::OsStr::from_bytes(b"r\xff");
    let mut command = place.soilsig(&["pipeline", "--coverage", "sparse", "--out"]);
    command.arg(out).assert().code(2);
}

#[test]
fn a_table_by_other_hands_is_checked() {
    let place = Place::new();
    place.run(&["trace", &shipped("settled_patch.json"), "--out", "t.json"], 0);
    let table: Value =
        serde_json::from_str(&fs::read_to_string(place.path("t.json")).expect("written"))
            .expect("JSON");
    let spectrum = |spectrum: Value| {
        let mut table = table.clone();
        table["materials"][0]["spectrum"] = spectrum;
        table
    };
    let with = |key: &str, value: Value| {
        let mut table = table.clone();
        table[key] = value;
        table
    };
    let mut told = String::new();
    for wrong in [
        spectrum(serde_json::json!({"constant": 7})),
        spectrum(
            serde_json::json!({"tabulated": {"file": "f", "wavelength_um": [], "emissivity": []}}),
        ),
        spectrum(serde_json::json!({"builtin": "quarz"})),
        with("temperature_k", (-5).into()),
        with("floor", 99.into()),
        with("numbers", serde_json::json!([0, 5])),
        with("paths", 3.into()),
        with("soilsig_table", 1.into()),
    ] {
        fs::write(place.path("wrong.json"), wrong.to_string()).expect("written");
        told += &place.refused(&["signature", "wrong.json"], 3);
    }
    assert_snapshot!(told);
}

#[test]
fn a_field_is_asked_for_in_particles_and_of_recipes_only() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let of = |particles: &str| {
        let args = ["pipeline", "--scene", &scene, "--field", particles, "--out", "r"];
        place.refused(&args, 2)
    };
    assert_snapshot!(["4.24e8", "0", "1e16", "many", "nan"].map(of).concat());
    assert!(!place.path("r/run.json").exists());
}

#[test]
fn a_tolerance_that_the_caps_do_not_allow_has_its_own_status_and_a_result() {
    let place = Place::new();
    let (out, _) = place.run(
        &[
            "trace",
            &shipped("settled_patch.json"),
            "-o",
            "t.json",
            "--tolerance",
            "1e-4",
            "--max-paths",
            "5000",
            "--json",
        ],
        4,
    );
    let reached: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(reached["tolerance_reached"], false);
    // Two paths that happen to weigh the same are no result within the tolerance.
    for seed in ["1", "2", "3", "4", "5", "6"] {
        let few = ["--out", "few.json", "--max-paths", "2", "--seed", seed];
        place.run(&[&["trace", &shipped("settled_patch.json")][..], &few].concat(), 4);
    }
    place.run(&["signature", "t.json"], 0);
}

#[test]
fn the_pipeline_takes_placed_scenes_without_blender_and_replays_them() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let args = ["pipeline", "--scene", &scene, "--out", "r", "--json"];
    // A Blender that is none: it must not be looked for.
    let run = |args: &[&str]| {
        place.soilsig(args).env("SOILSIG_BLENDER", "/nowhere/blender").assert().success()
    };
    run(&args);
    for file in
        ["table.json", "signature.csv", "signature.svg", "signature.png", "patch.png", "run.json"]
    {
        assert!(place.path("r").join(file).is_file(), "{file}");
    }
    let again: Value =
        serde_json::from_slice(&run(&args).get_output().stdout).expect("the record as JSON");
    let cached = |name: &str| {
        let stages = again["stages"].as_array().expect("stages");
        stages.iter().any(|s| s["name"] == name && s["cached"] == true)
    };
    assert!(cached("trace") && cached("picture"), "{again}");
    run(&["replay", "r/run.json"]);
    // A result that was tampered with is found out.
    let record = fs::read_to_string(place.path("r/run.json")).expect("written");
    let record: Value = serde_json::from_str(&record).expect("JSON");
    let sum = record["outputs"]["signature.csv"]["sha256"].as_str().expect("a sum");
    let other = fs::read_to_string(place.path("r/run.json"))
        .expect("written")
        .replace(sum, &"0".repeat(64));
    fs::write(place.path("r/run.json"), other).expect("written");
    let (out, _) = place.run(&["replay", "r/run.json"], 5);
    let lines: Vec<&str> = ["signature.csv", "table.json"]
        .map(|file| out.lines().find(|line| line.contains(file)).expect("compared"))
        .into();
    assert_snapshot!(lines.join(
        "
"
    ));
}

#[test]
fn a_run_that_fails_leaves_an_earlier_result_alone_and_one_that_succeeds_replaces_it() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    place.run(&["pipeline", "--scene", &scene, "--out", "r"], 0);
    let files = || {
        let entries = fs::read_dir(place.path("r")).expect("a folder");
        let mut all: Vec<_> = entries
            .map(|entry| entry.expect("an entry").path())
            .filter(|path| path.is_file())
            .map(|path| (fs::read(&path).expect("a file"), path))
            .collect();
        all.sort();
        all
    };
    let before = files();
    place.refused(&["pipeline", "--coverage", "thick", "--out", "r"], 2);
    place.refused(&["pipeline", "--scene", "gone.json", "--out", "r"], 3);
    place.refused(&["pipeline", "--scene", &scene, "--out", "r", "--range", "7-14"], 3);
    assert!(files() == before, "a failed run changed an earlier result");
    // A record that names files of this run's, of an earlier one's and of nobody's.
    fs::write(place.path("mine"), "keep").expect("written");
    fs::write(place.path("r/scene.glb"), "stale").expect("written");
    let record = fs::read_to_string(place.path("r/run.json")).expect("written");
    let mut record: Value = serde_json::from_str(&record).expect("JSON");
    let absolute = place.path("mine").display().to_string();
    for (name, file) in [("scene.glb", "r/scene.glb"), ("../mine", "mine"), (&*absolute, "mine")] {
        let sum = soilsig::support::output::sha256_hex(&place.path(file)).expect("read");
        record["outputs"][name] = serde_json::json!({"sha256": sum, "reproducible": true});
    }
    fs::write(place.path("r/run.json"), record.to_string()).expect("written");
    place.run(&["pipeline", "--scene", &scene, "--out", "r"], 0);
    assert!(!place.path("r/scene.glb").exists() && place.path("mine").exists());
}

#[test]
fn the_scene_schema_admits_the_shipped_scenes_and_refuses_unknown_keys() {
    let place = Place::new();
    let (out, _) = place.run(&["schema", "scene"], 0);
    let schema: Value = serde_json::from_str(&out).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    for name in ["full", "less", "sparse", "bare", "settled_patch", "quartz_sand"] {
        let mut scene = shipped_json(&format!("{name}.json"));
        assert!(validator.is_valid(&scene), "{name}");
        scene["sead"] = 1.into();
        assert!(!validator.is_valid(&scene), "{name} with an unknown key");
    }
}

#[test]
fn ribs_are_0_to_2_and_of_modelled_shapes_only() {
    let place = Place::new();
    let (out, _) = place.run(&["schema", "scene"], 0);
    let schema: Value = serde_json::from_str(&out).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    let small = shipped_json("small.json");
    let mut told = String::new();
    let said = |scene: &Value, status: i32| {
        fs::write(place.path("ribs.json"), scene.to_string()).expect("written");
        let blender = ["--blender", "/no/such/blender"];
        place.refused(&[&["pipeline", "--scene", "ribs.json"], &blender[..]].concat(), status)
    };
    for kind in ["grains", "fines"] {
        let with = |ribs: i32| {
            let mut scene = small.clone();
            scene["geometry"]["packing"][kind][0]["ribs"] = ribs.into();
            scene
        };
        for ribs in 0..=2 {
            assert!(validator.is_valid(&with(ribs)), "{kind} {ribs}");
            // What is sound gets as far as the search for Blender.
            said(&with(ribs), 10);
        }
        for ribs in [3, -1] {
            assert!(!validator.is_valid(&with(ribs)), "{kind} {ribs}");
            told += &said(&with(ribs), 3);
        }
        let mut own = with(1);
        own["geometry"]["packing"]["library"] = "grains".into();
        own["geometry"]["packing"][kind][0]["shape"] = serde_json::json!({"library": ["stone"]});
        told += &said(&own, 3);
    }
    assert_snapshot!(told);
}

#[test]
fn completions_and_help_are_there() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish"] {
        let (out, _) = place.run(&["completions", shell], 0);
        assert!(out.contains("pipeline"), "{shell}");
    }
    let (out, _) = place.run(&["--help"], 0);
    for command in ["pipeline", "trace", "signature", "replay", "doctor", "schema"] {
        assert!(out.contains(command), "{command}");
    }
}
