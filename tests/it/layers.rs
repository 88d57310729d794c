//! Temperature by depth and by the sun, against closed forms.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use insta::assert_snapshot;
use serde_json::{Value, json};
use soilsig::products::cube::Cube;
use soilsig::radiometry::planck;
use soilsig::scene::Layers;
use soilsig::signature::{self, Band};
use soilsig::table::Table;

use crate::support::{Place, shipped_json, trace_file};

/// A scene of one mesh within open sides.
struct Case {
    obj: String,
    /// Emissivities of the materials `m0`, `m1`, ...
    emissivities: Vec<f64>,
    temperature: Value,
}

impl Case {
    fn scene(&self) -> Value {
        let of =
            |(i, e): (usize, &f64)| json!({"name": format!("m{i}"), "spectrum": {"constant": e}});
        let materials: Vec<Value> = self.emissivities.iter().enumerate().map(of).collect();
        json!({
            "soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": self.temperature,
            "view": {"zenith_deg": 0}, "materials": materials,
            "geometry": {"placed": {"prototypes": [{"name": "mesh", "file": "mesh.obj"}]}}
        })
    }

    fn trace(&self, tolerance: f64) -> Table {
        traced(&self.obj, &self.scene(), tolerance)
    }
}

fn traced(obj: &str, scene: &Value, tolerance: f64) -> Table {
    let place = Place::new();
    place.write("mesh.obj", obj);
    place.write("scene.json", scene.to_string());
    trace_file(&place.path("scene.json"), 1, tolerance)
}

fn band(table: &Table) -> Band {
    signature::evaluate(std::slice::from_ref(table), &[9.0]).expect("it holds 9 um")[0]
}

/// Checks the radiance at 9 um against a closed form, W m-2 sr-1 um-1: within three standard errors,
/// and a share of it that the form leaves out.
fn assert_radiance(table: &Table, exact: f64, left_out: f64) {
    let found = band(table).l_target;
    let error = 3.0 * found.standard_error + left_out * exact;
    assert!((found.mean - exact).abs() <= error, "{found:?}, exact {exact}");
}

fn point(depth_um: i32, kelvin: i32) -> Value {
    json!({"depth_um": depth_um, "temperature_k": kelvin})
}

fn at_9_um(kelvin: f64) -> f64 {
    planck(9.0, kelvin)
}

/// A level square at a height, seen from above.
fn square(first: usize, material: &str, [x, y, side, z]: [f64; 4]) -> String {
    let (right, far) = (x + side, y + side);
    let corners = [first, first + 1, first + 2, first + 3].map(|i| i.to_string()).join(" ");
    format!(
        "v {x} {y} {z}\nv {right} {y} {z}\nv {right} {far} {z}\nv {x} {far} {z}\n\
         usemtl {material}\nf {corners}\n"
    )
}

#[test]
fn layers_of_one_temperature_give_the_table_of_that_temperature_byte_for_byte() {
    let place = Place::new();
    let mut scene = shipped_json("settled_patch.json");
    let mut written = Vec::new();
    for temperature in [
        json!(305.0),
        json!({"depths": [{"depth_um": 0, "temperature_k": 305}]}),
        json!({
            "depths": [point(5, 305), point(90, 305)],
            "sun": {"zenith_deg": 40, "azimuth_deg": 20, "warmer_k": 0}
        }),
    ] {
        scene["temperature_k"] = temperature;
        place.write("s.json", scene.to_string());
        place.run(&["trace", "s.json", "--out", "t.json", "--paths", "5000"], 0);
        let (csv, _) = place.run(&["signature", "t.json"], 0);
        // The table names its scene by the sum of its file.
        let mut table = place.json("t.json");
        table["scene_sha256"] = Value::Null;
        written.push((table.to_string(), csv));
    }
    assert_eq!(written[0], written[1]);
    assert_eq!(written[0], written[2]);
}

