//! The shipped patch by an independent tracer: no tree, no instances, no table, double precision,
//! other random numbers. It reads the files itself and shares nothing with the library but
//! the scene.

use std::collections::HashMap;
use std::fs;

use std::path::Path;

use rayon::prelude::*;
use serde_json::Value;

use crate::support::{V, XorShift, along, cross, dot, shipped_path, sub, trace_file, unit};

struct Triangle {
    a: V,
    ab: V,
    ac: V,
    material: usize,
}

/// Triangles of one grain and the sphere around them, which spares most of the work.
struct Grain {
    centre: V,
    radius: f64,
    triangles: Vec<Triangle>,
}

struct Patch {
    grains: Vec<Grain>,
    min: [f64; 2],
    max: [f64; 2],
    top: f64,
    floor: (f64, usize),
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

impl Patch {
    fn read(path: &Path) -> Self {
        let scene: Value =
            serde_json::from_str(&fs::read_to_string(path).expect("the scene")).expect("JSON");
        let names: Vec<&str> = scene["materials"]
            .as_array()
            .expect("materials")
            .iter()
            .map(|m| m["name"].as_str().expect("a name"))
            .collect();
        let material = |name: &str| names.iter().position(|n| *n == name).expect("a material");
        let placed = &scene["geometry"]["placed"];
        let file = placed["prototypes"][0]["file"].as_str().expect("one file for all");
        let text = fs::read_to_string(path.with_file_name(file)).expect("the meshes");
        let mut objects: HashMap<&str, Vec<([usize; 3], usize)>> = HashMap::new();
        let (mut points, mut object, mut current) = (Vec::<V>::new(), "", 0);
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.first() {
                Some(&"v") => {
                    points.push([1, 2, 3].map(|i| words[i].parse().expect("a coordinate")));
                }
                Some(&"o") => object = words[1],
                Some(&"usemtl") => current = material(words[1]),
                Some(&"f") => {
                    assert_eq!(words.len(), 4, "triangles only");
                    let index =
                        |w: &str| w.split('/').next().unwrap().parse::<usize>().unwrap() - 1;
                    objects
                        .entry(object)
                        .or_default()
                        .push(([1, 2, 3].map(|i| index(words[i])), current));
                }
                _ => {}
            }
        }
        let grains: Vec<Grain> = placed["instances"]
            .as_array()
            .expect("instances")
            .iter()
            .map(|instance| {
                let m = numbers(&instance["transform"]);
                let place = |p: V| {
                    [0, 4, 8].map(|r| m[r] * p[0] + m[r + 1] * p[1] + m[r + 2] * p[2] + m[r + 3])
                };
                let centre = place([0.0; 3]);
                let triangles: Vec<Triangle> = objects
                    [instance["prototype"].as_str().expect("a name")]
                .iter()
                .map(|(corners, material)| {
                    let [a, b, c] = corners.map(|i| place(points[i]));
                    Triangle { a, ab: sub(b, a), ac: sub(c, a), material: *material }
                })
                .collect();
                let reach = |t: &Triangle| {
                    [t.a, along(t.a, 1.0, t.ab), along(t.a, 1.0, t.ac)]
                        .map(|p| dot(sub(p, centre), sub(p, centre)))
                        .into_iter()
                        .fold(0.0, f64::max)
                };
                let radius = triangles.iter().map(reach).fold(0.0, f64::max).sqrt() + 1.0;
                Grain { centre, radius, triangles }
            })
            .collect();
        let domain = &placed["domain"];
        assert_eq!(domain["sides"], "mirror");
        let floor = &domain["floor"];
        let top = grains.iter().map(|g| g.centre[2] + g.radius).fold(0.0, f64::max);
        Self {
            grains,
            min: numbers(&domain["min_um"]).try_into().expect("two"),
            max: numbers(&domain["max_um"]).try_into().expect("two"),
            top,
            floor: (
                floor["z_um"].as_f64().expect("a height"),
                material(floor["material"].as_str().expect("a name")),
            ),
        }
    }

