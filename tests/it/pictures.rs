//! `soilsig picture`: what is on the pictures, pixel by pixel, and that they are the same
//! everywhere.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use insta::assert_snapshot;
use serde_json::{Value, json};

use crate::support::{Place, SmallBed, real_blenders, shipped};

impl Place {
    /// Runs and expects that exit status; returns standard error.
    fn run_picture(&self, args: &[&str]) {
        // A picture must not look for a Blender.
        let mut command = self.soilsig(args);
        let output = command.env("SOILSIG_BLENDER", "/nowhere/blender").output().expect("it runs");
        let errors = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(output.status.success(), "{args:?}\n{errors}");
    }

    fn picture(&self, args: &[&str]) -> Picture {
        self.run_picture(&[&["picture"], args, &["--out", "p.png"]].concat());
        Picture::read(&self.path("p.png"))
    }
}

struct Picture {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Picture {
    fn read(path: &Path) -> Self {
        let file = std::io::BufReader::new(fs::File::open(path).expect("written"));
        let mut reader = png::Decoder::new(file).read_info().expect("a PNG file");
        let (width, height) = (reader.info().width as usize, reader.info().height as usize);
        let mut rgb = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut rgb).expect("pixels");
        assert_eq!(rgb.len(), 3 * width * height);
        Self { width, height, rgb }
    }

    fn at(&self, x: usize, y: usize) -> [i32; 3] {
        let at = 3 * (y * self.width + x);
        [0, 1, 2].map(|i| i32::from(self.rgb[at + i]))
    }
}

/// A sphere of 100 um on a floor, within 600 x 600 um, as `scene.json`.
fn sphere_on_floor(place: &Place) {
    const RINGS: usize = 48;
    const STEPS: usize = 96;
    let mut obj = "o sphere\nusemtl coarse\n".to_owned();
    for ring in 0..=RINGS {
        for step in 0..STEPS {
            let (polar, turn) =
                (PI * ring as f64 / RINGS as f64, 2.0 * PI * step as f64 / STEPS as f64);
            let r = 100.0 * polar.sin();
            let (x, y, z) = (r * turn.cos(), r * turn.sin(), 100.0 * polar.cos());
            writeln!(obj, "v {x:.6} {y:.6} {z:.6}").expect("text");
        }
    }
    for ring in 0..RINGS {
        for step in 0..STEPS {
            let corner = |r: usize, s: usize| r * STEPS + s % STEPS + 1;
            let [a, b] = [corner(ring, step), corner(ring + 1, step)];
            let [c, d] = [corner(ring + 1, step + 1), corner(ring, step + 1)];
            writeln!(obj, "f {a} {b} {c}\nf {a} {c} {d}").expect("text");
        }
    }
    fs::write(place.path("sphere.obj"), obj).expect("written");
    let material = |name: &str| json!({"name": name, "spectrum": {"constant": 0.9}});
    let scene = json!({
        "soilsig_scene": 1, "name": "sphere", "seed": 1, "temperature_k": 300,
        "view": {"zenith_deg": 0},
        "materials": [material("fine"), material("coarse"), material("floor")],
        "geometry": {"placed": {
            "prototypes": [{"name": "sphere", "file": "sphere.obj"}],
            "instances": [{"prototype": "sphere", "transform": [1,0,0,0, 0,1,0,0, 0,0,1,100]}],
            "domain": {"min_um": [-300, -300], "max_um": [300, 300], "sides": "open",
                       "floor": {"z_um": 0, "material": "floor"}}
        }}
    });
    fs::write(place.path("scene.json"), scene.to_string()).expect("written");
}

/// A record of the sphere's fall.
fn fall(place: &Place) -> Value {
    let frame = |i: i32| {
        let height = 100.0 + 500.0 * (1.0 - f64::from(i * i) / 100.0);
        json!({"time_s": 0.2 * f64::from(i), "transforms": [[1,0,0,150, 0,1,0,150, 0,0,1,height]]})
    };
    let record = json!({
        "soilsig_frames": 1, "tray_um": [300, 300], "prototypes": ["sphere"],
        "frames": (0..=10).map(frame).collect::<Vec<_>>()
    });
    fs::write(place.path("frames.json"), record.to_string()).expect("written");
    record
}

