//! Where the nodes of a glTF file place its meshes.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DQuat, DVec4, Mat4, Vec3, Vec4};
use gltf::scene::Transform;

use super::Shape;
use super::accessor::{Data, FLOAT, SIGNED_OR_FLOAT};
use super::file::Instances;
use crate::geometry::ingest::IngestError;
use crate::support::file_error::FileError;

/// The shapes below the named node, or of the whole default scene, each with its places in the
/// file's unit.
///
/// # Errors
/// There is no such node, the nodes are no trees, or a skin bends a mesh.
pub(super) fn places(
    data: &Data,
    object: Option<&str>,
) -> Result<BTreeMap<Shape, Vec<DAffine3>>, IngestError> {
    let file = data.file;
    let wrong = |problem: &str| FileError::wrong(data.path, problem);
    let scene =
        file.scenes.get(file.scene.unwrap_or(0)).ok_or_else(|| wrong("there is no scene"))?;
    let mut places: BTreeMap<Shape, Vec<DAffine3>> = BTreeMap::new();
    let mut names = Vec::new();
    let mut is_met = vec![false; file.nodes.len()];
    // A node counts if it or one above it has the name wanted.
    let mut waiting: Vec<_> =
        scene.nodes.iter().map(|&node| (node, DAffine3::IDENTITY, object.is_none())).collect();
    while let Some((number, above, inside)) = waiting.pop() {
        let at = |problem: &str| FileError::wrong_at(data.path, format!("node {number}"), problem);
        let (node, read) = file
            .nodes
            .get(number)
            .zip(data.document.nodes().nth(number))
            .ok_or_else(|| at("the file has no such node"))?;
        if std::mem::replace(&mut is_met[number], true) {
            return Err(at("it stands below two nodes, or below itself").into());
        }
        if node.extensions.visibility.as_ref().and_then(|of| of.visible) == Some(false) {
            continue;
        }
        let place = above * place_of(&read.transform()).map_err(at)?;
        names.extend(node.name.clone());
        let inside = inside || object.is_some_and(|object| node.name.as_deref() == Some(object));
        if let (Some(mesh), true) = (node.mesh, inside) {
            let of = file.meshes.get(mesh).ok_or_else(|| at("its mesh is not in the file"))?;
            if node.skin.is_some() {
                let problem = "a skin bends its mesh: skins are not read";
                let hint = "apply the armature to the mesh, and export it again without skins";
                return Err(at(problem).with_hint(hint).into());
            }
            let weights = node.weights.as_ref().or(of.weights.as_ref());
            let shape = Shape::new(mesh, weights.map_or(&[], |weights| weights));
            let instances = match &node.extensions.instances {
                None => vec![DAffine3::IDENTITY],
                Some(instances) => instances_of(data, number, instances)?,
            };
            for place in instances.into_iter().map(|instance| place * instance) {
                // Scaled to nothing: so some programs hide a node.
                if place.matrix3 == DMat3::ZERO {
                    continue;
                }
                if !place.inverse().is_finite() {
                    return Err(at("it is scaled to a plane or a line, or not finite").into());
                }
                places
                    .entry(Shape { mesh, weights: shape.weights.clone() })
                    .or_default()
                    .push(place);
            }
        }
        waiting.extend(node.children.iter().map(|&child| (child, place, inside)));
    }
    if let (Some(object), true) = (object, places.is_empty()) {
        names.sort_unstable();
        names.dedup();
        let object = object.to_owned();
        return Err(IngestError::NoObject { path: data.path.to_owned(), object, present: names });
    }
    if places.is_empty() {
        return Err(wrong("there are no meshes").into());
    }
    Ok(places)
}

/// The place that a node has below another, or what is wrong with it.
fn place_of(transform: &Transform) -> Result<DAffine3, &'static str> {
    match transform {
        Transform::Decomposed { translation, rotation, scale } => {
            Ok(placed(*translation, *rotation, *scale))
        }
        Transform::Matrix { matrix } => {
            let matrix = Mat4::from_cols_array_2d(matrix).as_dmat4();
            if matrix.row(3) != DVec4::W {
                return Err("the last row of its matrix is not 0, 0, 0, 1");
            }
            Ok(DAffine3::from_mat4(matrix))
        }
    }
}

/// A place by its shift, its turn, as x, y, z, w of a quaternion, and its scale.
fn placed(translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3]) -> DAffine3 {
    let [translation, scale] = [translation, scale].map(|of| Vec3::from_array(of).as_dvec3());
    let rotation = Vec4::from_array(rotation).as_dvec4().normalize_or(DVec4::W);
    DAffine3::from_scale_rotation_translation(scale, DQuat::from_vec4(rotation), translation)
}

/// The instances of a node's mesh, by EXT_mesh_gpu_instancing.
fn instances_of(
    data: &Data,
    node: usize,
    instances: &Instances,
) -> Result<Vec<DAffine3>, FileError> {
    // Names of one's own begin with a line.
    let is_known =
        |name: &str| ["TRANSLATION", "ROTATION", "SCALE"].contains(&name) || name.starts_with('_');
    if let Some(name) = instances.attributes.keys().find(|name| !is_known(name)) {
        let problem = format!("the attribute {name:?} of its instances is not known");
        return Err(FileError::wrong_at(data.path, format!("node {node}"), problem));
    }
    let mut counts = Vec::new();
    let mut attribute = |name: &str, kind, numbers| {
        let number = instances.attributes.get(name).copied();
        if let Some(number) = number {
            counts.push(data.check(number, kind, numbers)?);
        }
        Ok::<_, FileError>(number)
    };
    let shifts = attribute("TRANSLATION", "VEC3", FLOAT)?.map(|number| data.elements(number));
    // Whole numbers are as good: a quaternion has the length 1.
    let turns = attribute("ROTATION", "VEC4", SIGNED_OR_FLOAT)?.map(|number| data.fours(number));
    let scales = attribute("SCALE", "VEC3", FLOAT)?.map(|number| data.elements(number));
    let count = counts.first().copied().unwrap_or(1);
    if counts.iter().any(|&other| other != count) {
        let problem = "the attributes of its instances are not equally many";
        return Err(FileError::wrong_at(data.path, format!("node {node}"), problem));
    }
    let at = |i: usize| {
        let shift = shifts.as_ref().map_or([0.0; 3], |all| all[i]);
        let turn = turns.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[i]);
        let scale = scales.as_ref().map_or([1.0; 3], |all| all[i]);
        placed(shift, turn, scale)
    };
    Ok((0..count).map(at).collect())
}
