//! Grains of the user's own: what `soilsig grains check` refuses, and how scenes and `--grains` use
//! them.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use insta::assert_snapshot;
use serde_json::{Value, json};
use soilsig::beds::own_grains;
use soilsig::scene::{Scene, SceneGeometry};

use crate::support::{Place, real_blenders, shipped, shipped_json, told};

/// An octahedron about a place, its half-axes 300, 260 and 220 um, facing outward.
fn octahedron(shift: f64) -> String {
    let mut text = String::from("o grain\n");
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut corner = [shift; 3];
            corner[axis] += sign * [300.0, 260.0, 220.0][axis];
            let [x, y, z] = corner;
            let _ = writeln!(text, "v {x} {y} {z}");
        }
    }
    for [x, y, z] in [[1, 3, 5], [3, 2, 5], [2, 4, 5], [4, 1, 5]] {
        let _ = writeln!(text, "f {x} {y} {z}\nf {y} {x} {}", z + 1);
    }
    text
}

/// Diameter of the sphere of its volume, um.
fn diameter_um() -> f64 {
    let volume = 4.0 / 3.0 * 300.0 * 260.0 * 220.0;
    (6.0 * volume / std::f64::consts::PI).cbrt()
}

fn about(shape: &str) -> Value {
    json!({"soilsig_grain": 1, "shape": shape, "diameter_um": diameter_um()})
}

const CHECK: [&str; 3] = ["grains", "check", "grains"];

fn put(folder: &Path, name: &str, obj: &str, about: &Value) {
    fs::create_dir_all(folder).expect("made");
    fs::write(folder.join(format!("{name}.obj")), obj).expect("written");
    fs::write(folder.join(format!("{name}.json")), about.to_string()).expect("written");
}

