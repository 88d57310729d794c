//! glTF 2.0, text or binary, through the gltf crate. Nodes that share a mesh stay instances.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DAffine3, DMat3, DMat4, DVec3, Mat4, Vec3};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::{Gltf, Primitive};

use super::{IngestError, Materials, Part};
use crate::geometry::cross;
use crate::geometry::mesh::{Curvature, Mesh, SINGLE_ROUNDING};
use crate::support::file_error::FileError;

/// Files beside a glTF file that hold its buffers.
pub(super) fn buffer_files(path: &Path, bytes: &[u8]) -> Result<Vec<PathBuf>, FileError> {
    let file = parse(path, bytes)?;
    let outside = file.buffers().filter_map(|buffer| match buffer.source() {
        Source::Uri(uri) if !uri.starts_with("data:") => Some(beside(path, uri)),
        _ => None,
    });
    Ok(outside.collect())
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Gltf, FileError> {
    Gltf::from_slice(bytes).map_err(|error| FileError::wrong(path, error.to_string()))
}

fn beside(path: &Path, uri: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(uri)
}

/// The bytes of each buffer: in the file itself, in a data: URI, or in a file that was read.
fn buffers(
    path: &Path,
    file: &mut Gltf,
    files: &BTreeMap<PathBuf, Vec<u8>>,
) -> Result<Vec<Vec<u8>>, FileError> {
    let blob = file.blob.take();
    let bytes = |buffer: gltf::Buffer| {
        let bytes = match buffer.source() {
            Source::Bin => blob.clone(),
            Source::Uri(uri) if uri.starts_with("data:") => {
                uri.split_once(";base64,").and_then(|(_, text)| STANDARD.decode(text).ok())
            }
            Source::Uri(uri) => files.get(&beside(path, uri)).cloned(),
        };
        bytes.filter(|bytes| bytes.len() >= buffer.length()).ok_or_else(|| {
            let place = format!("buffer {}", buffer.index());
            FileError::wrong_at(path, place, "it is missing, too short or not base64")
        })
    };
    file.buffers().map(bytes).collect()
}

/// The meshes below the named node, or of the whole default scene, each with its places.
pub(super) fn read(
    bytes: &[u8],
    files: &BTreeMap<PathBuf, Vec<u8>>,
    object: Option<&str>,
    unit_um: f64,
    turn: DMat3,
    materials: &Materials,
) -> Result<Vec<Part>, IngestError> {
    let path = materials.path;
    let mut file = parse(path, bytes)?;
    let buffers = buffers(path, &mut file, files)?;
    let scene = file
        .default_scene()
        .or_else(|| file.scenes().next())
        .ok_or_else(|| FileError::wrong(path, "there is no scene"))?;

    // A node counts if it or one above it has the name wanted.
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
        let object = object.to_owned();
        return Err(IngestError::NoObject { path: path.to_owned(), object, present: names });
    }
    if places.is_empty() {
        return Err(FileError::wrong(path, "there are no meshes").into());
    }
    let part = |(index, places): (usize, Vec<DAffine3>)| {
        let mesh = file.meshes().nth(index).expect("the node refers to it");
        let (mesh, middle) = surface(&mesh, &buffers, unit_um, materials)?;
        // The vertices are in um already; a node's shift is still in the file's unit.
        let in_scene = |place: DAffine3| {
            let scaled =
                DAffine3::from_mat3_translation(place.matrix3, place.translation * unit_um);
            DAffine3::from_mat3(turn) * scaled * DAffine3::from_translation(middle)
        };
        Ok((mesh, places.into_iter().map(in_scene).collect()))
    };
    places.into_iter().map(part).collect()
}

/// The triangles of a mesh, and the position of its middle, um.
fn surface(
    mesh: &gltf::Mesh,
    buffers: &[Vec<u8>],
    unit_um: f64,
    materials: &Materials,
) -> Result<(Mesh, DVec3), IngestError> {
    let name = mesh.name().map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
    let wrong = |problem: &str| FileError::wrong_at(materials.path, &*name, problem);
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    let mut curvature = Curvature::default();
    // Points and lines have no surface.
    let is_surface = |primitive: &Primitive| {
        matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
    };
    for primitive in mesh.primitives().filter(is_surface) {
        let material = materials.index(&name, primitive.material().name())?;
        let first = points.len();
        let reader = primitive.reader(|buffer| Some(&*buffers[buffer.index()]));
        let positions =
            reader.read_positions().ok_or_else(|| wrong("there are no vertex positions"))?;
        points.extend(positions.map(|p| Vec3::from_array(p).as_dvec3() * unit_um));
        if points[first..].iter().any(|point| !point.is_finite()) {
            return Err(wrong("a vertex is not finite").into());
        }
        let count = (points.len() - first) as u32;
        let indices: Vec<u32> = reader
            .read_indices()
            .map_or_else(|| (0..count).collect(), |indices| indices.into_u32().collect());
        if let Some(greatest) = indices.iter().find(|&&i| i >= count) {
            let problem = format!("a face names vertex {greatest}, but the mesh has {count}");
            return Err(wrong(&problem).into());
        }
        let triangles = triangles(primitive.mode(), &indices);
        let normals: Vec<DVec3> = reader
            .read_normals()
            .map_or_else(Vec::new, |all| all.map(|n| Vec3::from_array(n).as_dvec3()).collect());
        if normals.len() == count as usize {
            for triangle in triangles.iter().map(|t| t.map(|i| i as usize)) {
                let facet = cross(triangle.map(|i| points[first + i]));
                curvature.add(facet, triangle.map(|i| normals[i]).into_iter());
            }
        }
        faces.extend(triangles.into_iter().map(|t| (t.map(|i| i + first as u32), material)));
    }
    let farthest = points.iter().map(|p: &DVec3| p.abs().max_element()).fold(0.0, f64::max);
    let (mut mesh, middle) = Mesh::new(&name, &points, faces.into_iter());
    // The file's own coordinates are singles.
    mesh.set_rounding(farthest * SINGLE_ROUNDING);
    mesh.quality.curved = curvature.mean();
    if mesh.triangles.is_empty() {
        return Err(wrong("there are no faces").into());
    }
    Ok((mesh, middle))
}

/// Single triangles from a list, a strip or a fan.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(i, of): (usize, &[u32])| {
                if i % 2 == 0 { [of[0], of[1], of[2]] } else { [of[1], of[0], of[2]] }
            };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let rest = indices.get(1..).unwrap_or_default();
            rest.windows(2).map(|pair| [indices[0], pair[0], pair[1]]).collect()
        }
        _ => indices.as_chunks().0.to_vec(),
    }
}
