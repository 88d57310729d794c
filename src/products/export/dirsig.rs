//! A scene as a DIRSIG bundle: meshes (.obj), instances (.odb), materials (.mat), spectra (.ems).
//!
//! Lengths are in metres. A face names its material by its ID in the .mat file.

use std::fmt::Write as _;
use std::path::Path;

use glam::{DAffine3, Vec3};

use super::{Exported, FLOOR_UM, matrix, parts};
use crate::spectrum::format;
use crate::support::error::Error;
use crate::support::output;
use crate::table::TableMaterial;

const METRE_UM: f64 = 1e6;

/// Bounces that the .mat file asks for. DIRSIG's example has 2, too few for deep pores.
const MAX_BOUNCES: u32 = 16;

pub(super) fn write(exported: &Exported, wavelengths_um: &[f64], out: &Path) -> Result<(), Error> {
    let Exported { scene, bed, materials } = exported;
    let mut mat = String::new();
    for (number, (material, of_scene)) in materials.iter().zip(&scene.materials).enumerate() {
        let id = number + 1;
        let curve = format::sampled(&material.spectrum, wavelengths_um)?;
        let curves = [(material.name.clone(), curve)];
        format::write(
            &output::within(out, &format!("material_{id}.ems"))?,
            wavelengths_um,
            &curves,
        )?;
        let temperature_k = scene.temperature_of(of_scene);
        let TableMaterial { name, specular, .. } = material;
        let _ = write!(
            mat,
            "MATERIAL_ENTRY {{
    NAME = {name}
    ID = {id}
    DOUBLE_SIDED = TRUE
    SURFACE_PROPERTIES {{
        EMISSIVITY_PROP_NAME = ClassicEmissivity
        EMISSIVITY_PROP {{
            FILENAME = material_{id}.ems
            SPECULAR_FRACTION = {specular}
        }}
    }}
    RAD_SOLVER_NAME = Generic
    RAD_SOLVER {{
        INITIAL_SAMPLE_COUNT = 100
        MAX_BOUNCES = {MAX_BOUNCES}
        SAMPLE_DECAY_RATE = 1
    }}
    TEMP_SOLVER_NAME = Fixed
    TEMP_SOLVER {{
        TEMPERATURE = {temperature_k}
    }}
}}
"
        );
    }
    let mut odb = String::from("DIRSIG_ODB = 1.0\n");
    let mut object = |file: &str, places: &mut dyn Iterator<Item = [f64; 16]>| {
        let _ = writeln!(
            odb,
            "OBJECT {{\n    OBJ_FILENAME = {file}\n    UNITS = METERS\n    INSTANCES {{"
        );
        for place in places {
            let numbers: Vec<String> = place.iter().map(ToString::to_string).collect();
            let _ = writeln!(odb, "        INFO = {}", numbers.join(", "));
        }
        odb.push_str("    }\n}\n");
    };
    for (number, mesh) in bed.meshes.iter().enumerate() {
        let file = format!("mesh_{number}.obj");
        let parts = parts(mesh, materials.len());
        output::bytes(
            &output::within(out, &file)?,
            obj_text(&mesh.name, &mesh.vertices, &parts).as_bytes(),
        )?;
        let places = bed.placements.iter().filter(|place| place.mesh == number);
        object(&file, &mut places.map(|place| matrix(&place.to_scene, METRE_UM)));
    }
    if let Some((z_um, material)) = bed.domain.floor {
        let far = FLOOR_UM as f32;
        let corners = [[-far, -far], [far, -far], [far, far], [-far, far]];
        let corners = corners.map(|[x, y]| Vec3::new(x, y, 0.0));
        let parts = [(usize::from(material), vec![[0, 1, 2], [0, 2, 3]])];
        output::bytes(
            &output::within(out, "floor.obj")?,
            obj_text("floor", &corners, &parts).as_bytes(),
        )?;
        let place = DAffine3::from_translation(glam::DVec3::new(0.0, 0.0, z_um));
        object("floor.obj", &mut std::iter::once(matrix(&place, METRE_UM)));
    }
    output::bytes(&output::within(out, "scene.mat")?, mat.as_bytes())?;
    Ok(output::bytes(&output::within(out, "scene.odb")?, odb.as_bytes())?)
}

fn obj_text(name: &str, vertices: &[Vec3], parts: &[(usize, Vec<[u32; 3]>)]) -> String {
    let mut text = format!("o {}\n", name.replace(char::is_whitespace, "_"));
    for vertex in vertices {
        let [x, y, z] = (vertex.as_dvec3() / METRE_UM).to_array();
        let _ = writeln!(text, "v {x:.12} {y:.12} {z:.12}");
    }
    for (material, triangles) in parts {
        let _ = writeln!(text, "usemtl {}", material + 1);
        for [a, b, c] in triangles.iter().map(|corners| corners.map(|corner| corner + 1)) {
            let _ = writeln!(text, "f {a} {b} {c}");
        }
    }
    text
}