#[test]
fn the_check_names_what_is_wrong_with_a_grain_and_where() {
    let place = Place::new();
    let folder = place.path("grains");
    let sound = octahedron(0.0);
    let class = about("angular");
    let without_last = sound.trim_end().rsplit_once('\n').expect("lines").0.to_owned();
    let turned = sound.replacen("f 1 3 5", "f 3 1 5", 1);
    let inward: String = sound
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            ["f", a, b, c] => format!("f {b} {a} {c}\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    let far = octahedron(5000.0).replace("o grain\n", "");
    let two = far.lines().fold(sound.clone(), |text, line| {
        let shifted: Vec<String> = line
            .split(' ')
            .map(|word| word.parse::<u32>().map_or(word.into(), |i| (i + 6).to_string()))
            .collect();
        text + &(if line.starts_with('f') { shifted.join(" ") } else { line.into() }) + "\n"
    });
    let crossing = sound.replace("v 300 0 0", "v -150 180 90");
    let hollow = sound.replace("v 300 0 0", "v -100 0 0");
    let of_hollow = json!({"soilsig_grain": 1, "shape": "angular", "diameter_um": 244.2186});
    let millimetres = sound.replace("00 ", ".0 ").replace("60 ", ".6 ");
    let wrong_shape = about("grain_700");
    let wrong_version = json!({"soilsig_grain": 2, "shape": "angular", "diameter_um": 1});
    let mut told = String::new();
    for (name, obj, json) in [
        ("sound", &sound, &class),
        ("open", &without_last, &class),
        ("turned", &turned, &class),
        ("inward", &inward, &class),
        ("two", &two, &class),
        ("crossing", &crossing, &class),
        ("hollow", &hollow, &of_hollow),
        ("unit", &millimetres, &class),
        ("shape", &sound, &wrong_shape),
        ("version", &sound, &wrong_version),
        ("no good", &sound, &class),
        ("nothing", &String::new(), &class),
        ("numbers", &sound.replace("v 300", "v nan"), &class),
    ] {
        let _ = fs::remove_dir_all(&folder);
        put(&folder, name, obj, json);
        let status = if matches!(name, "sound" | "hollow") { 0 } else { 3 };
        let (said, _) = place.run(&CHECK, status);
        assert!(said.starts_with(&format!("{name}: ")), "{name}: {said}");
        told += &said;
    }
    assert_snapshot!(told);
}

/// As libraries were written before shapes had their present names.
#[test]
fn a_library_with_the_earlier_names_of_shapes_is_read() {
    let place = Place::new();
    let folder = place.path("grains");
    let earlier =
        json!({"soilsig_grain": 1, "size_class": "grain_640", "diameter_um": diameter_um()});
    put(&folder, "stone", &octahedron(0.0), &earlier);
    let (said, _) = place.run(&CHECK, 0);
    assert!(said.starts_with("stone: subangular, "), "{said}");
    let import = ["grains", "import", "grains/stone.obj", "--out", "others", "--deviation", "0"];
    place.run(&[&import[..], &["--size-class", "grain_640"]].concat(), 0);
    assert_eq!(place.json("others/stone.json")["shape"], "subangular");
}

#[test]
fn a_mesh_without_its_json_is_refused_and_a_scene_beside_it_is_no_grain() {
    let place = Place::new();
    let folder = place.path("grains");
    put(&folder, "stone", &octahedron(0.0), &about("subangular"));
    fs::copy(shipped("small.json"), folder.join("bed.json")).expect("copied");
    place.run(&CHECK, 0);
    fs::remove_file(folder.join("stone.json")).expect("removed");
    let mut said = told(&CHECK, 3, &place.run(&CHECK, 3).0);
    fs::remove_file(folder.join("stone.obj")).expect("removed");
    said += &place.refused(&CHECK, 3);
    assert_snapshot!(said);
}

#[test]
fn what_is_wrong_with_a_library_is_known_before_blender_is_looked_for() {
    let place = Place::new();
    let mut told = String::new();
    let mut fails = |args: &[&str], status: i32| {
        let before = ["pipeline", "--blender", "/no/such/blender"];
        told += &place.refused(&[&before, args].concat(), status);
    };
    let small = shipped("small.json");
    let with = ["--scene", &small, "--grains", "grains"];
    fails(&with, 3);
    put(&place.path("grains"), "stone", &octahedron(0.0), &about("flake"));
    fails(&with, 3);
    put(&place.path("grains"), "stone", "f 1 2 3\n", &about("angular"));
    fails(&with, 3);
    let placed = shipped("settled_patch.json");
    fails(&["--scene", &placed, "--grains", "grains"], 2);
    // A sound one gets as far as the search for Blender, and one in groups is as sound.
    put(&place.path("grains"), "stone", &octahedron(0.0), &about("angular"));
    fails(&with, 10);
    let grouped = octahedron(0.0).replacen("\nf ", "\ng top\nusemtl a\nf ", 1);
    let (top, below) = grouped.rsplit_once("\nf ").expect("faces");
    let grouped = format!("mtllib none.mtl\n{top}\ng below\nusemtl b\nf {below}");
    put(&place.path("grains"), "stone", &grouped, &about("angular"));
    fails(&with, 10);

    let mut scene = shipped_json("small.json");
    let packing = &mut scene["geometry"]["packing"];
    packing["grains"][0]["shape"] = json!({"library": ["stone"]});
    fs::write(place.path("own.json"), scene.to_string()).expect("written");
    fails(&["--scene", "own.json"], 3);
    scene["geometry"]["packing"]["library"] = json!("grains");
    scene["geometry"]["packing"]["grains"][0]["shape"] = json!({"library": ["pebble"]});
    fs::write(place.path("own.json"), scene.to_string()).expect("written");
    fails(&["--scene", "own.json"], 3);
    put(&place.path("others"), "rock", &octahedron(0.0), &about("subangular"));
    fails(&["--scene", "own.json", "--grains", "others"], 3);
    scene["geometry"]["packing"]["grains"][0]["shape"] = json!("grain_700");
    fs::write(place.path("own.json"), scene.to_string()).expect("written");
    fails(&["--scene", "own.json"], 3);
    assert_snapshot!(told);
}

#[test]
fn ribs_go_with_the_shapes_that_grains_stand_for_and_are_not_written_unless_asked() {
    let place = Place::new();
    let mut scene = shipped_json("small.json");
    for class in [("grains", 0), ("grains", 1), ("fines", 0)] {
        scene["geometry"]["packing"][class.0][class.1]["ribs"] = json!(0);
    }
    let scene = Scene::parse(&scene.to_string(), Path::new("small.json")).expect("sound");
    let SceneGeometry::Packing(mut packing) = scene.geometry else { panic!("a recipe") };
    put(&place.path("grains"), "stone", &octahedron(0.0), &about("angular"));
    own_grains::replace_shapes(&mut packing, &place.path("grains")).expect("it fits");
    let written = serde_json::to_value(&packing).expect("plain data");
    let ribs = |kind: &str, i: usize| written[kind][i].get("ribs").cloned();
    assert_eq!(written["grains"][0]["shape"], json!({"library": ["stone"]}));
    assert_eq!([ribs("grains", 0), ribs("grains", 1)], [None, Some(json!(0))]);
    assert_eq!([ribs("grains", 2), ribs("fines", 0)], [None, Some(json!(0))]);
}

/// A run's record, and whether its bed came from the cache.
fn run(place: &Place, blender: &Path, args: &[&str]) -> (Value, bool) {
    let mut command = place.soilsig_with(blender, &["pipeline", "--json", "--tolerance", "0.05"]);
    command.args(["--packings", "1"]).args(["--range", "9-11", "--step", "1"]).args(args);
    let output = command.output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let record: Value = serde_json::from_slice(&output.stdout).expect("the record");
    let cached = record["stages"][0]["cached"] == true;
    (record, cached)
}

#[test]
fn grains_of_ones_own_stand_for_their_shape_and_their_content_makes_the_bed() {
    for (number, blender) in real_blenders().into_iter().enumerate() {
        let place = Place::new();
        let folder = place.path("grains");
        put(&folder, "stone", &octahedron(0.0), &about("angular"));
        put(&folder, "rock", &octahedron(9.0), &about("angular"));
        let args = ["--scene", &shipped("small.json"), "--out", "r", "--grains", "grains"];
        let (record, cached) = run(&place, &blender, &args);
        assert!(!cached);
        let inputs = record["inputs"].as_object().expect("inputs");
        assert_eq!(inputs.keys().filter(|path| path.contains("/grains/")).count(), 4);
        let drop: Value =
            serde_json::from_str(&fs::read_to_string(place.path("r/drop.json")).expect("written"))
                .expect("JSON");
        let made: Vec<(&str, &str)> = drop["prototypes"]
            .as_array()
            .expect("prototypes")
            .iter()
            .map(|p| (p["name"].as_str().expect("a name"), p["shape"].as_str().expect("a shape")))
            .collect();
        // One variant is asked for, and two grains are there: both fall.
        let own = [("grain_500_0", "rock"), ("grain_500_1", "stone")];
        let modelled = [("grain_640_0", "subangular"), ("grain_853_0", "worn")];
        assert_eq!(made, [own, modelled].concat());
        // An octahedron of the class's diameter: its sphericity tells it from the shape.
        let volume = drop["prototypes"][0]["volume_um3"].as_f64().expect("a volume");
        let sphere = |d: f64| std::f64::consts::FRAC_PI_6 * d.powi(3);
        assert!((volume / (sphere(500.0) + 150.0 * sphere(60.0)) - 1.0).abs() < 1e-6);
        assert_eq!(drop["prototypes"][0]["facets"], 8);

        // What makes a bed anew is the same in every Blender.
        if number > 0 {
            continue;
        }
        assert!(run(&place, &blender, &args).1, "the same grains are the same bed");
        let mut replay = place.soilsig(&["replay", "r/run.json"]);
        replay.env("SOILSIG_BLENDER", &blender).assert().success();

        // Another place of the same files changes nothing, another grain does.
        fs::rename(&folder, place.path("moved")).expect("renamed");
        let moved = [&args[..5], &["moved"]].concat();
        assert!(run(&place, &blender, &moved).1);
        let other = octahedron(0.0).replace("v 300 0 0", "v 310 0 0");
        fs::write(place.path("moved/stone.obj"), other).expect("written");
        assert!(!run(&place, &blender, &moved).1);
    }
}
