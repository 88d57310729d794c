//! Synthetic scenes, and what the tool makes of them and says of them.

use std::fmt::Write as _;

use glam::DVec3;
use serde_json::{Value, json};

use super::{Point, Setting};
use crate::report::{Report, terminal};
use crate::scene::{Grid, Scene};
use crate::signature::Band;
use crate::signature::budget::Origin;
use crate::support::error::{Error, Status};
use crate::support::monitor::Monitor;
use crate::support::output::{self, OutputError};
use crate::table::Prepared;
use crate::table::{Table, Target};
use crate::tracer::trace;
use crate::tracer::trace::Request;

/// A mesh to be written as .obj.
#[derive(Default)]
pub(super) struct Shape {
    pub points: Vec<DVec3>,
    /// Corners and material of each face.
    pub faces: Vec<(Vec<usize>, &'static str)>,
    /// A normal for each point, where the surface is meant to be smooth.
    pub normals: Vec<DVec3>,
}

impl Shape {
    /// The text of a .obj file, every coordinate to the last bit.
    pub(super) fn obj(&self) -> String {
        let mut text = String::new();
        for p in &self.points {
            let _ = writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z);
        }
        for n in &self.normals {
            let _ = writeln!(text, "vn {:?} {:?} {:?}", n.x, n.y, n.z);
        }
        let mut material = "";
        for (corners, of) in &self.faces {
            if *of != material {
                let _ = writeln!(text, "usemtl {of}");
                material = of;
            }
            text += "f";
            for i in corners.iter().map(|i| i + 1) {
                let _ = if self.normals.is_empty() {
                    write!(text, " {i}")
                } else {
                    write!(text, " {i}//{i}")
                };
            }
            text += "\n";
        }
        text
    }