/// A black ramp seen from above has as much of every depth.
#[test]
fn a_black_ramp_glows_as_the_mean_over_its_depths() {
    let ramp = "v 0 0 0\nv 500 0 -300\nv 500 400 -300\nv 0 400 0\nusemtl m0\nf 1 2 3 4\n";
    let temperature = json!({"depths": [point(0, 330), point(120, 300), point(300, 285)]});
    let case = Case { obj: ramp.into(), emissivities: vec![1.0], temperature };
    let at = |depth: f64| match depth {
        d if d < 120.0 => 330.0 - d / 4.0,
        d => 300.0 - (d - 120.0) / 12.0,
    };
    let steps = 30_000;
    let mean = (0..steps).map(|i| at_9_um(at((f64::from(i) + 0.5) / 100.0))).sum::<f64>();
    assert_radiance(&case.trace(0.0005), mean / f64::from(steps), 1e-4);
}

/// A plate above another one, of which it hides a part: by depth as by materials of their own
/// temperature, with all that they reflect of each other.
#[test]
fn depths_of_two_plates_are_two_materials_of_those_temperatures() {
    let obj =
        square(1, "m0", [100.0, 100.0, 200.0, 0.0]) + &square(5, "m1", [0.0, 0.0, 500.0, -80.0]);
    let depths = json!([point(0, 325), point(80, 290)]);
    let by_depth = Case {
        obj: obj.clone(),
        emissivities: vec![0.7, 0.4],
        temperature: json!({ "depths": depths }),
    };
    let mut scene = by_depth.scene();
    scene["temperature_k"] = 325.into();
    scene["materials"][1]["temperature_k"] = 290.into();
    let by_material = traced(&obj, &scene, 0.002);
    let by_depth = by_depth.trace(0.002);
    let [depth, material] = [&by_depth, &by_material].map(band);
    assert!((depth.l_target.mean / material.l_target.mean - 1.0).abs() < 1e-12);
    assert!((depth.emissivity.mean - material.emissivity.mean).abs() < 1e-12);
    assert!(depth.l_target.mean != by_cold(&by_depth).l_target.mean, "the plates matter");

    // A material of its own temperature has no layers.
    let mut scene = scene.clone();
    scene["temperature_k"] = json!({ "depths": depths });
    scene["materials"][0]["temperature_k"] = 300.into();
    let own = band(&traced(&obj, &scene, 0.002));
    scene["temperature_k"] = 300.into();
    let plain = band(&traced(&obj, &scene, 0.002));
    assert!((own.l_target.mean / plain.l_target.mean - 1.0).abs() < 1e-12, "{own:?} {plain:?}");
}

/// The same table, as cold as its deeper plate.
fn by_cold(table: &Table) -> Band {
    let mut table = table.clone();
    for point in &mut table.layers.as_mut().expect("layers").depths {
        point.temperature_k = 290.0;
    }
    // Layers that are alike are none: one differs beyond what counts.
    table.layers.as_mut().expect("layers").depths[0].temperature_k = 290.0 + 1e-9;
    band(&table)
}

fn sun(zenith_deg: f64, azimuth_deg: f64) -> Value {
    json!({
        "depths": [{"depth_um": 0, "temperature_k": 295}],
        "sun": {"zenith_deg": zenith_deg, "azimuth_deg": azimuth_deg, "warmer_k": 20}
    })
}

/// A black plate of side 1000 under a small one of side 100, whose shadow lies beside it: the sensor
/// above sees all of the shadow and none of what the small plate hides.
#[test]
fn a_small_plate_throws_its_shadow_on_a_large_one() {
    for azimuth_deg in [0.0, 90.0, 215.0] {
        let obj = square(1, "m0", [0.0, 0.0, 1000.0, 0.0])
            + &square(5, "m0", [450.0, 450.0, 100.0, 250.0]);
        let case = Case { obj, emissivities: vec![1.0], temperature: sun(45.0, azimuth_deg) };
        let exact = 0.99 * at_9_um(315.0) + 0.01 * at_9_um(295.0);
        assert_radiance(&case.trace(0.0002), exact, 0.0);
    }
    // A sun in the zenith throws it where it is hidden.
    let obj =
        square(1, "m0", [0.0, 0.0, 1000.0, 0.0]) + &square(5, "m0", [450.0, 450.0, 100.0, 250.0]);
    let case = Case { obj, emissivities: vec![1.0], temperature: sun(0.0, 0.0) };
    assert_radiance(&case.trace(0.0002), at_9_um(315.0), 1e-9);
}

