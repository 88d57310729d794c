//! The scene file: what is looked at, what it is made of, and how.
//!
//! Two kinds of geometry share one format. A *packing* is a recipe that Blender turns into a bed;
//! *placed* geometry names meshes and where they stand, and is what the tracer reads. Blender's
//! answer to the first is a scene file of the second kind, alike in everything else. Keys that
//! are not known are refused, so that a misspelt key cannot pass for a default.

mod check;
mod packing;
mod placed;
mod sky;

use std::fs;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use check::{Checked, need, temperature, unique};
pub use packing::{
    Collision, Cover, Drop, Dust, FineClass, Fines, FromLibrary, GrainClass, Packing, Shape,
    ShapeSource,
};
pub use placed::{Domain, Floor, Instance, Placed, Prototype, Sides, UpAxis};
pub use sky::{Sky, SkyPoint};

/// The format's version, the value of `soilsig_scene`.
pub const FORMAT: u32 = 1;

/// Lengths beyond a kilometre are taken for a mistake in units, um.
const FARTHEST_UM: f64 = 1e9;

/// Most particles of a field.
pub const MOST_PARTICLES: f64 = 1e15;

/// A scene file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read the scene {}: {source}", path.display())]
    Read {
        /// The scene file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not JSON of the scene's form.
    #[error("{}: {source}", path.display())]
    Form {
        /// The scene file.
        path: PathBuf,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// A value is out of its range, or a name refers to nothing.
    #[error("{}: {place}: {problem}", path.display())]
    Value {
        /// The scene file.
        path: PathBuf,
        /// The key in the file.
        place: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A packing was given where placed geometry is needed.
    #[error("{}: the scene is a packing, a recipe that Blender has not carried out yet", path.display())]
    NotPlaced {
        /// The scene file.
        path: PathBuf,
    },
}

impl SceneError {
    /// What the user can do about it.
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Form { .. } => {
                "`soilsig schema scene` prints the format; docs/scene.md explains it".into()
            }
            Self::NotPlaced { path } => {
                format!(
                    "run `soilsig pipeline --scene {} --out FOLDER` and use FOLDER/scene.json",
                    path.display()
                )
            }
            Self::Read { .. } | Self::Value { .. } => return None,
        })
    }
}

/// A scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Version of the format: 1.
    pub soilsig_scene: u32,
    /// What the scene is called in tables, charts and messages.
    pub name: String,
    /// Free text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Seed of the ray tracing (a packing has its own).
    pub seed: u64,
    /// Temperature of everything that has none of its own, kelvin, above 0.
    pub temperature_k: f64,
    /// Temperature of a grey sky, kelvin; without it the sky is cold and black (`l_downwelling` = 0), as in the
    /// paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_temperature_k: Option<Sky>,
    /// Where the sensor looks from.
    pub view: View,
    /// What surfaces are made of: one entry for each size class of each mineral, in the order in
    /// which the bounce table counts them.
    pub materials: Vec<Material>,
    /// The bed, as a recipe or as placed meshes.
    pub geometry: SceneGeometry,
}

/// The direction to the sensor, which sees parallel rays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Angle from the vertical (+z), degrees, 0 (nadir view) to 89.9.
    pub zenith_deg: f64,
    /// Angle of the sensor's place from +x towards +y, degrees.
    #[serde(default)]
    pub azimuth_deg: f64,
}

/// A surface material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// The name used by `usemtl` in .obj files, by glTF materials and elsewhere in the scene.
    pub name: String,
    /// Emissivity of a facet against wavelength.
    pub spectrum: SpectrumSource,
    /// Its own temperature, kelvin, in place of the scene's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_k: Option<f64>,
    /// Share of its reflectance that is specular, 0 to 1; the rest is Lambertian.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub specular: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
