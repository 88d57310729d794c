//! A bed of placed meshes.

use std::collections::HashSet;
use std::path::PathBuf;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checked, need, positive, unique};
use super::{FARTHEST_UM, MOST_PARTICLES, Material, known};

/// A bed of placed meshes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Placed {
    /// The different meshes, at least one.
    pub prototypes: Vec<Prototype>,
    /// Copies of the meshes in their places. Default: each prototype once, where its file has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instances: Option<Vec<Instance>>,
    /// The part that the sensor sees, and its sides. Default: the bounding rectangle of all meshes,
    /// with open sides and no floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<Domain>,
    /// Where the geometry comes from. Default: it is given.
    #[serde(default, skip_serializing_if = "Origin::is_given")]
    pub origin: Origin,
    /// Seed of the drop, where the same drop is there as hulls and with fines that touch. Default:
    /// it stands alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drop: Option<u64>,
}

/// Where the geometry of a bed comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// It is given: no other bed is meant.
    #[default]
    Given,
    /// It is a random draw of a recipe, whose beds differ.
    Drawn,
    /// The same, and hulls keep the fines of neighbouring grains apart.
    DrawnApart,
}

impl Origin {
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
    pub(crate) fn is_given(&self) -> bool {
        *self == Self::Given
    }
}

/// A mesh from a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Prototype {
    /// The name that instances use. No two prototypes have the same name.
    pub name: String,
    /// A .obj, .gltf or .glb file, relative to the scene file.
    pub file: PathBuf,
    /// An object of the .obj file or a node of the glTF file. Default: the whole file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// Length of the file's unit, um, above 0. Default: 1 for .obj, 1e6 (metres) for glTF.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit_um: Option<f64>,
    /// The axis of the file that points up. Default: `z` for .obj, `y` for glTF.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// One material of the scene for all faces. Default: the materials that the file names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// The axis of a file that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// +y is up: (x, y, z) of the file is (x, -z, y) of the scene.
    Y,
    /// +z is up.
    Z,
}

/// A copy of a mesh in its place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Instance {
    /// Name of the prototype.
    pub prototype: String,
    /// The upper three rows of an invertible 4 x 4 matrix, row by row. The last column is in um;
    /// all numbers are below 1e9.
    pub transform: [f64; 12],
}

/// The part of the bed that the sensor sees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Least x and y, um, below `max_um`.
    pub min_um: [f64; 2],
    /// Greatest x and y, um.
    pub max_um: [f64; 2],
    /// How the bed continues beyond the four vertical sides.
    pub sides: Sides,
    /// An opaque plane below the bed. Default: no floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<Floor>,
}

/// How the bed continues beyond the sides of the domain, for a ray that leaves there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Sides {
    /// As its own mirror image, endlessly. The images match at the sides.
    Mirror,
    /// As copies of itself, endlessly. A solid that a side cuts gets a flat face there.
    Periodic,
    /// As copies, randomly turned and mirrored, up to the rim of a field of finite size. A solid
    /// that a side cuts gets a flat face there.
    Field {
        /// Least number of particles in the field, 1 to 1e15. A particle is a connected part of a
        /// mesh; the domain has those whose centre lies within it.
        particles: f64,
        /// Seed of the random turns. Default: 0.
        #[serde(default)]
        seed: u64,
    },
    /// Not at all: rays leave for the sky.
    Open,
}

/// An endless horizontal opaque plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Floor {
    /// Its height, um.
    pub z_um: f64,
    /// Its material, one of the scene's.
    pub material: String,
}

impl Placed {
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
            || "the list is empty: leave it out to place each prototype once".into(),
        )?;
        let Some(domain) = &self.domain else { return Ok(()) };
        for axis in 0..2 {
            let (min, max) = (domain.min_um[axis], domain.max_um[axis]);
            need(min.is_finite() && max.is_finite() && min < max, &at("domain"), || {
                format!("min_um {min} is not below max_um {max}")
            })?;
        }
        if let Sides::Field { particles, .. } = domain.sides {
            let is_field = (1.0..=MOST_PARTICLES).contains(&particles);
            need(is_field, &at("domain.sides.field.particles"), || {
                format!("{particles} is not within 1 to {MOST_PARTICLES:e}")
            })?;
        }
        if let Some(floor) = &domain.floor {
            known(materials, &floor.material, &at("domain.floor.material"))?;
            need(floor.z_um.is_finite(), &at("domain.floor.z_um"), || {
                "it is not a finite number".into()
            })?;
        }
        Ok(())
    }
}