/// Of a sphere's disc the sensor sees (1 + cos a) / 2 in the sun, as of a moon at the phase angle a.
#[test]
fn a_sphere_has_the_phases_of_a_moon() {
    let (rows, columns) = (90, 180);
    let mut obj = String::new();
    for row in 0..=rows {
        let (sin, cos) = (PI * f64::from(row) / f64::from(rows)).sin_cos();
        for column in 0..columns {
            let (y, x) = (TAU * f64::from(column) / f64::from(columns)).sin_cos();
            let _ = writeln!(obj, "v {} {} {}", 300.0 * sin * x, 300.0 * sin * y, 300.0 * cos);
        }
    }
    obj += "usemtl m0\n";
    for row in 0..rows {
        for column in 0..columns {
            let at = |row: i32, column: i32| row * columns + column % columns + 1;
            let [a, b] = [at(row, column), at(row + 1, column)];
            let [c, d] = [at(row + 1, column + 1), at(row, column + 1)];
            // At the poles a side of the quad is a point.
            let _ = match row {
                0 => writeln!(obj, "f {a} {b} {c}"),
                _ if row == rows - 1 => writeln!(obj, "f {a} {b} {d}"),
                _ => writeln!(obj, "f {a} {b} {c} {d}"),
            };
        }
    }
    for (zenith_deg, azimuth_deg) in [(30.0_f64, 0.0), (60.0, 130.0), (85.0, 300.0)] {
        let case = Case {
            obj: obj.clone(),
            emissivities: vec![1.0],
            temperature: sun(zenith_deg, azimuth_deg),
        };
        let lit = f64::midpoint(1.0, zenith_deg.to_radians().cos());
        let exact = lit * at_9_um(315.0) + (1.0 - lit) * at_9_um(295.0);
        // Facets are two degrees wide.
        assert_radiance(&case.trace(0.0005), exact, 0.002);
    }
}

#[test]
fn eq_2_is_flagged_and_what_layers_cannot_do_is_refused() {
    let place = Place::new();
    let obj =
        square(1, "m0", [0.0, 0.0, 500.0, -80.0]) + &square(5, "m0", [100.0, 100.0, 200.0, 0.0]);
    place.write("mesh.obj", &obj);
    let skin = json!({"depths": [point(0, 310), point(80, 290)]});
    let case = |temperature: Value| Case { obj: obj.clone(), emissivities: vec![0.9], temperature };
    place.write("scene.json", case(skin.clone()).scene().to_string());
    place.run(&["trace", "scene.json", "--out", "t.json", "--paths", "2000"], 0);
    let (out, _) = place.run(&["signature", "t.json", "--verbose", "--out", "s.csv"], 0);
    let mut said: String = out
        .lines()
        .filter(|line| line.contains("depth"))
        .map(|line| line.trim().to_owned() + "\n")
        .collect();
    said += &place.failed(&["signature", "t.json", "--temperature", "300"]);
    let mut refuse = |scene: &Value| {
        place.write("scene.json", scene.to_string());
        said += &place.failed(&["trace", "scene.json", "--out", "u.json", "--range", "9-9"]);
    };
    for temperature in [
        json!({"depths": []}),
        json!({"depths": [point(9, 300), point(3, 290)]}),
        json!({"depths": [point(-1, 300)]}),
        json!({"depths": [point(1, 0)]}),
        json!({"depths": [point(1, 300)], "sun": {"zenith_deg": 90, "warmer_k": 5}}),
        json!({"depths": [point(1, 300)], "sun": {"zenith_deg": 9, "warmer_k": -300}}),
        json!({"skin": 300}),
        json!("warm"),
    ] {
        refuse(&case(temperature).scene());
    }
    let mut many = case(skin.clone());
    many.emissivities = vec![0.9; 17];
    refuse(&many.scene());
    let mut glass = case(skin).scene();
    glass["materials"][0]["spectrum"] = json!({"refractive": "quartz"});
    refuse(&glass);
    assert_snapshot!(said);
    // A table whose layers are other than its paths recorded is none.
    let mut table = place.json("t.json");
    table["layers"] = Value::Null;
    place.write("t.json", table.to_string());
    let refused = place.refused(&["signature", "t.json"], 3);
    assert!(refused.contains("layers were not recorded") || refused.contains("their layers"));
}

