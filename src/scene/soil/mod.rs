//! A soil as people state it: shares of mass or volume, sizes, dust by cover or mass.
//!
//! [`Soil::resolve`] chooses the counts and the tray, and gives the packing that Blender carries
//! out. Nothing below the scene knows of soils.

mod check;
mod counts;
mod resolve;
mod shares;

use std::path::PathBuf;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::packing::{Drop, Dust, ShapeSource};
use super::packing_check::{MOST, MOST_SEED, NAME};
use super::sizes::Sizes;
pub use shares::{ComponentShares, Dressed, DustShares, SizeClass, SoilShares};

/// Above the density of every mineral, g cm-3.
const MOST_G_CM3: f64 = 25.0;

/// A soil by its shares. The program chooses counts of grains and the tray.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Soil {
    /// Seed of shapes, dust and drop.
    #[cfg_attr(feature = "schema", schemars(range(max = MOST_SEED)))]
    pub seed: u64,
    /// Folder of grains of the user's own, relative to the scene file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub library: Option<PathBuf>,
    /// What the soil consists of, one component at least.
    #[cfg_attr(feature = "schema", schemars(length(min = 1)))]
    pub components: Vec<SoilComponent>,
    /// The kinds of dust, which components name. Default: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dust: Vec<DustKind>,
    /// Material of the tray's floor. Default: that of the first component.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor_material: Option<String>,
    /// Least number of grains to drop. More are dropped where the shares need them. Default: 72.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = MOST)))]
    pub grains: Option<u32>,
    /// Porosity below the surface, to be compared with that of the bed. The drop is natural and
    /// has no means to change it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "schema",
        schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))
    )]
    pub porosity: Option<f64>,
    /// How the dust sits on a grain.
    #[serde(default)]
    pub seating: Dust,
    /// The rigid-body drop.
    #[serde(default)]
    pub drop: Drop,
}

/// A component of a soil: grains of one material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SoilComponent {
    /// Its name, up to 30 characters without white space or `#`.
    #[cfg_attr(feature = "schema", schemars(regex(pattern = NAME)))]
    pub name: String,
    /// The grains' material.
    pub material: String,
    /// Share of the mass of all grains without dust; all components together make 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = 1), extend("exclusiveMinimum" = 0)))]
    pub mass_share: Option<f64>,
    /// Share of the volume, in place of `mass_share` for all components.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = 1), extend("exclusiveMinimum" = 0)))]
    pub volume_share: Option<f64>,
    /// Diameters, um. A sieve's opening is taken for the diameter of the sphere of equal volume.
    pub size_um: Sizes,
    /// A modelled shape by name or by proportions, or grains of the library.
    pub shape: ShapeSource,
    /// Density, g cm-3, up to 25. Default: 2.65, that of quartz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0, "maximum" = MOST_G_CM3)))]
    pub density_g_cm3: Option<f64>,
    /// The dust on these grains, by kind. Default: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dust: Vec<DustOn>,
}

/// A kind of dust.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DustKind {
    /// Its name, up to 30 characters without white space or `#`.
    #[cfg_attr(feature = "schema", schemars(regex(pattern = NAME)))]
    pub name: String,
    /// The material of the fines.
    pub material: String,
    /// Diameters, um.
    pub size_um: Sizes,
    /// A modelled shape by name or by proportions, or grains of the library.
    pub shape: ShapeSource,
    /// Density, g cm-3, up to 25. Default: 2.65, that of quartz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0, "maximum" = MOST_G_CM3)))]
    pub density_g_cm3: Option<f64>,
}

/// Dust of a kind on the grains of a component.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DustOn {
    /// The kind's name.
    pub kind: String,
    /// Share of the dusty grain's silhouette that this dust is, seen from afar and averaged over
    /// all directions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = 1), extend("exclusiveMinimum" = 0)))]
    pub cover: Option<f64>,
    /// Mass of this dust over that of the bare grain, in place of `cover`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub mass_ratio: Option<f64>,
}
