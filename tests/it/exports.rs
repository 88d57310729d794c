//! Scenes for other programs, and back.

use std::fs;
use std::path::Path;

use glam::{DMat3, DVec3};
use insta::assert_snapshot;
use serde_json::json;
use soilsig::geometry::Domain;
use soilsig::products::export::{self, To};
use soilsig::scene::{Grid, Scene, SpectrumSource};
use soilsig::signature;
use soilsig::support::error::Failure;
use soilsig::support::monitor::Unwatched;
use soilsig::table::{Prepared, Target};
use soilsig::tracer::trace::{self, Request};

use crate::support::{message, shipped_json, shipped_path};

fn emissivities(path: &Path, grid: &Grid) -> Vec<(f64, f64)> {
    let scene = Scene::read(path).expect("the scene is sound");
    let tracer = trace::tracer(&scene).expect("its meshes are sound");
    let target = Target::of(0.004);
    let table = trace::trace(
        &tracer,
        &Prepared::new(scene.clone(), &grid.wavelengths_um()).expect("spectra"),
        Request::new(grid, target),
        &Unwatched,
    )
    .expect("traced");
    let bands = signature::evaluate(&[table], &grid.wavelengths_um()).expect("bands");
    bands.iter().map(|band| (band.emissivity.mean, band.emissivity.half_width)).collect()
}

#[test]
fn a_scene_comes_back_from_dirsigs_files_with_the_same_emissivity() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut json = shipped_json("settled_patch.json");
    json["geometry"]["placed"]["domain"]["sides"] = "open".into();
    json["materials"][1]["temperature_k"] = json!(310.0);
    let original = folder.path().join("original.json");
    fs::write(&original, json.to_string()).expect("written");
    let scene = Scene::read(&original).expect("a scene");
    let bundle = folder.path().join("bundle");
    let grid = Grid::new(8.0, 12.0, 0.1).expect("a grid");
    let lost =
        export::export(&scene, To::Dirsig, &grid.wavelengths_um(), &bundle).expect("written");
    assert_snapshot!(lost.join("\n"));
    let (imported, _) =
        export::import(&bundle.join("scene.odb"), &bundle.join("scene.mat"), &bundle)
            .expect("read");
    let temperatures: Vec<f64> =
        imported.materials.iter().map(|m| imported.temperature_of(m)).collect();
    assert_eq!(temperatures, [300.0, 310.0, 300.0]);
    let ems = |m: &soilsig::scene::Material| matches!(&m.spectrum, SpectrumSource::File(f) if f.is_relative());
    assert!(imported.materials.iter().all(ems), "files beside the scene are named so");
    // DIRSIG's files have no domain: it is that of the original.
    let mut back = serde_json::to_value(&imported).expect("plain data");
    let mut domain = json["geometry"]["placed"]["domain"].clone();
    domain.as_object_mut().expect("an object").remove("floor");
    back["geometry"]["placed"]["domain"] = domain;
    let path = bundle.join("back.json");
    fs::write(&path, back.to_string()).expect("written");
    for (a, b) in emissivities(&original, &grid).iter().zip(emissivities(&path, &grid)) {
        assert!((a.0 - b.0).abs() < 1.5 * a.1.hypot(b.1), "{a:?} {b:?}");
    }
}

/// A DIRSIG file of grey curves.
fn ems(emissivities: &[f64]) -> String {
    let curve = |e: &f64| format!("CURVE_BEGIN\n0.4 {e}\n20 {e}\n");
    let curves: String = emissivities.iter().map(curve).collect();
    format!("{}\n{}{curves}", emissivities.len(), "1.0\n".repeat(91))
}