    /// The same as glTF, of one material, with its coordinates in a file beside it.
    pub(super) fn gltf(&self) -> Vec<(&'static str, Vec<u8>)> {
        let fans = self.faces.iter().flat_map(|(corners, _)| {
            corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]])
        });
        let corners: Vec<[f32; 3]> =
            fans.flatten().map(|i| self.points[i].as_vec3().to_array()).collect();
        let ends = |of: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..3)
                .map(|axis| corners.iter().map(|p| p[axis]).reduce(of).expect("corners"))
                .collect()
        };
        let bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let text = json!({
            "asset": {"version": "2.0"},
            "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "materials": [{"name": self.faces[0].1}],
            "accessors": [{
                "bufferView": 0, "componentType": 5126, "count": corners.len(), "type": "VEC3",
                "min": ends(f32::min), "max": ends(f32::max)
            }],
            "bufferViews": [{"buffer": 0, "byteLength": bytes.len()}],
            "buffers": [{"uri": "mesh.bin", "byteLength": bytes.len()}]
        });
        vec![("mesh.gltf", text.to_string().into_bytes()), ("mesh.bin", bytes)]
    }

    pub(super) fn face(&mut self, corners: &[usize], material: &'static str) {
        self.faces.push((corners.to_vec(), material));
    }

    /// A box with its faces outward.
    pub(super) fn block(min: DVec3, max: DVec3, material: &'static str) -> Self {
        let corner = |i: usize| {
            let pick =
                |bit: usize, axis: usize| if i >> bit & 1 == 1 { max[axis] } else { min[axis] };
            DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        };
        let mut block = Self { points: (0..8).map(corner).collect(), ..Self::default() };
        for corners in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            block.face(&corners, material);
        }
        block
    }

    /// A pit, open at the top: a box of that size without its lid, its faces inward.
    pub(super) fn pit(size: DVec3, floor: &'static str, walls: &'static str) -> Self {
        let mut pit = Self::block(DVec3::ZERO, size, walls);
        pit.faces.remove(1);
        pit.faces[0].1 = floor;
        for (corners, _) in &mut pit.faces {
            corners.reverse();
        }
        pit
    }

    /// A sphere of radius 1, an octahedron whose faces are divided so many times.
    pub(super) fn sphere(divisions: u32, material: &'static str) -> Self {
        let points = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
        let mut sphere = Self { points: points.to_vec(), ..Self::default() };
        let mut faces: Vec<[usize; 3]> = vec![
            [0, 1, 2],
            [1, 3, 2],
            [3, 4, 2],
            [4, 0, 2],
            [1, 0, 5],
            [3, 1, 5],
            [4, 3, 5],
            [0, 4, 5],
        ];
        for _ in 0..divisions {
            let mut middles = std::collections::HashMap::new();
            let mut middle = |a: usize, b: usize| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    sphere.points.push((sphere.points[a] + sphere.points[b]).normalize());
                    sphere.points.len() - 1
                })
            };
            faces = faces
                .iter()
                .flat_map(|&[a, b, c]| {
                    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        sphere.faces = faces.iter().map(|face| (face.to_vec(), material)).collect();
        sphere
    }

    /// The inside of a sphere of radius 1, open where a share of its area is cut off at the top: `around` facets
    /// around its axis and half as many along it, with the normals of the sphere.
    pub(super) fn cavity(open: f64, around: usize, material: &'static str) -> Self {
        let along = (around / 2).max(2);
        // The share of a cap is (1 - cos) / 2 of the angle at its rim.
        let rim = (1.0 - 2.0 * open).acos();
        let mut cavity = Self::default();
        for i in 0..=along {
            let polar = rim + (std::f64::consts::PI - rim) * i as f64 / along as f64;
            for j in 0..around {
                let (sin, cos) = (std::f64::consts::TAU * j as f64 / around as f64).sin_cos();
                let place = DVec3::new(polar.sin() * cos, polar.sin() * sin, polar.cos());
                cavity.points.push(place);
                cavity.normals.push(-place);
            }
        }
        for i in 0..along {
            for j in 0..around {
                let next = (j + 1) % around;
                let [a, b, c, d] = [
                    i * around + j,
                    i * around + next,
                    (i + 1) * around + next,
                    (i + 1) * around + j,
                ];
                // In two triangles: the four corners are not in one plane to the last bit.
                cavity.face(&[a, b, c], material);
                if i + 1 < along {
                    cavity.face(&[a, c, d], material);
                }
            }
        }
        // The lowest ring is one point.
        for j in 0..around {
            let bottom = cavity.points.len() - 1 - j;
            cavity.points[bottom] = -DVec3::Z;
        }
        cavity
    }
}

/// A scene under way, as it would be written by hand.
pub(super) struct Stage<'a> {
    pub scene: Value,
    pub files: Vec<(&'a str, Vec<u8>)>,
    pub grid: Grid,
    pub target: Target,
    pub monitor: &'a dyn Monitor,
}

/// What came of it.
pub(super) struct Outcome {
    pub bands: Vec<Band>,
    /// The lines that the tool prints.
    pub said: Vec<String>,
    pub status: u8,
}

/// A scene of materials with constant emissivities, around one .obj file that is the domain, at 300 K under a black sky.
pub(super) fn scene(materials: &[(&str, f64)]) -> Value {
    let materials: Vec<Value> = materials
        .iter()
        .map(|(name, emissivity)| json!({"name": name, "spectrum": {"constant": emissivity}}))
        .collect();
    json!({
        "soilsig_scene": 1, "name": "stress", "seed": 7, "temperature_k": 300,
        "view": {"zenith_deg": 0}, "materials": materials,
        "geometry": {"placed": {"prototypes": [{"name": "mesh", "file": "mesh.obj"}]}}
    })
}

/// The domain of a [`Shape::cavity`] of that radius: a square within its opening.
pub(super) fn under_the_opening(open: f64, radius_um: f64) -> Value {
    let rim = (1.0 - 2.0 * open).acos();
    let half = 0.45 * rim.sin() * radius_um;
    json!({"min_um": [-half, -half], "max_um": [half, half], "sides": "open"})
}

