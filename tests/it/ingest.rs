//! What is read from mesh files, and how broken ones are refused.

use insta::assert_snapshot;
use soilsig::geometry::ingest::{self, IngestError};
use soilsig::scene::Scene;
use soilsig::support::error::Failure;
use soilsig::support::file_error::FileError;

use crate::support::{area, load, message, shipped_path};

fn obj(content: &str) -> Result<soilsig::geometry::Bed, IngestError> {
    load(&[("m.obj", content.as_bytes())], r#"{"name": "m", "file": "m.obj"}"#)
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn broken_obj_files_are_refused_with_file_place_and_problem() {
    let mut told = String::new();
    for content in [
        format!("{SQUARE}v nan 0 0\nusemtl rock\nf 1 2 5\n"),
        format!("{SQUARE}usemtl rock\nf 1 2 9\n"),
        format!("{SQUARE}usemtl rock\nf 1 2 0\n"),
        format!("{SQUARE}usemtl rock\nf 1 x 3\n"),
        "v 0 0\nusemtl rock\nf 1 1 1\n".to_owned(),
        SQUARE.to_owned(),
        format!("{SQUARE}usemtl rock\nf 1 1 2\n"),
        String::new(),
    ] {
        let error = obj(&content).expect_err(&content);
        assert!(error.hint().is_some());
        told += &message(&error, error.hint());
    }
    assert_snapshot!(told);
}

#[test]
fn polygons_are_cut_into_triangles() {
    let five = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 %Y 0\nv 0 2 0\nusemtl rock\nf 1 2 3 4 5\n";
    for (y, area_of_five) in [("3", 5.0), ("0.5", 2.5)] {
        let bed = obj(&five.replace("%Y", y)).expect("a face");
        assert_eq!(bed.meshes[0].triangles.len(), 3);
        assert!((area(&bed, 1.0) - area_of_five).abs() < 1e-6, "{y}");
    }
}

#[test]
fn files_of_other_kinds_are_refused() {
    let error = load(&[("m.stl", b"solid")], r#"{"name": "m", "file": "m.stl"}"#).expect_err("no");
    assert_snapshot!(message(&error, error.hint()));
}

#[test]
fn faces_of_an_unknown_material_are_refused_with_the_names_known() {
    let unknown = obj(&format!("{SQUARE}usemtl moss\nf 1 2 3\n")).expect_err("unknown");
    let none = obj(&format!("{SQUARE}f 1 2 3\n")).expect_err("none");
    assert_snapshot!(message(&unknown, unknown.hint()) + &message(&none, none.hint()));
}

#[test]
fn a_missing_file_or_object_is_refused_with_its_name() {
    let missing = load(&[], r#"{"name": "m", "file": "gone.obj"}"#).expect_err("missing");
    assert!(matches!(missing, IngestError::File(FileError::Read { .. })));
    let content = format!("{SQUARE}o stone\nusemtl rock\nf 1 2 3\n");
    let prototype = r#"{"name": "m", "file": "m.obj", "object": "pebble"}"#;
    let other = load(&[("m.obj", content.as_bytes())], prototype).expect_err("no such object");
    let told = [message(&missing, missing.hint()), message(&other, other.hint())];
    assert_snapshot!(told.concat());
}

#[test]
fn an_obj_needs_no_mtl_file_and_keeps_its_materials_with_one() {
    for head in ["", "mtllib m.mtl\n", "mtllib gone.mtl\n"] {
        let content = format!("{head}{SQUARE}usemtl rock\nf 1 2 3 4\n");
        let bed = load(
            &[("m.obj", content.as_bytes()), ("m.mtl", b"newmtl other\nnewmtl rock\n")],
            r#"{"name": "m", "file": "m.obj"}"#,
        )
        .expect("sound");
        assert_eq!((bed.meshes[0].triangles.len(), &bed.meshes[0].materials[..]), (2, &[0, 0][..]));
    }
}

#[test]
fn units_and_the_upward_axis_are_those_of_the_scene_file() {
    let content = format!("{SQUARE}usemtl rock\nf 1 2 3 4\n");
    let prototype = r#"{"name": "m", "file": "m.obj", "unit_um": 1000, "up": "y"}"#;
    let bed = load(&[("m.obj", content.as_bytes())], prototype).expect("sound");
    // The square in x and y of the file stands upright in x and z of the scene, a millimetre high.
    let size = bed.domain.max_um - bed.domain.min_um;
    assert!((size.x - 1000.0).abs() < 1e-6 && size.y < 1e-6, "{size}");
    assert!((size.z - 1000.0).abs() < 10.0, "{size}");
}

/// Programs write groups within objects.
#[test]
fn an_object_has_all_of_its_groups() {
    let text =
        format!("{SQUARE}o A\ng first\nusemtl rock\nf 1 2 3\ng part2\nf 1 3 4\no Bx\nf 1 2 4\n");
    let files = [("m.obj", text.as_bytes())];
    let bed =
        load(&files, r#"{"name": "m", "file": "m.obj", "object": "A"}"#).expect("it is there");
    assert_eq!(bed.triangles(), 2);
    let groups = text.replace("o A\n", "").replace("o Bx", "g Bx");
    let files = [("m.obj", groups.as_bytes())];
    let bed =
        load(&files, r#"{"name": "m", "file": "m.obj", "object": "part2"}"#).expect("a group");
    assert_eq!(bed.triangles(), 1);
}

/// Four corners of a square as a strip and as a fan: two triangles that face the same way.
#[test]
fn strips_and_fans_of_gltf_are_surfaces_too() {
    for (mode, corners) in [(5, [0.0, 1.0, 2.0, 3.0]), (6, [0.0, 1.0, 3.0, 2.0])] {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0_f32]];
        let buffer: Vec<u8> = corners
            .iter()
            .flat_map(|&i: &f64| {
                let [x, y] = points[i as usize];
                [x, y, 0.0]
            })
            .flat_map(f32::to_le_bytes)
            .collect();
        let text = gltf("rock", 4)
            .replace("\"material\": 0", &format!("\"material\": 0, \"mode\": {mode}"))
            .replace("36", "48");
        let files: [(&str, &[u8]); 2] = [("m.gltf", text.as_bytes()), ("m.bin", &buffer)];
        let bed =
            load(&files, r#"{"name": "m", "file": "m.gltf", "object": "one"}"#).expect("sound");
        let mesh = &bed.meshes[0];
        let facing: Vec<glam::Vec3> = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
                (b - a).cross(c - a).normalize()
            })
            .collect();
        assert_eq!(facing.len(), 2, "{mode}");
        assert!(facing[0].dot(facing[1]) > 0.99, "{mode} {facing:?}");
    }
}

/// A glTF file of one triangle, 1 m wide and upright (y is up), whose mesh two nodes share.
fn gltf(material: &str, count: u32) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
          "nodes": [{{"name": "all", "children": [1, 2]}}, {{"name": "one", "mesh": 0}},
                    {{"name": "two", "mesh": 0, "translation": [0, 0, 2], "scale": [2, 2, 2]}}],
          "materials": [{{"name": "{material}"}}],
          "meshes": [{{"name": "tri", "primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
          "accessors": [{{"bufferView": 0, "componentType": 5126, "count": {count}, "type": "VEC3",
                          "min": [0, 0, 0], "max": [1, 1, 0]}}],
          "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
          "buffers": [{{"uri": "m.bin", "byteLength": 36}}]}}"#
    )
}

fn gltf_buffer() -> Vec<u8> {
    let floats: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    floats.iter().flat_map(|f| f.to_le_bytes()).collect()
}

#[test]
fn gltf_nodes_that_share_a_mesh_stay_instances_in_metres_with_y_up() {
    let (text, buffer) = (gltf("rock", 3), gltf_buffer());
    let files: [(&str, &[u8]); 2] = [("m.gltf", text.as_bytes()), ("m.bin", &buffer)];
    let bed = load(&files, r#"{"name": "m", "file": "m.gltf"}"#).expect("sound");
    assert_eq!((bed.meshes.len(), bed.placements.len()), (1, 2));
    let tips: Vec<f64> = bed
        .placements
        .iter()
        .map(|p| {
            let mesh = &bed.meshes[p.mesh];
            let z = |v: &glam::Vec3| p.to_scene.transform_point3(v.as_dvec3()).z;
            mesh.vertices.iter().map(z).fold(f64::MIN, f64::max)
        })
        .collect();
    assert!((tips.iter().fold(f64::MAX, |a, b| a.min(*b)) - 1e6).abs() < 1.0, "{tips:?}");
    assert!((tips.iter().fold(0.0, |a: f64, b| a.max(*b)) - 2e6).abs() < 1.0, "{tips:?}");
    let one = load(&files, r#"{"name": "m", "file": "m.gltf", "object": "one"}"#).expect("sound");
    assert_eq!(one.placements.len(), 1);
}

#[test]
fn broken_gltf_files_are_refused_with_file_and_problem() {
    let buffer = gltf_buffer();
    let mut told = String::new();
    for text in ["{}".to_owned(), gltf("moss", 3), gltf("rock", 3).replace("\"POSITION\": 0", "")] {
        let files: [(&str, &[u8]); 2] = [("m.gltf", text.as_bytes()), ("m.bin", &buffer)];
        let error = load(&files, r#"{"name": "m", "file": "m.gltf"}"#).expect_err(&text);
        told += &message(&error, error.hint());
    }
    let text = gltf("rock", 3);
    let gone = load(&[("m.gltf", text.as_bytes())], r#"{"name": "m", "file": "m.gltf"}"#);
    let gone = gone.expect_err("no buffer");
    told += &message(&gone, gone.hint());
    assert_snapshot!(told);
}

#[test]
fn a_packing_is_not_taken_for_placed_geometry() {
    let path = shipped_path("sparse.json");
    let scene = Scene::read(&path).expect("the shipped scene");
    let error = ingest::load(&scene).expect_err("a packing");
    assert_snapshot!(message(&error, error.hint()));
}
