//! Meshes that are made for the sweeps.

use std::collections::HashMap;
use std::fmt::Write as _;

use glam::DVec3;
use serde_json::json;

/// A mesh.
#[derive(Default)]
pub(super) struct Shape {
    pub points: Vec<DVec3>,
    /// Corners and material of each face.
    pub faces: Vec<(Vec<usize>, &'static str)>,
    /// A normal for each point of a smooth surface; else empty.
    normals: Vec<DVec3>,
}

impl Shape {
    /// The text of an .obj file, with all digits of the coordinates.
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

    /// A glTF file of one material and the file of its coordinates.
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

    /// The mesh with all coordinates multiplied.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.points.iter_mut().for_each(|point| *point *= factor);
        self
    }

    /// A horizontal square that faces up, from one corner and with that side.
    pub(super) fn plate(min: f64, side: f64, material: &'static str) -> Self {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let points = corners.map(|p| side * p + min).to_vec();
        Self { points, faces: vec![(vec![0, 1, 2, 3], material)], normals: Vec::new() }
    }

    /// A profile in x and z, from left to right and facing up, drawn along y.
    pub(super) fn drawn(profile: &[(f64, f64)], y: [f64; 2], material: &'static str) -> Self {
        let end = |y| profile.iter().map(move |&(x, z)| DVec3::new(x, y, z));
        let points = y.into_iter().flat_map(end).collect();
        let n = profile.len();
        let faces = (1..n).map(|i| (vec![i - 1, i, i + n, i + n - 1], material)).collect();
        Self { points, faces, normals: Vec::new() }
    }

    /// A slab with a groove from x = 0, drawn along y.
    pub(super) fn groove(width: f64, depth: f64, [from, to]: [f64; 2], y: [f64; 2]) -> Self {
        let profile =
            [(from, 0.0), (0.0, 0.0), (0.0, -depth), (width, -depth), (width, 0.0), (to, 0.0)];
        Self::drawn(&profile, y, "rock")
    }

    /// A box whose faces point outward.
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

    /// A pit: a box without its lid, whose faces point inward.
    pub(super) fn pit(size: DVec3, floor: &'static str, walls: &'static str) -> Self {
        let mut pit = Self::block(DVec3::ZERO, size, walls);
        pit.faces.remove(1);
        pit.faces[0].1 = floor;
        for (corners, _) in &mut pit.faces {
            corners.reverse();
        }
        pit
    }

    /// A sphere of radius 1: an octahedron whose faces are divided repeatedly.
    pub(super) fn sphere(divisions: u32, material: &'static str) -> Self {
        let points = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
        let mut sphere = Self { points: points.to_vec(), ..Self::default() };
        let sides = [[0, 1], [1, 3], [3, 4], [4, 0]];
        let above = sides.map(|[a, b]| [a, b, 2]);
        let mut faces: Vec<[usize; 3]> = [above, sides.map(|[a, b]| [b, a, 5])].concat();
        for _ in 0..divisions {
            let mut middles = HashMap::new();
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

    /// The inside of a sphere of radius 1 without a cap at the top, which has the share `open` of
    /// the area. It has `around` facets around its axis, half as many along it, and the sphere's
    /// normals.
    pub(super) fn cavity(open: f64, around: usize, material: &'static str) -> Self {
        let along = (around / 2).max(2);
        let rim = rim(open);
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
        let at = |i: usize, j: usize| i * around + j % around;
        for (i, j) in (0..along).flat_map(|i| (0..around).map(move |j| (i, j))) {
            // Two triangles: rounding moves the four corners out of one plane.
            cavity.face(&[at(i, j), at(i, j + 1), at(i + 1, j + 1)], material);
            if i + 1 < along {
                cavity.face(&[at(i, j), at(i + 1, j + 1), at(i + 1, j)], material);
            }
        }
        // The lowest ring is one point.
        cavity.points[along * around..].fill(-DVec3::Z);
        cavity
    }
}

/// The polar angle at the rim of a cavity's opening: a cap has the share (1 - cos) / 2 of the area.
fn rim(open: f64) -> f64 {
    (1.0 - 2.0 * open).acos()
}

/// Half the side of a square within the opening of a cavity of radius 1.
pub(super) fn within_opening(open: f64) -> f64 {
    0.45 * rim(open).sin()
}
