//! Meshes and where they stand.

use std::collections::HashSet;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checked, need, positive, unique};
use super::{FARTHEST_UM, MOST_PARTICLES, Material, known};

/// Meshes and where they stand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Placed {
    /// The distinct meshes.
    pub prototypes: Vec<Prototype>,
    /// Where they stand; without it each prototype stands once, as its file has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instances: Option<Vec<Instance>>,
    /// The part that is looked at, and what bounds it; without it the sensor looks at the bounding
    /// rectangle of everything, and all sides are open to the sky.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<Domain>,
}

/// A mesh from a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Prototype {
    /// The name that instances refer to.
    pub name: String,
    /// A .obj, .gltf or .glb file, relative to the scene file.
    pub file: PathBuf,
    /// The object (.obj) or node (glTF) of the file; without it the whole file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// Micrometres in one unit of the file: 1 for .obj and 1e6 (metres) for glTF if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit_um: Option<f64>,
    /// The file's upward axis: z for .obj and y for glTF if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// One material for all faces, in place of those that the file names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// Which axis of a file points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// +y is up: (x, y, z) of the file is (x, -z, y) of the scene.
    Y,
    /// +z is up.
    Z,
}

/// One mesh in its place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Instance {
    /// The prototype's name.
    pub prototype: String,
    /// The upper three rows of a 4 x 4 matrix, row by row; the last column is in um.
    pub transform: [f64; 12],
}

/// The part of the scene that is looked at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Least x and y, um.
    pub min_um: [f64; 2],
    /// Greatest x and y, um.
    pub max_um: [f64; 2],
    /// What stands at the four vertical sides.
    pub sides: Sides,
    /// An opaque plane below, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<Floor>,
}

/// What becomes of a ray that leaves the domain sideways: how the bed goes on there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Sides {
    /// As its own mirror image, without end and without seam.
    Mirror,
    /// As copies of itself, without end; a solid that a side cuts has a flat face there.
    Periodic,
    /// As copies turned and mirrored at random, as far as the field goes, and beyond it the sky; a solid
    /// that a side cuts has a flat face there.
    Field {
        /// How many particles the field has at least. A particle is a connected part of a mesh; the domain
        /// has those whose middle lies within it.
        particles: f64,
        /// Seed of the turns.
        #[serde(default)]
        seed: u64,
    },
    /// Not at all: the scene is a body in the open.
    Open,
}

/// A horizontal opaque plane without end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Floor {
    /// Its height, um.
    pub z_um: f64,
    /// Its material.
    pub material: String,
}

impl Placed {
    /// What is wrong with it, in a scene of these materials.
    pub(super) fn check(&self, materials: &[Material]) -> Checked {
        let at = |key: &str| format!("geometry.placed.{key}");
        need(!self.prototypes.is_empty(), &at("prototypes"), || {
            "there must be at least one".into()
        })?;
        unique(self.prototypes.iter().map(|p| p.name.as_str()), &at("prototypes"))?;
        for (i, prototype) in self.prototypes.iter().enumerate() {
            if let Some(unit_um) = prototype.unit_um {
                positive(unit_um, &at(&format!("prototypes[{i}].unit_um")))?;
            }
            if let Some(material) = &prototype.material {
                known(materials, material, &at(&format!("prototypes[{i}].material")))?;
            }
        }
        let names: HashSet<&str> = self.prototypes.iter().map(|p| p.name.as_str()).collect();
        for (i, instance) in self.instances.iter().flatten().enumerate() {
            let place = at(&format!("instances[{i}]"));
            need(names.contains(instance.prototype.as_str()), &place, || {
                format!("there is no prototype {:?}", instance.prototype)
            })?;
            let m = &instance.transform;
            let determinant = m[0] * (m[5] * m[10] - m[6] * m[9])
                - m[1] * (m[4] * m[10] - m[6] * m[8])
                + m[2] * (m[4] * m[9] - m[5] * m[8]);
            need(
                m.iter().all(|value| value.abs() < FARTHEST_UM) && determinant.abs() > 1e-30,
                &place,
                || "the transform is not an invertible matrix of numbers below 1e9".into(),
            )?;
        }
        need(
            self.instances.as_ref().is_none_or(|instances| !instances.is_empty()),
            &at("instances"),
            || "the list is empty: leave it out to have each prototype once".into(),
        )?;
        let Some(domain) = &self.domain else { return Ok(()) };
        for axis in 0..2 {
            let (min, max) = (domain.min_um[axis], domain.max_um[axis]);
            need(min.is_finite() && max.is_finite() && min < max, &at("domain"), || {
                format!("min_um {min} is not below max_um {max}")
            })?;
        }
        if let Sides::Field { particles, .. } = domain.sides {
            need(
                (1.0..=MOST_PARTICLES).contains(&particles),
                &at("domain.sides.field.particles"),
                || format!("{particles} is not within 1 to {MOST_PARTICLES:e}"),
            )?;
        }
        if let Some(floor) = &domain.floor {
            known(materials, &floor.material, &at("domain.floor.material"))?;
            need(floor.z_um.is_finite(), &at("domain.floor.z_um"), || "not a number".into())?;
        }
        Ok(())
    }
}