pub(crate) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Where a facet's emissivity comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SpectrumSource {
    /// A shipped spectrum: `quartz_fine`, `quartz_medium` or `quartz_coarse`.
    Builtin(String),
    /// A CSV file of two columns, wavelength in um and emissivity from 0 to 1; relative to the
    /// scene file.
    File(PathBuf),
    /// The same emissivity at every wavelength, 0 to 1.
    Constant(f64),
    /// Shipped optical constants, `quartz` or `quartz_spitzer_kleinman`: the facets reflect specularly,
    /// with the Fresnel reflectance at the angle of each hit.
    Fresnel(String),
}

/// The bed: to be made, or made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SceneGeometry {
    /// A recipe for Blender.
    Packing(Packing),
    /// Meshes and where they stand.
    Placed(Placed),
}

impl Scene {
    /// Reads a scene file and checks it.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let text = fs::read_to_string(path)
            .map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path)
    }

    /// Reads a scene from text; `path` is named in messages.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        let scene: Self = serde_json::from_str(text)
            .map_err(|source| SceneError::Form { path: path.to_owned(), source })?;
        scene.check().map_err(|(place, problem)| SceneError::Value {
            path: path.to_owned(),
            place,
            problem,
        })?;
        Ok(scene)
    }

    /// The placed geometry, or an error that says how to get it.
    pub fn placed(&self, path: &Path) -> Result<&Placed, SceneError> {
        match &self.geometry {
            SceneGeometry::Placed(placed) => Ok(placed),
            SceneGeometry::Packing(_) => Err(SceneError::NotPlaced { path: path.to_owned() }),
        }
    }

    /// The temperature of a material, kelvin.
    pub fn temperature_of(&self, material: &Material) -> f64 {
        material.temperature_k.unwrap_or(self.temperature_k)
    }

    /// The place of a material in the list.
    pub fn material_index(&self, name: &str) -> Option<usize> {
        self.materials.iter().position(|material| material.name == name)
    }

    fn check(&self) -> Checked {
        need(self.soilsig_scene == FORMAT, "soilsig_scene", || {
            format!(
                "version {} is not known; this program reads version {FORMAT}",
                self.soilsig_scene
            )
        })?;
        temperature(self.temperature_k, "temperature_k")?;
        if let Some(problem) = self.sky_temperature_k.as_ref().and_then(Sky::problem) {
            return Err(("sky_temperature_k".into(), problem));
        }
        need((0.0..=89.9).contains(&self.view.zenith_deg), "view.zenith_deg", || {
            format!("{} is not within 0 (nadir) to 89.9", self.view.zenith_deg)
        })?;
        need(self.view.azimuth_deg.is_finite(), "view.azimuth_deg", || "not a number".into())?;
        need(!self.materials.is_empty(), "materials", || "there must be at least one".into())?;
        unique(self.materials.iter().map(|m| m.name.as_str()), "materials")?;
        for (i, material) in self.materials.iter().enumerate() {
            if let SpectrumSource::Constant(emissivity) = material.spectrum {
                need(
                    (0.0..=1.0).contains(&emissivity),
                    &format!("materials[{i}].spectrum.constant"),
                    || format!("an emissivity of {emissivity} is not within 0 to 1"),
                )?;
            }
            if let Some(own) = material.temperature_k {
                temperature(own, &format!("materials[{i}].temperature_k"))?;
            }
            need(
                (0.0..=1.0).contains(&material.specular),
                &format!("materials[{i}].specular"),
                || format!("a share of {} is not within 0 to 1", material.specular),
            )?;
        }
        match &self.geometry {
            SceneGeometry::Packing(packing) => packing.check(&self.materials),
            SceneGeometry::Placed(placed) => placed.check(&self.materials),
        }
    }
}

/// Whether the scene has a material of that name.
fn known(materials: &[Material], name: &str, place: &str) -> Checked {
    need(materials.iter().any(|m| m.name == name), place, || {
        let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        format!("there is no material {name:?}; the scene has {}", names.join(", "))
    })
}