#[test]
fn layers_are_read_as_they_were_written() {
    let read = |value: &Value| serde_json::from_value::<Layers>(value.clone()).expect("layers");
    let skin = sun(30.0, 10.0);
    assert_eq!(read(&serde_json::to_value(read(&skin)).expect("JSON")), read(&skin));
}

/// The radiance of each pixel at 9 um, line by line from above.
fn image(place: &Place, scene: &Value, pixels: &str) -> Vec<f64> {
    place.write("scene.json", scene.to_string());
    let args = ["image", "scene.json", "--out", "i", "--pixels", pixels, "--range", "9-9"];
    place.run(&[&args[..], &["--noise", "0.01"]].concat(), 0);
    let cube = Cube::read(&place.path("i/radiance.img")).expect("a cube");
    cube.data.iter().map(|l| f64::from(*l)).collect()
}

/// Black squares at four heights, side by side.
#[test]
fn each_pixel_glows_by_the_depth_and_the_sun_of_what_it_sees() {
    let place = Place::new();
    // Depths: the first point, the middle of a bin, the last point, beyond it.
    let depths = [0.0, 103.0 + 1.0 / 3.0, 200.0, 350.0];
    let squares = depths.iter().enumerate().map(|(i, depth)| {
        square(1 + 4 * i, "m0", [100.0 * (i % 2) as f64, 100.0 * (i / 2) as f64, 100.0, -depth])
    });
    place.write("mesh.obj", squares.collect::<String>());
    let points = [point(0, 330), point(200, 290)];
    let at = |depth: f64| 330.0 - 0.2 * depth.min(200.0);
    for warmer_k in [0.0, 15.0] {
        let sun = json!({"zenith_deg": 0, "warmer_k": warmer_k});
        let temperature = json!({"depths": points, "sun": sun});
        let case = Case { obj: String::new(), emissivities: vec![1.0], temperature };
        let found = image(&place, &case.scene(), "2x2");
        // The first line is the far one.
        for (l, depth) in found.iter().zip([depths[2], depths[3], depths[0], depths[1]]) {
            let exact = at_9_um(at(depth) + warmer_k);
            assert!((l / exact - 1.0).abs() < 1e-5, "depth {depth}: {l}, {exact}");
        }
    }
}

/// A plate above another one, with all that they reflect of each other, in a slanting sun.
#[test]
fn the_mean_of_an_image_in_layers_is_the_radiance_of_the_table() {
    let place = Place::new();
    let obj =
        square(1, "m0", [100.0, 100.0, 200.0, 0.0]) + &square(5, "m1", [0.0, 0.0, 500.0, -80.0]);
    place.write("mesh.obj", &obj);
    let mut temperature = sun(40.0, 30.0);
    temperature["depths"] = json!([point(0, 325), point(80, 290)]);
    let case = Case { obj, emissivities: vec![0.7, 0.4], temperature };
    let table = band(&case.trace(0.002)).l_target;
    let found = image(&place, &case.scene(), "20x20");
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    // A pixel is known to .01 in emissivity, some .01 of a black body, and the mean of 400 to .0005.
    let error = table.standard_error.hypot(0.0005 * at_9_um(325.0));
    assert!((mean - table.mean).abs() < 4.0 * error, "{mean} {table:?}");
    // The upper plate is in the sun, and reflects nothing of what is below it.
    let most = found.iter().copied().fold(0.0, f64::max);
    assert!((most / (0.7 * at_9_um(345.0)) - 1.0).abs() < 1e-5, "{most}");
}
