//! Where the nodes of a glTF file place its meshes.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};

use super::Shape;
use super::accessor::Data;
use super::file::{Instances, Node};
use crate::geometry::ingest::IngestError;
use crate::support::file_error::FileError;

/// A quaternion as x, y, z, w.
const NO_TURN: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

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
    let scene = file.scenes.get(file.scene.unwrap_or(0)).ok_or_else(|| wrong("there is no scene"))?;
    let mut places: BTreeMap<Shape, Vec<DAffine3>> = BTreeMap::new();
    let mut names = Vec::new();
    let mut is_met = vec![false; file.nodes.len()];
    // A node counts if it or one above it has the name wanted.
    let mut waiting: Vec<_> =
        scene.nodes.iter().map(|&node| (node, DAffine3::IDENTITY, object.is_none())).collect();
    while let Some((number, above, inside)) = waiting.pop() {
        let at = |problem: &str| FileError::wrong_at(data.path, format!("node {number}"), problem);
        let node = file.nodes.get(number).ok_or_else(|| at("there is none"))?;
        if std::mem::replace(&mut is_met[number], true) {
            return Err(at("it stands below two nodes, or below itself").into());
        }
        if node.extensions.visibility.as_ref().and_then(|of| of.visible) == Some(false) {
            continue;
        }
        let place = above * own_place(node);
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
                if place.matrix3 == glam::DMat3::ZERO {
                    continue;
                }
                if !place.inverse().is_finite() {
                    return Err(at("it is scaled to a plane or a line, or not finite").into());
                }
                places.entry(Shape { mesh, weights: shape.weights.clone() }).or_default().push(place);
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

/// A node's place in the node above it.
fn own_place(node: &Node) -> DAffine3 {
    match node.matrix {
        Some(matrix) => DAffine3::from_mat4(DMat4::from_cols_array(&matrix)),
        None => placed(
            DVec3::from_array(node.translation.unwrap_or_default()),
            node.rotation.unwrap_or(NO_TURN),
            DVec3::from_array(node.scale.unwrap_or([1.0; 3])),
        ),
    }
}

/// A place by its shift, its turn, as x, y, z, w of a quaternion, and its scale.
fn placed(translation: DVec3, rotation: [f64; 4], scale: DVec3) -> DAffine3 {
    let rotation = DVec4::from_array(rotation).normalize_or(DVec4::W);
    let rotation = DQuat::from_vec4(rotation);
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

/// The instances of a node's mesh, by EXT_mesh_gpu_instancing.
fn instances_of(
    data: &Data,
    node: usize,
    instances: &Instances,
) -> Result<Vec<DAffine3>, FileError> {
    let translations: Option<Vec<[f64; 3]>> = attribute(data, instances, "TRANSLATION")?;
    let rotations: Option<Vec<[f64; 4]>> = attribute(data, instances, "ROTATION")?;
    let scales: Option<Vec<[f64; 3]>> = attribute(data, instances, "SCALE")?;
    let counts = [
        translations.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
    ];
    let mut counts = counts.into_iter().flatten();
    let count = counts.next().unwrap_or(1);
    if counts.any(|other| other != count) {
        let problem = "the attributes of its instances are not equally many";
        return Err(FileError::wrong_at(data.path, format!("node {node}"), problem));
    }
    let at = |i: usize| {
        let shift = translations.as_ref().map_or([0.0; 3], |all| all[i]);
        let turn = rotations.as_ref().map_or(NO_TURN, |all| all[i]);
        let scale = scales.as_ref().map_or([1.0; 3], |all| all[i]);
        placed(DVec3::from_array(shift), turn, DVec3::from_array(scale))
    };
    Ok((0..count).map(at).collect())
}

fn attribute<const N: usize>(
    data: &Data,
    instances: &Instances,
    name: &str,
) -> Result<Option<Vec<[f64; N]>>, FileError> {
    instances.attributes.get(name).map(|&number| data.elements(number)).transpose()
}
