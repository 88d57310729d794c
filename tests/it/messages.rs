//! What the program says of each kind of error, word by word. The snapshots are in `snapshots/`;
//! after a change of words
//! `INSTA_UPDATE=always cargo test` writes them anew, and the difference shows what users will
//! read.

use std::fmt::Write as _;
use std::fs;

use insta::assert_snapshot;
use serde_json::{Value, json};

use crate::support::{Place, shipped, shipped_json};

const PLATE: &str = "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nusemtl m\nf 1 2 3 4\n";

/// A plate of one material, as `scene.json` beside its `mesh.obj`.
fn plate(place: &Place) -> Value {
    place.write("mesh.obj", PLATE);
    let scene = json!({
        "soilsig_scene": 1, "name": "plate", "seed": 1, "temperature_k": 300,
        "view": {"zenith_deg": 0}, "materials": [{"name": "m", "spectrum": {"constant": 0.7}}],
        "geometry": {"placed": {"prototypes": [{"name": "p", "file": "mesh.obj"}],
            "domain": {"min_um": [0, 0], "max_um": [9, 9], "sides": "mirror"}}},
    });
    place.write("scene.json", scene.to_string());
    scene
}

/// What is said of a scene with another value at a place, for each of some.
fn of_scenes(place: &Place, scene: &Value, args: &[&str], changes: &[(&str, Value)]) -> String {
    let mut told = String::new();
    for (at, value) in changes {
        let mut wrong = scene.clone();
        let (folder, key) = at.rsplit_once('/').expect("a pointer");
        wrong.pointer_mut(folder).expect("it is there")[key] = value.clone();
        place.write("scene.json", wrong.to_string());
        let _ = write!(told, "{at} = {value}\n{}", place.failed(args));
    }
    told
}

