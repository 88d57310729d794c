//! glTF 2.0, text or binary, through the gltf crate; nodes that share a mesh stay instances.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DMat4, DVec3, Mat4, Vec3};
use gltf::mesh::Mode;

use super::{IngestError, Materials};
use crate::geometry::{HALF_A_PLACE, Mesh, turned_away};

/// Files beside a glTF file that hold its buffers.
pub(super) fn buffer_files(path: &Path) -> Result<Vec<PathBuf>, IngestError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = open(path)?;
    let outside = file.document.buffers().filter_map(|buffer| match buffer.source() {
        gltf::buffer::Source::Uri(uri) if !uri.starts_with("data:") => Some(folder.join(uri)),
        _ => None,
    });
    Ok(outside.collect())
}

fn open(path: &Path) -> Result<gltf::Gltf, IngestError> {
    let bytes = std::fs::read(path)
        .map_err(|source| IngestError::Read { path: path.to_owned(), source })?;
    gltf::Gltf::from_slice(&bytes).map_err(|error| IngestError::Broken {
        path: path.to_owned(),
        place: "the file".into(),
        problem: error.to_string(),
    })
}

/// The meshes below the named node, or of the whole default scene, each with its places.
pub(super) fn read(
    path: &Path,
    object: Option<&str>,
    unit_um: f64,
    turn: DMat3,
    materials: &Materials,
) -> Result<Vec<(Mesh, Vec<DAffine3>)>, IngestError> {
    let broken = |place: &str, problem: String| IngestError::Broken {
        path: path.to_owned(),
        place: place.to_owned(),
        problem,
    };
    let file = open(path)?;
    let buffers = gltf::import_buffers(&file.document, path.parent(), file.blob)
        .map_err(|e| broken("its buffers", e.to_string()))?;
    let document = file.document;
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next())
        .ok_or_else(|| broken("the file", "it has no scene".into()))?;

    // Walk the tree once; a node counts if it or one above it has the name wanted.
    let mut places: BTreeMap<usize, Vec<DAffine3>> = BTreeMap::new();
    let mut names = Vec::new();
    let mut waiting: Vec<_> =
        scene.nodes().map(|node| (node, DMat4::IDENTITY, object.is_none())).collect();
    while let Some((node, above, inside)) = waiting.pop() {
        let place = above * Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4();
        names.extend(node.name().map(str::to_owned));
        let inside = inside || node.name() == object;
        if let (Some(mesh), true) = (node.mesh(), inside) {
            places.entry(mesh.index()).or_default().push(DAffine3::from_mat4(place));
        }
        waiting.extend(node.children().map(|child| (child, place, inside)));
    }
    if let (Some(object), true) = (object, places.is_empty()) {
        names.sort_unstable();
        names.dedup();
        return Err(IngestError::NoObject {
            path: path.to_owned(),
            object: object.to_owned(),
            present: names,
        });
    }

    let mut parts = Vec::new();
    for (index, places) in places {
        let mesh = document.meshes().nth(index).expect("the node refers to it");
        let name = mesh.name().map_or_else(|| format!("mesh {index}"), str::to_owned);
        let (mut points, mut faces) = (Vec::new(), Vec::new());
        let mut away = (0.0, 0.0);
        for primitive in mesh.primitives() {
            // Points and lines have no surface.
            let mode = primitive.mode();
            if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                continue;
            }
            let material = materials.index(path, &name, primitive.material().name())?;
            let first = points.len() as u32;
            let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|b| &b.0[..]));
            let positions = reader
                .read_positions()
                .ok_or_else(|| broken(&name, "it has no vertex positions".into()))?;
            for position in positions {
                let point = DVec3::from_array(position.map(f64::from)) * unit_um;
                if !point.is_finite() {
                    return Err(broken(&name, "a vertex is not finite".into()));
                }
                points.push(point);
            }
            let count = points.len() as u32 - first;
            let indices: Vec<u32> = reader
                .read_indices()
                .map_or_else(|| (0..count).collect(), |indices| indices.into_u32().collect());
            if let Some(wrong) = indices.iter().find(|&&i| i >= count) {
                return Err(broken(
                    &name,
                    format!("a face wants vertex {wrong}, and there are {count}"),
                ));
            }
            let indices = triangles(mode, indices);
            let normals: Vec<DVec3> = reader
                .read_normals()
                .map_or_else(Vec::new, |all| all.map(|n| Vec3::from_array(n).as_dvec3()).collect());
            if normals.len() == count as usize {
                add_turned_away(&mut away, &points[first as usize..], &normals, &indices);
            }
            faces.extend(
                indices
                    .chunks_exact(3)
                    .map(|f| ([f[0] + first, f[1] + first, f[2] + first], material)),
            );
        }
        let farthest = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let (mut mesh, middle) = Mesh::new(&name, &points, faces.into_iter());
        // The file's own coordinates are singles.
        mesh.known_to(farthest * HALF_A_PLACE);
        mesh.doubts.curved = if away.1 > 0.0 { away.0 / away.1 } else { 0.0 };
        if mesh.triangles.is_empty() {
            return Err(broken(&name, "there are no faces".into()));
        }
        // The vertices are in um already; a node's shift is still in the file's unit.
        let in_scene = |place: DAffine3| {
            let scaled =
                DAffine3::from_mat3_translation(place.matrix3, place.translation * unit_um);
            DAffine3::from_mat3(turn) * scaled * DAffine3::from_translation(middle)
        };
        parts.push((mesh, places.into_iter().map(in_scene).collect()));
    }
    if parts.is_empty() {
        return Err(broken("the file", "there are no meshes".into()));
    }
    Ok(parts)
}

/// Adds up how far the normals of a primitive turn away from its facets, and their areas.
fn add_turned_away(sum: &mut (f64, f64), points: &[DVec3], normals: &[DVec3], indices: &[u32]) {
    for face in indices.chunks_exact(3) {
        let at = [0, 1, 2].map(|i| face[i] as usize);
        let [a, b, c] = at.map(|i| points[i]);
        let (off, weight) = turned_away((b - a).cross(c - a), &at.map(|i| normals[i]));
        *sum = (sum.0 + off, sum.1 + weight);
    }
}
/// Corners of single triangles, three each, from those of a strip or a fan.
fn triangles(mode: Mode, indices: Vec<u32>) -> Vec<u32> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(i, of): (usize, &[u32])| {
                if i % 2 == 0 { [of[0], of[1], of[2]] } else { [of[1], of[0], of[2]] }
            };
            indices.windows(3).enumerate().flat_map(turned).collect()
        }
        Mode::TriangleFan => {
            let rest = indices.get(1..).unwrap_or_default();
            rest.windows(2).flat_map(|pair| [indices[0], pair[0], pair[1]]).collect()
        }
        _ => indices,
    }
}