    /// Distance, normal towards the ray and material of the nearest surface.
    fn hit(&self, o: V, d: V, t_max: f64) -> Option<(f64, V, usize)> {
        let mut best: Option<(f64, V, usize)> = None;
        let mut nearest = t_max;
        for grain in &self.grains {
            let to = sub(grain.centre, o);
            let closest = sub(to, d.map(|x| x * dot(to, d)));
            if dot(closest, closest) > grain.radius * grain.radius {
                continue;
            }
            for triangle in &grain.triangles {
                let p = cross(d, triangle.ac);
                let determinant = dot(triangle.ab, p);
                if determinant == 0.0 {
                    continue;
                }
                let s = sub(o, triangle.a);
                let u = dot(s, p) / determinant;
                let q = cross(s, triangle.ab);
                let v = dot(d, q) / determinant;
                let t = dot(triangle.ac, q) / determinant;
                if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-6 && t < nearest {
                    let n = unit(cross(triangle.ab, triangle.ac));
                    let n = if dot(n, d) > 0.0 { n.map(|x| -x) } else { n };
                    nearest = t;
                    best = Some((t, n, triangle.material));
                }
            }
        }
        best
    }

    /// What one path brings to the sky, for several sets of reflectances at once.
    fn path<const N: usize>(&self, random: &mut XorShift, rho: &[[f64; 3]; N]) -> [f64; N] {
        let mut weight = [1.0; N];
        let [x, y] = [0, 1].map(|i| self.min[i] + random.next() * (self.max[i] - self.min[i]));
        let mut o: V = [x, y, self.top];
        let mut d = [0.0, 0.0, -1.0];
        loop {
            // To the nearest side, the floor or the sky.
            let mut exit =
                if d[2] > 0.0 { (self.top - o[2]) / d[2] } else { (self.floor.0 - o[2]) / d[2] };
            let mut side = None;
            for i in 0..2 {
                let t = if d[i] > 0.0 {
                    (self.max[i] - o[i]) / d[i]
                } else {
                    (self.min[i] - o[i]) / d[i]
                };
                if t < exit {
                    (exit, side) = (t.max(0.0), Some(i));
                }
            }
            let (point, normal, material) = match (self.hit(o, d, exit), side) {
                (Some((t, normal, material)), _) => (along(o, t, d), normal, material),
                (None, Some(i)) => {
                    o = along(o, exit, d);
                    d[i] = -d[i];
                    continue;
                }
                (None, None) if d[2] > 0.0 => return weight,
                (None, None) => (along(o, exit, d), [0.0, 0.0, 1.0], self.floor.1),
            };
            for (w, rho) in weight.iter_mut().zip(rho) {
                *w *= rho[material];
            }
            if weight.iter().all(|w| *w < 1e-4) {
                return weight.map(|_| 0.0);
            }
            o = along(point, 1e-5, normal);
            // A point on the unit sphere about the tip of the normal: the cosine law.
            let (z, angle) = (2.0 * random.next() - 1.0, std::f64::consts::TAU * random.next());
            let r = (1.0 - z * z).sqrt();
            d = unit(along(normal, 1.0, [r * angle.cos(), r * angle.sin(), z]));
        }
    }
}

#[test]
fn the_table_of_the_shipped_patch_agrees_with_a_brute_force_tracer() {
    let path = shipped_path("settled_patch.json");
    let rho = [[0.1, 0.4, 0.1], [0.4, 0.1, 0.3], [0.6, 0.6, 0.6]];
    let patch = Patch::read(&path);
    let paths = 2400_u64;
    let weights: Vec<[f64; 3]> = (0..paths)
        .into_par_iter()
        .map(|number| {
            let mut random = XorShift((number + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
            for _ in 0..8 {
                random.next();
            }
            patch.path(&mut random, &rho)
        })
        .collect();
    let table = trace_file(&path, 1, 0.002);
    for (i, rho) in rho.iter().enumerate() {
        let n = paths as f64;
        let mean = weights.iter().map(|w| w[i]).sum::<f64>() / n;
        let variance = weights.iter().map(|w| (w[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let traced = table.weight(rho);
        let error = (variance / n).sqrt().hypot(traced.standard_error);
        assert!(error < 0.01, "the check would see nothing: {error}");
        assert!(
            (mean - traced.mean).abs() < 3.0 * error,
            "rho {rho:?}: brute force {mean}, table {}, standard error {error}",
            traced.mean
        );
    }
}