/// Names with a #, comments behind values, objects and instances of other kinds, several curves.
#[test]
fn dirsigs_files_are_read_as_they_come_and_what_is_left_out_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    let put = |name: &str, text: &str| fs::write(at(name), text).expect("written");
    put("pit.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl Class #3\nf 1 2 3\n");
    put("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    put("soil.ems", &ems(&[0.45, 0.5, 0.55]));
    put("other.ems", &ems(&[0.9]));
    let entry = |name: &str, file: &str| {
        format!(
            "# a material\nMATERIAL_ENTRY {{ # begins\n NAME = {name}\n ID = {}\n \
             SURFACE_PROPERTIES {{\n  EMISSIVITY_PROP {{\n   FILENAME = {file}\n   \
             SPECULAR_FRACTION = 0.25 # a quarter\n  }}\n }}\n TEMP_SOLVER {{\n  \
             TEMPERATURE = 310 # K\n }}\n}} # ends\n",
            70 + name.len()
        )
    };
    put("a.mat", &(entry("Class #2", "other.ems") + &entry("Class #3", "soil.ems # mean")));
    let object = |file: &str, places: &str| {
        format!("OBJECT {{\n {file}\n UNITS = METERS # m\n INSTANCES {{\n{places} }}\n}}\n")
    };
    let place = "  INFO = 0, 0, 0, 1, 1, 1, 0, 0, 0 # here\n";
    let pit = object("OBJ_FILENAME = pit.obj", &format!("{place}  INFO = pit.mov\n"));
    let head = "DIRSIG_ODB = 1.0\n\n# one pit\n";
    put("a.odb", &(head.to_owned() + &object("GDB_FILENAME = tree.gdb", place) + &pit));
    let import = || export::import(&at("a.odb"), &at("a.mat"), folder.path());
    let (scene, left_out) = import().expect("read");
    let [material] = &scene.materials[..] else { panic!("{:?}", scene.materials) };
    assert_eq!((&*material.name, material.specular), ("Class #3", Some(0.25)));
    assert_eq!(scene.temperature_of(material), 310.0);
    assert_eq!(material.spectrum, SpectrumSource::File("soil.ems".into()));
    let mut told = left_out.join("\n") + "\n\n";
    let mut refused = || {
        let error = import().expect_err("it will not do");
        told += &message(&error, error.hint());
    };
    fs::remove_file(at("soil.ems")).expect("removed");
    refused();
    put("soil.ems", &ems(&[0.5]));
    put("a.odb", &(head.to_owned() + &object("OBJ_FILENAME = plain.obj", place)));
    refused();
    put("a.odb", &(head.to_owned() + &object("OBJ_FILENAME = pit.obj", "  INFO = pit.mov\n")));
    refused();
    // A scene that could not be read again is not written.
    put("a.odb", &(head.to_owned() + &object("OBJ_FILENAME = pit.obj", place)));
    let cold = entry("Class #3", "soil.ems").replace("310", "-3");
    put("a.mat", &cold);
    refused();
    put("a.mat", &entry("Class #3", "soil.ems"));
    put("pit.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl Class #3\nf 1 3 2\n");
    refused();
    assert_snapshot!(told);
    // Braces below their names, quoted names, units in small letters; an ID that is there twice.
    put("pit.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl Class #3\nf 1 2 3\n");
    let odb = head.to_owned() + &object("OBJ_FILENAME = \"pit.obj\"", place);
    put("a.odb", &odb.replace(" {\n", "\n{\n").replace("METERS", "kilometers"));
    let twice = entry("Class #3", "soil.ems");
    put("a.mat", &(twice.clone() + &twice.replace("310", "320")));
    let (scene, left_out) = import().expect("read");
    assert_eq!(scene.temperature_of(&scene.materials[0]), 310.0);
    assert_eq!(scene.placed().expect("placed").prototypes[0].unit_um, Some(1e9));
    assert!(left_out.iter().any(|text| text.contains("the ID of material")), "{left_out:?}");
}

/// Materials whose names are numbers: another's name is no ID.
#[test]
fn faces_keep_their_materials_whatever_these_are_called() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl 1\nf 1 2 3\n").expect("written");
    let entry = |name: &str, id: &str, file: &str| {
        format!("MATERIAL_ENTRY {{\n NAME = {name}\n ID = {id}\n EMISSIVITY_FILE = {file}\n}}\n")
    };
    let list = entry("1", "2", "two.ems") + &entry("other", "1", "one.ems");
    fs::write(at("a.mat"), list).expect("written");
    for file in ["one.ems", "two.ems"] {
        fs::write(at(file), ems(&[0.5])).expect("written");
    }
    let object = |places: &str| {
        format!("DIRSIG_ODB = 1.0\nOBJECT {{\n OBJ_FILENAME = a.obj\n UNITS = METERS\n{places}}}\n")
    };
    let places = " INSTANCES {\n  INFO = 0 0 0 1 1 1 0 0 0\n }\n";
    fs::write(at("a.odb"), object(places)).expect("written");
    let import = || export::import(&at("a.odb"), &at("a.mat"), folder.path());
    let (scene, _) = import().expect("read");
    let of_one =
        |file: &SpectrumSource| matches!(file, SpectrumSource::File(f) if f.ends_with("one.ems"));
    assert!(of_one(&scene.materials[0].spectrum), "{:?}", scene.materials);
    fs::write(at("a.odb"), object("")).expect("written");
    let error = import().expect_err("nothing stands anywhere");
    assert_snapshot!(message(&error, error.hint()));
}

