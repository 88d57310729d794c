//! A scene for Mitsuba 3: the same meshes, places and view under a sky of radiance 1.

use std::fmt::Write as _;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::{Exported, FLOOR_UM, matrix, parts};
use crate::geometry::Domain;
use crate::scene::Sides;
use crate::spectrum::kirchhoff;
use crate::support::error::Error;
use crate::support::output::{self, OutputError};
use crate::tracer::footprint::Footprint;

/// Most bounces that Mitsuba follows.
const MAX_DEPTH: u32 = 1000;

pub(super) fn write(exported: &Exported, wavelengths_um: &[f64], out: &Path) -> Result<(), Error> {
    let Exported { scene, bed, materials } = exported;
    let mut xml = String::from("<scene version=\"3.0.0\">\n");
    let _ = writeln!(
        xml,
        "  <default name=\"pixels\" value=\"256\"/>\n  <default name=\"samples\" value=\"64\"/>\n  \
         <default name=\"rr_depth\" value=\"{MAX_DEPTH}\"/>\n  \
         <integrator type=\"path\"><integer name=\"max_depth\" value=\"{MAX_DEPTH}\"/>\
         <integer name=\"rr_depth\" value=\"$rr_depth\"/></integrator>\n  \
         <emitter type=\"constant\"><rgb name=\"radiance\" value=\"1\"/></emitter>",
    );
    for (number, material) in materials.iter().enumerate() {
        let rgb = wavelengths_um
            .iter()
            .map(|&um| Ok(kirchhoff(material.spectrum.emissivity(um)?).to_string()))
            .collect::<Result<Vec<_>, Error>>()?
            .join(", ");
        let diffuse =
            format!("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"{rgb}\"/></bsdf>");
        let bsdf = if material.specular == 0.0 {
            diffuse
        } else {
            format!(
                "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"{}\"/>{diffuse}\
                 <bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/>\
                 <rgb name=\"specular_reflectance\" value=\"{rgb}\"/></bsdf></bsdf>",
                material.specular
            )
        };
        // Two hyphens would end the comment.
        let name = material.name.replace('-', "_");
        let _ = writeln!(
            xml,
            "  <!-- {name} -->\n  <bsdf type=\"twosided\" id=\"material{number}\">{bsdf}</bsdf>"
        );
    }
    for (number, mesh) in bed.meshes.iter().enumerate() {
        let _ = writeln!(xml, "  <shape type=\"shapegroup\" id=\"mesh{number}\">");
        for (material, triangles) in parts(mesh, materials.len()) {
            let file = format!("meshes/{number}_{material}.ply");
            write_ply(&mesh.vertices, &triangles, &output::within(out, &file)?)?;
            let _ = writeln!(
                xml,
                "    <shape type=\"ply\"><string name=\"filename\" value=\"{file}\"/>\
                 <boolean name=\"face_normals\" value=\"true\"/>\
                 <ref id=\"material{material}\"/></shape>"
            );
        }
        xml.push_str("  </shape>\n");
    }
    let domain = Domain { sides: Sides::Open, ..bed.domain.clone() };
    // The middle of the domain becomes the origin: Mitsuba lifts rays off facets by 9e-5 of the
    // greatest coordinate, and loses what is nearer.
    let middle = (domain.min_um + domain.max_um) / 2.0;
    let transform = |place: &DAffine3| {
        let centred = DAffine3 { translation: place.translation - middle, ..*place };
        let numbers: Vec<String> = matrix(&centred, 1.0).iter().map(ToString::to_string).collect();
        format!(
            "<transform name=\"to_world\"><matrix value=\"{}\"/></transform>",
            numbers.join(" ")
        )
    };
    for place in &bed.placements {
        let _ = writeln!(
            xml,
            "  <shape type=\"instance\"><ref id=\"mesh{}\"/>{}</shape>",
            place.mesh,
            transform(&place.to_scene)
        );
    }
    if let Some((z_um, material)) = bed.domain.floor {
        let mut place = DAffine3::from_scale(DVec3::new(FLOOR_UM, FLOOR_UM, 1.0));
        place.translation.z = z_um;
        let _ = writeln!(
            xml,
            "  <shape type=\"rectangle\"><ref id=\"material{material}\"/>{}</shape>",
            transform(&place)
        );
    }
    // The view of the domain's box, from far enough to be above everything beside it.
    let view = Footprint::new(&domain, bed.to_sensor);
    let size = domain.max_um - domain.min_um;
    let away_um = 4.0 * (size.length() + size.z) / bed.to_sensor.z.max(0.1);
    let place = DAffine3 {
        // Mitsuba's x axis points to the left of the picture.
        matrix3: DMat3::from_cols(-view.right / 2.0, view.up / 2.0, -bed.to_sensor),
        translation: middle + away_um * bed.to_sensor,
    };
    let _ = writeln!(
        xml,
        "  <!-- {}: the view of the whole domain -->\n  <sensor type=\"orthographic\">\
         <float name=\"near_clip\" value=\"{}\"/><float name=\"far_clip\" value=\"{}\"/>{}\
         <film type=\"hdrfilm\"><integer name=\"width\" value=\"$pixels\"/>\
         <integer name=\"height\" value=\"$pixels\"/><string name=\"pixel_format\" value=\"rgb\"/>\
         <string name=\"component_format\" value=\"float32\"/><rfilter type=\"box\"/></film>\
         <sampler type=\"independent\">\
         <integer name=\"sample_count\" value=\"$samples\"/></sampler>\
         </sensor>\n</scene>",
        scene.name.replace('-', "_"),
        away_um * 1e-6,
        away_um * 100.0,
        transform(&place)
    );
    Ok(output::bytes(&output::within(out, "scene.xml")?, xml.as_bytes())?)
}

/// Writes triangles of a mesh in single precision.
fn write_ply(vertices: &[Vec3], triangles: &[[u32; 3]], path: &Path) -> Result<(), OutputError> {
    output::file(path, |out| {
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
             property float y\nproperty float z\nelement face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            vertices.len(),
            triangles.len()
        )?;
        for vertex in vertices {
            for x in vertex.to_array() {
                out.write_all(&x.to_le_bytes())?;
            }
        }
        for triangle in triangles {
            out.write_all(&[3])?;
            for corner in triangle {
                out.write_all(&corner.to_le_bytes())?;
            }
        }
        Ok(())
    })
}
