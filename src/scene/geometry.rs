//! What a scene file states as its geometry, and what the program makes of it.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::packing::Packing;
use super::placed::Placed;
use super::soil::Soil;

/// The bed: a recipe, or placed meshes. A soil becomes a packing when it is read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", from = "Written")]
pub enum SceneGeometry {
    /// A recipe for Blender.
    Packing(Packing),
    /// Meshes in their places.
    Placed(Placed),
}

/// The bed: a soil by its shares, a recipe, or placed meshes.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "SceneGeometry"))]
#[serde(rename_all = "snake_case")]
enum Written {
    /// A soil by its shares, from which the program makes a recipe.
    Soil(Soil),
    /// A recipe for Blender.
    Packing(Packing),
    /// Meshes in their places.
    Placed(Placed),
}

impl From<Written> for SceneGeometry {
    fn from(written: Written) -> Self {
        match written {
            // `Scene::of` resolves it, once the materials are known.
            Written::Soil(soil) => Self::Packing(soil.unresolved()),
            Written::Packing(packing) => Self::Packing(packing),
            Written::Placed(placed) => Self::Placed(placed),
        }
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for SceneGeometry {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        Written::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        Written::json_schema(generator)
    }
}
