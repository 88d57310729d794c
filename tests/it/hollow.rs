//! A grain like a scan, with hollows, noise and a hundred thousand triangles: from its files to a
//! signature.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;

use serde_json::{Value, json};

use crate::support::{Place, real_blenders, shipped};

/// Triangles along an edge of the octahedron that the scan is drawn from.
const PARTS: i32 = 112;

/// Corners and triangles of a pebble with bites out of it, um, with so many triangles along an edge
/// of the octahedron that it is drawn from.
pub fn pebble(parts: i32) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut number = HashMap::new();
    let mut faces = Vec::new();
    let corner = |at: [i32; 3], points: &mut Vec<[f64; 3]>| {
        let length = at.map(|x| f64::from(x).powi(2)).iter().sum::<f64>().sqrt();
        let unit = at.map(|x| f64::from(x) / length);
        let noise = 1.0 + 2e-4 * f64::from((at[0] * 31 + at[1] * 17 + at[2] * 7).rem_euclid(11));
        let mut reach = 250.0 * noise;
        for bite in [[0.8, 0.6, 0.0], [-0.6, 0.0, 0.8], [0.0, -0.8, -0.6]] {
            let away: f64 = unit.iter().zip(bite).map(|(a, b)| (a - b).powi(2)).sum();
            reach *= 1.0 - 0.45 * (-away / 0.1).exp();
        }
        points.push([1.2 * reach * unit[0], reach * unit[1], 0.8 * reach * unit[2]]);
        points.len() - 1
    };
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|axis| if octant >> axis & 1 == 0 { 1 } else { -1 });
        let outward = sign.iter().product::<i32>() > 0;
        let mut add = |cells: [[i32; 2]; 3]| {
            let mut face = cells.map(|[i, j]| {
                let at = [sign[0] * i, sign[1] * j, sign[2] * (parts - i - j)];
                *number.entry(at).or_insert_with(|| corner(at, &mut points))
            });
            if !outward {
                face.swap(1, 2);
            }
            faces.push(face);
        };
        for i in 0..parts {
            for j in 0..parts - i {
                add([[i, j], [i + 1, j], [i, j + 1]]);
                if i + j < parts - 1 {
                    add([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
                }
            }
        }
    }
    (points, faces)
}

/// The .obj of a pebble with bites out of it, and its volume, um3.
fn scan() -> (String, f64) {
    let (points, faces) = pebble(PARTS);
    let mut text = String::new();
    for [x, y, z] in &points {
        let _ = writeln!(text, "v {x:.9} {y:.9} {z:.9}");
    }
    let mut volume = 0.0;
    for face in &faces {
        let [a, b, c] = face.map(|corner| glam::DVec3::from_array(points[corner]));
        volume += a.dot(b.cross(c)) / 6.0;
        let [a, b, c] = face.map(|corner| corner + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    (text, volume)
}

#[test]
fn a_scan_with_hollows_is_dusted_dropped_and_traced() {
    let place = Place::new();
    let (obj, volume) = scan();
    let diameter = (6.0 * volume / std::f64::consts::PI).cbrt();
    fs::create_dir_all(place.path("grains")).expect("made");
    fs::write(place.path("grains/scan.obj"), &obj).expect("written");
    let about = json!({"soilsig_grain": 1, "shape": "angular", "diameter_um": diameter});
    fs::write(place.path("grains/scan.json"), about.to_string()).expect("written");
    let (said, _) = place.run(&["grains", "check", "grains"], 0);
    assert!(said.contains("100352 faces"), "{said}");
    for blender in real_blenders() {
        let mut run = place.soilsig(&["pipeline", "--scene", &shipped("small.json"), "--json"]);
        run.args(["--grains", "grains", "--out", "r", "--tolerance", "0.05", "--packings", "1"]);
        run.args(["--range", "9-11", "--step", "2"]).env("SOILSIG_BLENDER", &blender);
        run.assert().success();
        let drop = fs::read_to_string(place.path("r/drop.json")).expect("written");
        let drop: Value = serde_json::from_str(&drop).expect("JSON");
        let scan = &drop["prototypes"][0];
        let filled = scan["convexity"].as_f64().expect("a number");
        assert!((0.85..0.98).contains(&filled), "{filled}");
        assert!(scan["triangles"].as_u64().expect("a count") > 100_352);
        let covered = scan["cover"]["surface"].as_f64().expect("a share");
        assert!(covered > 0.05, "{covered}");
    }
}