/// Mitsuba looks along z with x to the left: what turns its axes into the scene's is no mirror. And
/// it is least exact far from the origin: the domain's middle stands there.
#[test]
fn mitsubas_picture_is_not_mirrored_and_its_scene_is_about_the_origin() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = shipped_path("settled_patch.json");
    let scene = Scene::read(&path).expect("a scene");
    export::export(&scene, To::Mitsuba, &[8.0, 9.0, 10.0], folder.path()).expect("written");
    let xml = fs::read_to_string(folder.path().join("scene.xml")).expect("written");
    let matrix = |of: &str| -> Vec<f64> {
        let (_, after) = xml.split_once(of).expect("it is there");
        let (_, matrix) = after.split_once("matrix value=\"").expect("its place");
        let numbers = matrix[..matrix.find('"').expect("its end")].split_whitespace();
        numbers.map(|x| x.parse().expect("a number")).collect()
    };
    let sensor = matrix("<sensor");
    let row = |i: usize| DVec3::from_slice(&sensor[4 * i..4 * i + 3]);
    let axes = DMat3::from_cols(row(0), row(1), row(2)).transpose();
    assert!(axes.determinant() > 0.0, "{axes}");
    // Seen from above the picture's right is where x grows.
    assert!(axes.x_axis.x < 0.0 && axes.y_axis.y > 0.0 && axes.z_axis.z < 0.0, "{axes}");
    assert!(sensor[3].abs() < 1e-9 && sensor[7].abs() < 1e-9, "above the middle");
    let tracer = trace::tracer(&scene).expect("its meshes");
    let Domain { min_um, max_um, .. } = tracer.bed().domain;
    let first = matrix("<shape type=\"instance\"");
    let from_middle = tracer.bed().placements[0].to_scene.translation - (min_um + max_um) / 2.0;
    assert!((DVec3::new(first[3], first[7], first[11]) - from_middle).length() < 1e-9);
}

#[test]
fn what_is_wrong_in_dirsigs_files_is_named_with_its_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [odb, mat] = ["a.odb", "a.mat"].map(|name| folder.path().join(name));
    fs::write(folder.path().join("a.obj"), "usemtl x\n").expect("written");
    let material = "MATERIAL_ENTRY {\n ID = x\n EMISSIVITY_FILE = x.ems\n}\n";
    let object =
        "OBJECT {\n OBJ_FILENAME = a.obj\n UNITS = METERS\n INSTANCES {\n  INFO = 1 2 3\n }\n}\n";
    let cases = [
        ("OBJECT {\n", material),
        ("DIRSIG_ODB = 1.0\nOBJECT {\n GDB_FILENAME = a.gdb\n}\n", material),
        (&format!("DIRSIG_ODB = 1.0\n{object}"), material),
        (&format!("DIRSIG_ODB = 1.0\n{}", object.replace("METERS", "LEAGUES")), material),
        (
            &format!("DIRSIG_ODB = 1.0\n{}", object.replace("1 2 3", "0 0 0 1 1 1 0 0 0")),
            "MATERIAL_ENTRY {\n ID = y\n}\n",
        ),
    ];
    let mut told = String::new();
    for (objects, materials) in cases {
        fs::write(&odb, objects).expect("written");
        fs::write(&mat, materials).expect("written");
        let error = export::import(&odb, &mat, folder.path()).expect_err(objects);
        told += &message(&error, error.hint());
    }
    assert_snapshot!(told);
}
