//! glTF 2.0, text or binary, through the gltf crate. Nodes that share a mesh stay instances.
//!
//! The file is looked at before the crate has it: what is no surface is left out, extensions are
//! applied or refused, and the crate reads only numbers that are all there.

mod accessor;
mod buffers;
mod file;
mod nodes;
mod vertices;

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::{DAffine3, DMat3, DVec3};

use super::{IngestError, Materials, Part};
use crate::geometry::cross;
use crate::geometry::mesh::{Curvature, Mesh, SINGLE_ROUNDING};
use crate::support::file_error::FileError;
use accessor::Data;
use vertices::Vertices;

pub(super) use buffers::buffer_files;

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
    let (file, blob) = file::parse(path, bytes)?;
    let in_text = buffers::in_text(path, &file)?;
    let buffers = buffers::all(path, &file, blob, &in_text, files)?;
    let document = file.document(path)?;
    let data = Data { path, file: &file, document: &document, buffers: &buffers };
    let mut parts = Vec::new();
    for (shape, places) in nodes::places(&data, object)? {
        let Some((mesh, middle)) = surface(&data, &shape, unit_um, materials)? else { continue };
        // The vertices are in um already; a node's shift is still in the file's unit.
        let in_scene = |place: DAffine3| {
            let scaled =
                DAffine3::from_mat3_translation(place.matrix3, place.translation * unit_um);
            DAffine3::from_mat3(turn) * scaled * DAffine3::from_translation(middle)
        };
        parts.push((mesh, places.into_iter().map(in_scene).collect()));
    }
    if parts.is_empty() {
        return Err(FileError::wrong(path, "there are no faces").into());
    }
    Ok(parts)
}

/// A mesh of the file, with the weights of its morph targets; none if it stands in its first shape.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Shape {
    mesh: usize,
    /// As bits, so that equal shapes are found.
    weights: Vec<u64>,
}

impl Shape {
    fn new(mesh: usize, weights: &[f64]) -> Self {
        let is_first = weights.iter().all(|&weight| weight == 0.0);
        let weights = if is_first { &[] } else { weights };
        Self { mesh, weights: weights.iter().map(|weight| weight.to_bits()).collect() }
    }

    /// The weights of the targets of a primitive.
    fn weights(&self) -> impl Iterator<Item = f64> {
        self.weights.iter().map(|&bits| f64::from_bits(bits))
    }
}

/// The triangles of a mesh, and the position of its middle, um. `None` if it has none.
fn surface(
    data: &Data,
    shape: &Shape,
    unit_um: f64,
    materials: &Materials,
) -> Result<Option<(Mesh, DVec3)>, IngestError> {
    let mesh = &data.file.meshes[shape.mesh];
    let name = mesh.name.clone().unwrap_or_else(|| format!("mesh {}", shape.mesh));
    let wrong = |problem: &str| FileError::wrong_at(data.path, &*name, problem);
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    let mut curvature = Curvature::default();
    for primitive in &mesh.primitives {
        let cut: fn(&[u32]) -> Vec<[u32; 3]> = match primitive.mode {
            // Points and lines have no surface.
            0..=3 => continue,
            4 => |indices| indices.as_chunks().0.to_vec(),
            5 => strip,
            6 => fan,
            other => return Err(wrong(&format!("the mode {other} is not known")).into()),
        };
        let material = match primitive.material {
            None => None,
            Some(number) => {
                let of = data.file.materials.get(number);
                of.ok_or_else(|| wrong(&format!("there is no material {number}")))?.name.as_deref()
            }
        };
        let material = materials.index(&name, material)?;
        let vertices = Vertices::checked(data, &name, primitive, shape)?;
        let own = vertices.positions();
        if own.iter().any(|point| !point.is_finite()) {
            return Err(wrong("a vertex is not finite").into());
        }
        let indices = vertices.indices();
        let count = own.len();
        if let Some(greatest) = indices.iter().find(|&&index| index as usize >= count) {
            let problem = format!("a face names vertex {greatest}, but the mesh has {count}");
            return Err(wrong(&problem).into());
        }
        if primitive.mode == 4 && !indices.len().is_multiple_of(3) {
            let problem = format!("{} corners do not make whole triangles", indices.len());
            return Err(wrong(&problem).into());
        }
        let triangles = cut(&indices);
        let first = points.len();
        points.extend(own.into_iter().map(|point| point * unit_um));
        if let Some(normals) = vertices.normals() {
            for triangle in triangles.iter().map(|t| t.map(|i| i as usize)) {
                let facet = cross(triangle.map(|i| points[first + i]));
                curvature.add(facet, triangle.map(|i| normals[i]).into_iter());
            }
        }
        faces.extend(triangles.into_iter().map(|t| (t.map(|i| i + first as u32), material)));
    }
    if faces.is_empty() {
        return Ok(None);
    }
    let farthest = points.iter().map(|p: &DVec3| p.abs().max_element()).fold(0.0, f64::max);
    let (mut mesh, middle) = Mesh::new(&name, &points, faces.into_iter());
    // The file's own coordinates are singles.
    mesh.set_rounding(farthest * SINGLE_ROUNDING);
    mesh.quality.curved = curvature.mean();
    // So far from the origin, or so small, that its coordinates do not tell its corners apart.
    if mesh.triangles.is_empty() {
        return Err(wrong("there are no faces").into());
    }
    Ok(Some((mesh, middle)))
}

/// Single triangles from a strip.
fn strip(indices: &[u32]) -> Vec<[u32; 3]> {
    let turned = |(i, of): (usize, &[u32])| {
        if i % 2 == 0 { [of[0], of[1], of[2]] } else { [of[1], of[0], of[2]] }
    };
    indices.windows(3).enumerate().map(turned).collect()
}

/// Single triangles from a fan.
fn fan(indices: &[u32]) -> Vec<[u32; 3]> {
    let rest = indices.get(1..).unwrap_or_default();
    rest.windows(2).map(|pair| [indices[0], pair[0], pair[1]]).collect()
}