#[test]
fn a_sphere_on_a_floor_has_its_colours_and_its_shadow_where_the_sun_casts_it() {
    let place = Place::new();
    sphere_on_floor(&place);
    let picture = place.picture(&["patch", "scene.json", "--width-px", "600"]);
    assert_eq!((picture.width, picture.height), (600, 600));
    let at = |x_um: f64, y_um: f64| picture.at((300.0 + x_um) as usize, (300.0 - y_um) as usize);
    let light = |[r, g, b]: [i32; 3]| f64::from(r + g + b);
    let [r, g, b] = at(0.0, 0.0);
    assert!(r > g + 30 && g > b + 30, "amber: {r} {g} {b}");
    let [r, g, b] = at(-250.0, 250.0);
    assert!((r - b).abs() < 40 && b >= r, "grey: {r} {g} {b}");
    // The sun is at (-.55, .35, .75): the shadow's middle lies 100 um times its slope away, and it
    // reaches 87 + 132 um.
    let sunward = |um: f64| light(at(-0.8437 * um, 0.5369 * um));
    let lit = sunward(270.0);
    assert!(sunward(-150.0) < 0.75 * lit && sunward(-200.0) < 0.75 * lit, "shadow");
    assert!((sunward(-240.0) / lit - 1.0).abs() < 0.1, "beyond the shadow");
    // The sky beside the sphere is half hidden.
    let across = |um: f64| light(at(0.5369 * um, 0.8437 * um));
    assert!(across(108.0) < across(140.0) && across(140.0) < across(280.0), "ambient occlusion");
    // The sphere's sunny side is lighter than its other one.
    assert!(sunward(60.0) > 1.15 * sunward(-60.0));
}

#[test]
fn the_scale_bar_is_as_long_as_it_says() {
    let place = Place::new();
    sphere_on_floor(&place);
    for (width, pixels) in [("600", 100), ("900", 150)] {
        let picture = place.picture(&["patch", "scene.json", "--width-px", width]);
        let white = |x: &usize| picture.at(*x, picture.height - 20) == [255; 3];
        let bar = (0..picture.width).skip_while(|x| !white(x)).take_while(white).count();
        assert_eq!(bar, pixels, "100 um of 600");
    }
}

#[test]
fn a_strip_has_as_many_panels_as_asked_for_and_the_grain_sinks_from_each_to_the_next() {
    let place = Place::new();
    sphere_on_floor(&place);
    fall(&place);
    for panels in [2, 4, 7] {
        let frames = panels.to_string();
        let picture =
            place.picture(&["drop", "scene.json", "--frames", &frames, "--width-px", "900"]);
        let pitch = (picture.width + 8) / panels;
        assert_eq!(panels * pitch - 8, picture.width);
        let amber = |x: usize, y: usize| {
            let [r, g, b] = picture.at(x, y);
            r > g + 20 && g > b + 20
        };
        // The legend has amber, too: it is lower.
        let top = |panel: usize| {
            let columns = panel * pitch..(panel + 1) * pitch - 8;
            (0..picture.height - 72).find(|&y| columns.clone().any(|x| amber(x, y)))
        };
        let tops: Vec<usize> = (0..panels).map(|panel| top(panel).expect("a grain")).collect();
        assert!(tops.windows(2).all(|pair| pair[0] < pair[1]), "{tops:?}");
    }
}