/// The band at 9 um alone.
pub(super) fn at_9_um() -> Grid {
    Grid::new(9.0, 9.0, 1.0).expect("a grid")
}

impl<'a> Stage<'a> {
    /// A scene around one mesh, traced at 9 um.
    pub(super) fn new(setting: &Setting<'a>, scene: Value, mesh: &Shape) -> Self {
        let files = vec![("mesh.obj", mesh.obj().into_bytes())];
        Self { scene, files, grid: at_9_um(), target: setting.target(), monitor: setting.monitor }
    }

    /// Writes the files into a folder of their own and does what `soilsig trace` and `soilsig signature` do.
    pub(super) fn run(&self) -> Result<Outcome, Error> {
        let folder = tempfile::tempdir()
            .map_err(|source| OutputError { path: std::env::temp_dir(), source })?;
        let path = folder.path().join("scene.json");
        output::bytes(&path, self.scene.to_string().as_bytes())?;
        for (name, text) in &self.files {
            output::bytes(&folder.path().join(name), text)?;
        }
        let traced = || -> Result<Table, Error> {
            let scene = Scene::read(&path)?;
            let tracer = trace::tracer(&scene)?;
            let prepared = Prepared::new(scene, &self.grid.wavelengths_um())?;
            trace::trace(&tracer, &prepared, Request::new(&self.grid, self.target), self.monitor)
        };
        let table = match traced() {
            Err(error) if error.is_interruption() => return Err(error),
            Err(error) => return Ok(Outcome::refused(&error)),
            Ok(table) => table,
        };
        Outcome::of(&[table], &self.grid, self.target)
    }
}

impl Outcome {
    /// What the tool says of tables.
    pub(super) fn of(tables: &[Table], grid: &Grid, target: Target) -> Result<Self, Error> {
        let origin = Origin::of_tables(tables.len());
        let um = grid.wavelengths_um();
        let Report { bands, reached, .. } =
            Report::new(tables, &um, origin, target.tolerance, None)?;
        let said = terminal::blocks(&[("", &reached, None)], true);
        let said = said.lines().map(|line| line.trim().to_owned()).collect();
        let is_whole = reached.tolerance_reached || target.exactly.is_some();
        let status = if is_whole { 0 } else { Status::ToleranceNotReached as u8 };
        Ok(Self { bands, said, status })
    }

    /// What it says instead of a result.
    pub(super) fn refused(error: &Error) -> Self {
        let hint = error.hint().map(|hint| format!("hint: {hint}"));
        let said = std::iter::once(format!("error: {error}")).chain(hint).collect();
        Self { bands: Vec::new(), said, status: error.status() as u8 }
    }

    /// The first line of what was said that has some words in it.
    pub(super) fn said(&self, words: &str) -> Option<String> {
        // Folders are other ones each time.
        let line = self.said.iter().find(|line| line.contains(words))?;
        Some(line.trim_start_matches("warning: ").to_owned())
    }

    /// The point of a sweep with the error of the first band's emissivity.
    pub(super) fn point(&self, x: f64, truth: f64, words: &str) -> Point {
        let e = self.bands.first().map(|band| band.emissivity);
        self.with_error(x, e.map(|e| (e.mean - truth).abs()), words)
    }

    /// The point of a sweep with an error of the first band. A refusal is said whatever its words.
    pub(super) fn with_error(&self, x: f64, error: Option<f64>, words: &str) -> Point {
        let claimed = self.bands.first().map_or(f64::NAN, |band| band.emissivity.half_width);
        let said = match error {
            Some(_) => self.said(words),
            None => self.said("error: ").map(|line| without_folders(&line)),
        };
        Point { x, error, claimed, said, status: self.status }
    }
}

/// A message without the paths of temporary folders.
fn without_folders(line: &str) -> String {
    let mut words = line.split(' ').map(|word| match word.rsplit_once('/') {
        Some((folder, name)) if folder.starts_with('/') => name,
        _ => word,
    });
    let first = words.next().unwrap_or_default().to_owned();
    words.fold(first, |text, word| text + " " + word)
}
