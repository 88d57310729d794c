//! The bed's emissivity towards the sensor against what a forward tracer finds that it reflects
//! there: light falls from all of the sky, by the cosine law, and at every hit what goes straight
//! to the sensor is added up (Kirchhoff, Helmholtz).
//!
//! The forward tracer shares nothing with the library but the scene: it tests every triangle and
//! has its own numbers.

use std::fmt::Write as _;
use std::fs;

use serde_json::json;

use crate::support::{V, XorShift, along, cross, dot, sub, trace_file, unit};

/// Side of the square domain, um, whose sides are mirrors.
const SIDE: f64 = 100.0;
const TOP: f64 = 60.0;
const PHOTONS: u64 = 400_000;
/// Reflectance of the pyramids and of the ground.
const RHO: [f64; 2] = [0.8, 0.5];

/// Steep pyramids, one leaning over, that throw light at each other.
fn triangles() -> Vec<[V; 3]> {
    let pyramid = |x: f64, y: f64, half: f64, tip: V| {
        let base = [
            [x - half, y - half, 0.0],
            [x + half, y - half, 0.0],
            [x + half, y + half, 0.0],
            [x - half, y + half, 0.0],
        ];
        (0..4).map(move |i| [base[i], base[(i + 1) % 4], tip])
    };
    pyramid(30.0, 30.0, 22.0, [30.0, 30.0, 55.0])
        .chain(pyramid(70.0, 65.0, 18.0, [98.0, 72.0, 50.0]))
        .chain(pyramid(25.0, 75.0, 15.0, [20.0, 70.0, 35.0]))
        .collect()
}

/// Distance, normal towards the ray and reflectance of the nearest triangle.
fn hit(triangles: &[[V; 3]], o: V, d: V, t_max: f64) -> Option<(f64, V)> {
    let mut best = None;
    let mut nearest = t_max;
    for [a, b, c] in triangles {
        let (ab, ac) = (sub(*b, *a), sub(*c, *a));
        let p = cross(d, ac);
        let determinant = dot(ab, p);
        if determinant == 0.0 {
            continue;
        }
        let s = sub(o, *a);
        let u = dot(s, p) / determinant;
        let q = cross(s, ab);
        let (v, t) = (dot(d, q) / determinant, dot(ac, q) / determinant);
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-7 && t < nearest {
            let n = unit(cross(ab, ac));
            nearest = t;
            best = Some((t, if dot(n, d) > 0.0 { n.map(|x| -x) } else { n }));
        }
    }
    best
}

fn cosine(n: V, random: &mut XorShift) -> V {
    let (z, angle) = (2.0 * random.next() - 1.0, std::f64::consts::TAU * random.next());
    let r = (1.0 - z * z).sqrt();
    unit(along(n, 1.0, [r * angle.cos(), r * angle.sin(), z]))
}

/// What one photon sends straight up, as a share of the radiance of a white horizontal plane.
fn photon(triangles: &[[V; 3]], random: &mut XorShift) -> f64 {
    let mut o = [SIDE * random.next(), SIDE * random.next(), TOP];
    let mut d = cosine([0.0, 0.0, -1.0], random);
    let (mut weight, mut sum) = (1.0, 0.0);
    loop {
        // To the nearest side, the ground or the sky.
        let mut exit = if d[2] > 0.0 { (TOP - o[2]) / d[2] } else { -o[2] / d[2] };
        let mut side = None;
        for i in 0..2 {
            let t = if d[i] > 0.0 { (SIDE - o[i]) / d[i] } else { -o[i] / d[i] };
            if t < exit {
                (exit, side) = (t.max(0.0), Some(i));
            }
        }
        let (point, normal, rho) = match (hit(triangles, o, d, exit), side) {
            (Some((t, normal)), _) => (along(o, t, d), normal, RHO[0]),
            (None, Some(i)) => {
                o = along(o, exit, d);
                o[i] = if d[i] > 0.0 { SIDE } else { 0.0 };
                d[i] = -d[i];
                continue;
            }
            (None, None) if d[2] > 0.0 => return sum,
            (None, None) => (along(o, exit, d), [0.0, 0.0, 1.0], RHO[1]),
        };
        weight *= rho;
        o = along(point, 1e-6, normal);
        let up = [0.0, 0.0, 1.0];
        if normal[2] > 0.0 && hit(triangles, o, up, 2.0 * TOP).is_none() {
            sum += weight * normal[2];
        }
        if weight < 1e-6 {
            return sum;
        }
        d = cosine(normal, random);
    }
}

#[test]
fn the_emissivity_is_one_less_what_forward_light_sends_to_the_sensor() {
    let triangles = triangles();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut obj = String::new();
    for corners in &triangles {
        for [x, y, z] in corners {
            let _ = writeln!(obj, "v {x} {y} {z}");
        }
        obj += "f -3 -2 -1\n";
    }
    fs::write(folder.path().join("pyramids.obj"), obj).expect("written");
    let scene = json!({
        "soilsig_scene": 1, "name": "pyramids", "seed": 1, "temperature_k": 300.0,
        "view": {"zenith_deg": 0.0},
        "materials": [
            {"name": "pyramid", "spectrum": {"constant": 1.0 - RHO[0]}},
            {"name": "ground", "spectrum": {"constant": 1.0 - RHO[1]}},
        ],
        "geometry": {"placed": {
            "prototypes": [{"name": "pyramids", "file": "pyramids.obj", "material": "pyramid"}],
            "domain": {"min_um": [0.0, 0.0], "max_um": [SIDE, SIDE], "sides": "mirror",
                       "floor": {"z_um": 0.0, "material": "ground"}},
        }},
    });
    let path = folder.path().join("scene.json");
    fs::write(&path, scene.to_string()).expect("written");
    let table = trace_file(&path, 1, 0.001);
    let backward = table.weight(&RHO);

    let mut random = XorShift(0x9e37_79b9_7f4a_7c15);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..PHOTONS {
        let brought = photon(&triangles, &mut random);
        sum += brought;
        squares += brought * brought;
    }
    let n = PHOTONS as f64;
    let forward = sum / n;
    let error = ((squares / n - forward * forward) / n).sqrt().hypot(backward.standard_error);
    println!("forward {forward}, backward {}, standard error {error}", backward.mean);
    assert!(error < 2e-3, "the check would see nothing: {error}");
    // A flat bed of these materials would reflect .62.
    assert!(forward < 0.57 && forward > 0.45);
    assert!(
        (forward - backward.mean).abs() < 3.0 * error + backward.trapped,
        "forward {forward}, backward {}, standard error {error}",
        backward.mean
    );
}