#[test]
fn of_placed_scenes() {
    let place = Place::new();
    let scene = plate(&place);
    let trace = ["trace", "scene.json", "--out", "t.json", "--paths", "1024"];
    let changes = [
        ("/soilsig_scene", json!(99)),
        ("/sead", json!(1)),
        ("/seed", json!(-1)),
        ("/temperature_k", json!("warm")),
        ("/view/zenith_deg", json!(95)),
        ("/sky_temperature_k", json!([{"zenith_deg": 0, "temperature_k": 200}])),
        ("/materials", json!([])),
        ("/materials", json!([{"name": "m", "spectrum": {"constant": 7}}])),
        ("/materials", json!([{"name": "m", "spectrum": {"builtin": "quarz"}}])),
        ("/materials", json!([{"name": "m", "spectrum": {"fresnel": "glass"}}])),
        ("/materials", json!([{"name": "m", "spectrum": {"file": "none.csv"}}])),
        ("/materials", json!([{"name": "m", "spectrum": {"constant": 0.7}, "specular": 2}])),
        ("/geometry/placed/prototypes", json!([])),
        ("/geometry/placed/prototypes", json!([{"name": "p", "file": "mesh.obj", "unit_um": 0}])),
        (
            "/geometry/placed/prototypes",
            json!([{"name": "p", "file": "mesh.obj"}, {"name": "p", "file": "mesh.obj"}]),
        ),
        ("/geometry/placed/instances", json!([{"prototype": "q", "transform": [1]}])),
        (
            "/geometry/placed/instances",
            json!([{"prototype": "q", "transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}]),
        ),
        (
            "/geometry/placed/instances",
            json!([{"prototype": "p", "transform": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]}]),
        ),
        ("/geometry/placed/domain", json!({"min_um": [9, 9], "max_um": [0, 0], "sides": "mirror"})),
        (
            "/geometry/placed/domain",
            json!({"min_um": [0, 0], "max_um": [9, 9], "sides": "mirror",
                   "floor": {"z_um": -1, "material": "n"}}),
        ),
    ];
    assert_snapshot!(of_scenes(&place, &scene, &trace, &changes));
    assert!(!place.path("t.json").exists());
}

/// All of it before Blender is looked for.
#[test]
fn of_recipes() {
    let place = Place::new();
    let scene = shipped_json("small.json");
    let pipeline = ["pipeline", "--scene", "scene.json", "--blender", "/no/such/blender"];
    let changes = [
        ("/geometry/packing/grains/0/shape", json!("cube")),
        ("/geometry/packing/grains/0/diameter_um", json!(-1)),
        ("/geometry/packing/grains/0/material", json!("gold")),
        ("/geometry/packing/tray_um", json!([0, 1000])),
        ("/geometry/packing/crop_um", json!(2000)),
        ("/geometry/packing/variants", json!(0)),
        ("/geometry/packing/floor_material", json!("gold")),
        ("/geometry/packing/drop", json!({"collision": "none"})),
    ];
    let mut told = of_scenes(&place, &scene, &pipeline, &changes);
    let placed = shipped("settled_patch.json");
    told += &place.failed(&["pipeline", "--scene", &placed, "--packings", "3"]);
    let recipe = shipped("small.json");
    for packings in ["0", "few"] {
        told += &place.failed(&["pipeline", "--scene", &recipe, "--packings", packings]);
    }
    assert_snapshot!(told);
}

#[test]
fn of_meshes() {
    let place = Place::new();
    plate(&place);
    let mut told = String::new();
    for (what, mesh) in [
        ("no faces", PLATE.replace("f 1 2 3 4\n", "")),
        ("a vertex that is not there", PLATE.replace("f 1 2 3 4", "f 1 2 3 5")),
        ("a word for a number", PLATE.replace("v 9 0 0", "v nine 0 0")),
        ("another material", PLATE.replace("usemtl m", "usemtl n")),
    ] {
        place.write("mesh.obj", mesh);
        let said = place.failed(&["trace", "scene.json", "--out", "t.json"]);
        let _ = write!(told, "{what}\n{said}");
    }
    assert_snapshot!(told);
}

#[test]
fn of_spectra() {
    let place = Place::new();
    place.write("short.csv", "8,0.5\n12,0.6\n");
    place.write("wrong.csv", "8,0.5\n9,1.6\n12,0.6\n");
    place.write("empty.csv", "");
    place.write("nonsense.csv", "one\ntwo\n");
    let told = [
        &["spectra", "show", "quarz"][..],
        &["spectra", "check", "none.csv"],
        &["spectra", "check", "wrong.csv"],
        &["spectra", "check", "empty.csv"],
        &["spectra", "check", "nonsense.csv"],
        &["spectra", "convert", "short.csv", "--out", "out.xyz"],
        &["spectra", "convert", "short.csv", "--name", "other", "--out", "out.csv"],
        &["spectra", "convert", "short.csv", "--range", "7-9", "--step", "0.5", "--out", "out.csv"],
        &["spectra", "plot", "short.csv", "--out", "out.gif"],
    ]
    .map(|args| place.failed(args));
    assert_snapshot!(told.concat());
}

#[test]
fn of_tables() {
    let place = Place::new();
    plate(&place);
    place.run(&["trace", "scene.json", "--out", "t.json", "--paths", "1024"], 0);
    place.write("wrong.json", place.read("t.json").replace("\"paths\"", "\"pathes\""));
    let told = [
        &["signature", "none.json"][..],
        &["signature", "wrong.json"],
        &["signature", "scene.json"],
        &["signature", "t.json", "--spectrum", "n=0.5"],
        &["signature", "t.json", "--spectrum", "m"],
        &["signature", "t.json", "--spectrum", "m=quarz"],
        &["signature", "t.json", "--spectrum", "m=7"],
        &["signature", "t.json", "--sky", "none.csv"],
        &["signature", "t.json", "--plot", "out.gif"],
        &["signature", "t.json", "--out", "nowhere/out.csv", "--plot", "t.json/out.svg"],
        &["merge", "none.json", "--out", "m.json"],
        &["merge", "scene.json", "--out", "m.json"],
        &["replay", "none.json"],
    ]
    .map(|args| place.failed(args));
    assert_snapshot!(told.concat());
}

#[test]
fn of_measured_radiance() {
    let place = Place::new();
    place.write("l.csv", "wavelength_um,radiance_w_m2_sr_um\n9,7.1\n10,8\n");
    place.write("sky.csv", "wavelength_um,l_downwelling_w_m2_sr_um\n9,1\n10,-1\n");
    place.write("air.csv", "wavelength_um,transmittance,l_path_w_m2_sr_um\n9,2,1\n10,0.9,1\n");
    place.write("l.hdr", "ENVI\nsamples = 1\n");
    place.write("l.img", "");
    let told = [
        &["l.csv", "--temperature", "warm"][..],
        &["l.csv", "--temperature", "300", "--method", "nem"],
        &["l.csv", "--method", "magic"],
        &["l.csv", "--temperature", "300", "--sky", "sky.csv"],
        &["l.csv", "--temperature", "300", "--atmosphere", "air.csv"],
        &["l.csv", "--temperature", "300", "--radiance-error", "-1"],
        &["l.img", "--temperature", "300", "--out", "e.img"],
    ]
    .map(|args| place.failed(&[&["retrieve"], args].concat()));
    assert_snapshot!(told.concat());
}

#[test]
fn of_images() {
    let place = Place::new();
    let mut scene = plate(&place);
    let told = [
        &["--pixels", "0x4"][..],
        &["--pixels", "four"],
        &["--noise", "0"],
        &["--range", "8-9", "--false-colour", "8,9"],
    ]
    .map(|args| place.failed(&[&["image", "scene.json", "--out", "i"], args].concat()));
    let image = ["image", "scene.json", "--out", "i", "--range", "9-9"];
    scene["sensor"] = json!({"pixels": [4, 4]});
    let changes = [
        ("/sensor/pixels", json!([0, 4])),
        ("/sensor/optics", json!({"pinhole": {"distance_um": -1, "field_of_view_deg": 20}})),
        ("/sensor/optics", json!({"pinhole": {"distance_um": 0.1, "field_of_view_deg": 200}})),
        ("/sensor/optics", json!({"orthographic": {"width_um": 0}})),
        ("/sensor/noise", json!({"nedt_k": -1})),
        ("/sensor/bands", json!([])),
        ("/sensor/bands", json!([{"box": {"centre_um": 9, "width_um": -1}}])),
    ];
    assert_snapshot!(told.concat() + &of_scenes(&place, &scene, &image, &changes));
    assert!(!place.path("i").exists());
}

#[test]
fn of_other_programs_scenes() {
    let place = Place::new();
    plate(&place);
    place.write("wrong.odb", "DIRSIG_ODB = 1.0\nOBJECT {\n");
    place.write("wrong.mat", "MATERIAL_ENTRY {\n}\n");
    let told = [
        &["export", "scene.json", "b", "--to", "povray"][..],
        &["export", "scene.json", "b", "--to", "mitsuba", "--at", "8,9"],
        &["export", "none.json", "b", "--to", "dirsig"],
        &["export", &shipped("small.json"), "b", "--to", "dirsig"],
        &["export", "scene.json", "mesh.obj/b", "--to", "dirsig", "--range", "8-9"],
        &["import", "none.odb", "--out", "s.json"],
        &["import", "wrong.odb", "--out", "s.json"],
        &["import", "wrong.odb", "--mat", "none.mat", "--out", "s.json"],
    ]
    .map(|args| place.failed(args));
    assert_snapshot!(told.concat());
}

#[test]
fn of_grains_and_blender() {
    let place = Place::new();
    fs::create_dir(place.path("empty")).expect("made");
    let nowhere = "/no/such/blender";
    let told = [
        &["grains", "check", "none"][..],
        &["grains", "check", "empty"],
        &["grains", "--blender", nowhere],
        &["grains", "--variants", "0"],
        &["pipeline", "--coverage", "sparse", "--blender", nowhere],
        &["pipeline", "--coverage", "sparse", "--grains", "none", "--blender", nowhere],
        &["pipeline", "--coverage", "sparse", "--blender-timeout", "0"],
        &["pipeline", "--coverage", "1.5"],
        &["doctor", "--blender", nowhere],
        &["blender", "--gui", "--blender", nowhere],
    ]
    .map(|args| place.failed(args));
    assert_snapshot!(told.concat());
}

#[test]
fn of_commands_and_flags() {
    let place = Place::new();
    plate(&place);
    let trace = ["trace", "scene.json", "--out", "t.json"];
    let mut told = String::new();
    for args in [
        &["--paths", "0"][..],
        &["--paths", "many"],
        &["--shard", "4/3"],
        &["--max-seconds", "-1"],
        &["--tolerance", "1"],
        &["--seed", "x"],
        &["--range", "14-7"],
        &["--colour"],
    ] {
        told += &place.failed(&[&trace, args].concat());
    }
    for args in [&["trase"][..], &["schema", "sceen"], &["chart", "none.json"], &["picture", "sky"]]
    {
        told += &place.failed(args);
    }
    assert_snapshot!(told);
}