#[test]
fn coverages_stand_side_by_side_at_one_scale() {
    let place = Place::new();
    sphere_on_floor(&place);
    let patch = shipped("settled_patch.json");
    let picture =
        place.picture(&["coverages", "scene.json", &patch, "scene.json", "--width-px", "608"]);
    assert_eq!(picture.width, 3 * 197 + 2 * 8);
    // The first and the third show the same; between panels the page is white.
    for y in 0..150 {
        let row = |x: usize| &picture.rgb[3 * (y * picture.width + x)..][..3 * 197];
        assert!(row(0) == row(2 * 205) && row(0) != row(205), "row {y}");
        assert_eq!(picture.at(200, y), [255; 3]);
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let place = Place::new();
    sphere_on_floor(&place);
    fall(&place);
    let patch = shipped("settled_patch.json");
    for what in [
        &["patch", &patch][..],
        &["patch", &patch, "--zenith", "60"],
        &["patch", &patch, "--zenith", "120", "--azimuth", "-10"],
        &["grain", &patch, "--prototype", "grain_853_0"],
        &["drop", "scene.json"],
        &["coverages", &patch, "scene.json", "--zenith", "30"],
    ] {
        let bytes = ["1", "5"].map(|threads| {
            place.picture(&[what, &["--threads", threads, "--width-px", "300"]].concat());
            fs::read(place.path("p.png")).expect("written")
        });
        assert!(bytes[0] == bytes[1], "{what:?}");
    }
}

#[test]
fn what_is_wrong_is_said_with_file_place_and_remedy() {
    let place = Place::new();
    let mut told = String::new();
    let mut refused = |args: &[&str], status: i32| {
        told += &place.refused(&[&["picture"], args].concat(), status);
        assert!(!place.path("p.png").exists());
    };
    sphere_on_floor(&place);
    fs::create_dir(place.path("empty")).expect("made");
    let out = ["--out", "p.png"];
    let with = |args: &[&'static str]| [args, &out].concat();
    refused(&with(&["grain", "empty"]), 3);
    refused(&with(&["patch", "gone.json"]), 3);
    refused(&with(&["coverages", "scene.json", "empty"]), 3);
    refused(&with(&["drop", "scene.json"]), 3);
    refused(&with(&["grain", "scene.json", "--prototype", "cube"]), 3);
    refused(&["patch", "scene.json", "--out", "p.jpg"], 2);
    refused(&["patch", "scene.json", "--out", "scene.json/p.png"], 1);
    refused(&with(&["drop", "scene.json", "--frames", "1"]), 2);
    refused(&with(&["patch", "scene.json", "--zenith", "181"]), 2);
    let packing = shipped("sparse.json");
    refused(&["patch", &packing, "--out", "p.png"], 3);
    let good = fall(&place);
    for (key, value) in [
        ("soilsig_frames", json!(2)),
        ("prototypes", json!(["cube"])),
        ("prototypes", json!(["sphere", "sphere"])),
        ("tray_um", json!([0, 1])),
        ("frames", json!([])),
        ("frame", json!(1)),
    ] {
        let mut wrong = good.clone();
        wrong[key] = value;
        fs::write(place.path("frames.json"), wrong.to_string()).expect("written");
        refused(&with(&["drop", "scene.json"]), 3);
    }
    assert_snapshot!(told);
}

/// Beds that real Blenders have dropped.
#[test]
fn the_recorded_drop_ends_where_the_grains_lie() {
    for blender in real_blenders() {
        let bed = SmallBed::of(&blender);
        let (record, scene) = (bed.place.json("r/frames.json"), bed.place.json("r/scene.json"));
        let frames = record["frames"].as_array().expect("frames");
        let numbers = |value: &Value| -> Vec<f64> {
            let values = value.as_array().expect("numbers").iter();
            values.map(|x| x.as_f64().expect("a number")).collect()
        };
        let rest = frames[frames.len() - 1]["transforms"].as_array().expect("places");
        let lying = scene["geometry"]["placed"]["instances"].as_array().expect("instances");
        assert_eq!(rest.len(), lying.len());
        for (a, b) in rest.iter().zip(lying) {
            for (x, y) in numbers(a).iter().zip(numbers(&b["transform"])) {
                assert!((x - y).abs() <= 0.005 + 1e-9, "{x} {y}");
            }
        }
        let times: Vec<f64> =
            frames.iter().map(|f| f["time_s"].as_f64().expect("a time")).collect();
        assert!((18..=24).contains(&times.len()) && times[0] == 0.0, "{times:?}");
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{times:?}");
        let place = Place::new();
        let run = bed.place.path("r").display().to_string();
        for what in ["grain", "drop", "coverages", "patch"] {
            let picture = place.picture(&[what, &run, "--width-px", "400"]);
            // A strip of a narrow tray is narrower.
            assert!((100..=400).contains(&picture.width), "{what}: {}", picture.width);
        }
    }
}
