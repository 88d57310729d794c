//! glTF 2.0, text or binary. Nodes that share a mesh stay instances.

mod accessor;
mod buffers;
mod file;
mod nodes;

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::{DAffine3, DMat3, DVec3};

use super::{IngestError, Materials, Part};
use crate::geometry::cross;
use crate::geometry::mesh::{Curvature, Mesh, SINGLE_ROUNDING};
use crate::support::file_error::FileError;
use accessor::Data;
use file::{COMPRESSED, Primitive};

pub(super) use buffers::buffer_files;

/// `componentType` of single-precision numbers.
const FLOAT: u32 = 5126;

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
    let data = Data { path, file: &file, buffers: &buffers };
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

    /// The morph targets of a primitive that have a weight.
    fn targets<'a>(
        &'a self,
        primitive: &'a Primitive,
    ) -> impl Iterator<Item = (f64, &'a BTreeMap<String, usize>)> {
        let weights = self.weights.iter().map(|&bits| f64::from_bits(bits));
        weights.zip(&primitive.targets).filter(|&(weight, _)| weight != 0.0)
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
        let own = positions(data, &name, primitive, shape)?;
        let count = own.len();
        let indices: Vec<u32> = match primitive.indices {
            None => (0..count as u32).collect(),
            Some(number) => data.indices(number)?,
        };
        if let Some(greatest) = indices.iter().find(|&&index| index as usize >= count) {
            let problem = format!("a face names vertex {greatest}, but the mesh has {count}");
            return Err(wrong(&problem).into());
        }
        let triangles = cut(&indices);
        let first = points.len();
        points.extend(own.into_iter().map(|point| point * unit_um));
        if let Some(normals) = normals(data, primitive, shape)? {
            if normals.len() != count {
                return Err(wrong("it has more or fewer normals than vertices").into());
            }
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
    Ok((!mesh.triangles.is_empty()).then_some((mesh, middle)))
}

/// The vertices of a primitive in the file's unit.
fn positions(
    data: &Data,
    mesh: &str,
    primitive: &Primitive,
    shape: &Shape,
) -> Result<Vec<DVec3>, FileError> {
    let wrong = |problem: &str| FileError::wrong_at(data.path, mesh, problem);
    let number = primitive.attributes.get("POSITION");
    let accessor = number.map(|&number| data.accessor(number)).transpose()?;
    let is_elsewhere = accessor.is_none_or(|of| of.buffer_view.is_none());
    if is_elsewhere && primitive.extensions.draco.is_some() {
        let problem = "its triangles are compressed by KHR_draco_mesh_compression";
        return Err(wrong(problem).with_hint(COMPRESSED));
    }
    let number = *number.ok_or_else(|| wrong("there are no vertex positions"))?;
    if accessor.is_some_and(|of| of.component_type != FLOAT) {
        let problem = "its vertices are rounded to whole numbers, by KHR_mesh_quantization";
        return Err(wrong(problem).with_hint(COMPRESSED));
    }
    let mut positions: Vec<DVec3> =
        data.elements(number)?.into_iter().map(DVec3::from_array).collect();
    for (weight, target) in shape.targets(primitive) {
        if let Some(&number) = target.get("POSITION") {
            add(&mut positions, weight, data.elements(number)?).map_err(wrong)?;
        }
    }
    if positions.iter().any(|point| !point.is_finite()) {
        return Err(wrong("a vertex is not finite"));
    }
    Ok(positions)
}

/// The normals of a primitive; none if it has none that belong to its shape.
fn normals(
    data: &Data,
    primitive: &Primitive,
    shape: &Shape,
) -> Result<Option<Vec<DVec3>>, FileError> {
    let Some(&number) = primitive.attributes.get("NORMAL") else { return Ok(None) };
    let mut normals: Vec<DVec3> =
        data.elements(number)?.into_iter().map(DVec3::from_array).collect();
    for (weight, target) in shape.targets(primitive) {
        let Some(&number) = target.get("NORMAL") else { return Ok(None) };
        let wrong = |problem| FileError::wrong_at(data.path, format!("accessor {number}"), problem);
        add(&mut normals, weight, data.elements(number)?).map_err(wrong)?;
    }
    Ok(Some(normals))
}

/// Adds what a morph target changes.
fn add(to: &mut [DVec3], weight: f64, changes: Vec<[f64; 3]>) -> Result<(), &'static str> {
    if changes.len() != to.len() {
        return Err("a morph target has more or fewer vertices than the mesh");
    }
    for (value, change) in to.iter_mut().zip(changes) {
        *value += weight * DVec3::from_array(change);
    }
    Ok(())
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
