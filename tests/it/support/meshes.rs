//! Mesh files made in a test, and the facets that are read from them.

use std::fs;
use std::path::Path;

use soilsig::geometry::Bed;
use soilsig::geometry::ingest::{self, IngestError};
use soilsig::scene::Scene;

/// A scene of one prototype and the material `rock`.
pub fn scene_of(prototype: &str) -> String {
    format!(
        r#"{{"soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300,
             "view": {{"zenith_deg": 0}},
             "materials": [{{"name": "rock", "spectrum": {{"constant": 0.5}}}}],
             "geometry": {{"placed": {{"prototypes": [{prototype}]}}}}}}"#
    )
}

/// The bed of a prototype that is read from these files.
pub fn load(files: &[(&str, &[u8])], prototype: &str) -> Result<Bed, IngestError> {
    load_scene(files, &scene_of(prototype))
}

/// The bed of a scene that is read from these files.
pub fn load_scene(files: &[(&str, &[u8])], scene: &str) -> Result<Bed, IngestError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, content) in files {
        fs::write(folder.path().join(name), content).expect("written");
    }
    load_from(folder.path(), scene)
}

/// The bed of a scene whose files lie in a folder.
pub fn load_from(folder: &Path, scene: &str) -> Result<Bed, IngestError> {
    let scene = Scene::parse(scene, &folder.join("scene.json")).expect("the scene is sound");
    ingest::load(&scene)
}

/// The corners of every triangle as placed, in thousandths of a unit, in an order that depends on
/// the surface alone. Each triangle begins with its least corner and keeps its turn.
pub fn facets(bed: &Bed, unit_um: f64) -> Vec<[[i64; 3]; 3]> {
    let mut facets: Vec<_> = bed
        .placements
        .iter()
        .flat_map(|place| {
            let mesh = &bed.meshes[place.mesh];
            mesh.triangles.iter().map(move |triangle| {
                let mut corners = triangle.map(|i| {
                    let corner = mesh.vertices[i as usize].as_dvec3();
                    let corner = place.to_scene.transform_point3(corner) / unit_um * 1e3;
                    corner.to_array().map(|x| x.round() as i64)
                });
                let least = (0..3).min_by_key(|&i| corners[i]).expect("three corners");
                corners.rotate_left(least);
                corners
            })
        })
        .collect();
    facets.sort_unstable();
    facets
}

/// The area of all facets, in square units.
pub fn area(bed: &Bed, unit_um: f64) -> f64 {
    let area = |[a, b, c]: [[i64; 3]; 3]| {
        let [a, b, c] = [a, b, c].map(|p| glam::DVec3::from_array(p.map(|x| x as f64 / 1e3)));
        (b - a).cross(c - a).length() / 2.0
    };
    facets(bed, unit_um).into_iter().map(area).sum()
}

/// A pit as deep as it is wide, open at the top: a unit cube's floor and walls.
pub const PIT_CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

/// Its faces, as numbers of corners.
pub const PIT_FACES: [[usize; 4]; 5] =
    [[0, 1, 2, 3], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]];

/// Its vertices and faces as lines of a .obj file.
pub fn pit_lines() -> Vec<String> {
    let vertices = PIT_CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}"));
    let faces = PIT_FACES.iter().map(|face| {
        let [a, b, c, d] = face.map(|i| i + 1);
        format!("f {a} {b} {c} {d}")
    });
    vertices.chain(["usemtl rock".to_owned()]).chain(faces).collect()
}
