//! The scene file: what is looked at, what it is made of, and how.
//!
//! Two kinds of geometry share one format. A *packing* is a recipe that Blender turns into a bed;
//! *placed* geometry names meshes and where they stand, and is what the tracer reads. Blender's
//! answer to the first is a scene file of the second kind, alike in everything else. Keys that
//! are not known are refused, so that a misspelt key cannot pass for a default.

mod check;
mod grid;
mod packing;
mod packing_check;
mod placed;
mod sensor;
pub mod shipped;
mod sky;
mod source;

use std::fs;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::support::error::Failure;
use check::{Checked, need, temperature, unique};

pub use grid::Grid;
pub use packing::{
    Collision, Cover, Drop, Dust, FineClass, Fines, FromLibrary, GrainClass, Packing, Shape,
    ShapeSource,
};
pub use placed::{Domain, Floor, Instance, Placed, Prototype, Sides, UpAxis};
pub use sensor::{Noise, Optics, Sensor, SensorBands};
pub use sky::{Sky, SkyPoint, SkyRadiance};
pub use source::{Inverted, SpectrumSource};

/// The format's version, the value of `soilsig_scene`.
pub const FORMAT: u32 = 1;

/// Lengths beyond a kilometre are taken for a mistake in units, um.
pub(crate) const FARTHEST_UM: f64 = 1e9;

/// Most materials: hits are told apart by material and cosine, in 16 bits.
const MOST_MATERIALS: usize = 1000;

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

impl Failure for SceneError {
    fn hint(&self) -> Option<String> {
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
    /// Where it was read from; files that it names are relative to its folder.
    #[serde(skip)]
    pub file: PathBuf,
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
    /// Radiance of the sky from a file, in place of its temperature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_radiance: Option<SkyRadiance>,
    /// A CSV file with what lies between target and sensor, relative to the scene file: columns `wavelength_um`,
    /// `transmittance` and `l_path_w_m2_sr_um`. Without it nothing does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub atmosphere_file: Option<PathBuf>,
    /// Where the sensor looks from.
    pub view: View,
    /// The sensor of `soilsig image`: its focal plane, bands and noise. Everything else sees the domain by parallel rays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Sensor>,
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
    /// Share of its reflectance that is specular, 0 to 1; the rest is Lambertian. Without it all of what `fresnel`
    /// facets reflect is, and nothing of others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub specular: Option<f64>,
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
        let text = text.trim_start_matches('\u{feff}');
        let mut scene: Self = serde_json::from_str(text)
            .map_err(|source| SceneError::Form { path: path.to_owned(), source })?;
        scene.check().map_err(|(place, problem)| SceneError::Value {
            path: path.to_owned(),
            place,
            problem,
        })?;
        scene.file = path.to_owned();
        Ok(scene)
    }

    /// A file that the scene names, from where the program stands.
    pub fn path_of(&self, file: &Path) -> PathBuf {
        self.folder().join(file)
    }

    /// The folder of its file.
    pub fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    /// The placed geometry, or an error that says how to get it.
    pub fn placed(&self) -> Result<&Placed, SceneError> {
        match &self.geometry {
            SceneGeometry::Placed(placed) => Ok(placed),
            SceneGeometry::Packing(_) => Err(SceneError::NotPlaced { path: self.file.clone() }),
        }
    }

    /// The temperature of a material, kelvin.
    pub fn temperature_of(&self, material: &Material) -> f64 {
        material.temperature_k.unwrap_or(self.temperature_k)
    }

    /// Whether the sky's radiance depends on the zenith angle.
    pub fn sky_is_by_zenith(&self) -> bool {
        matches!(self.sky_temperature_k, Some(Sky::ByZenith(_)))
            || matches!(self.sky_radiance, Some(SkyRadiance::ByZenith(_)))
    }

    /// The files of sky, atmosphere and the sensor's bands, by what they are.
    pub fn air_files_mut(&mut self) -> impl Iterator<Item = (String, &mut PathBuf)> {
        let sky = self.sky_radiance.as_mut().map(|sky| ("sky".into(), sky.file_mut()));
        let atmosphere = self.atmosphere_file.as_mut().map(|file| ("atmosphere".into(), file));
        let bands = self.sensor.iter_mut().flat_map(|sensor| &mut sensor.bands).flatten();
        let responses = bands.enumerate().filter_map(|(i, band)| match band {
            SensorBands::File(file) => Some((format!("band{i}"), file)),
            _ => None,
        });
        sky.into_iter().chain(atmosphere).chain(responses)
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
        need(
            self.sky_temperature_k.is_none() || self.sky_radiance.is_none(),
            "sky_radiance",
            || "the sky has a temperature already: give one of both".into(),
        )?;
        need((0.0..=89.9).contains(&self.view.zenith_deg), "view.zenith_deg", || {
            format!("{} is not within 0 (nadir) to 89.9", self.view.zenith_deg)
        })?;
        need(self.view.azimuth_deg.is_finite(), "view.azimuth_deg", || "not a number".into())?;
        if let Some(sensor) = &self.sensor {
            sensor.check()?;
        }
        need(!self.materials.is_empty(), "materials", || "there must be at least one".into())?;
        need(self.materials.len() <= MOST_MATERIALS, "materials", || {
            format!("there are {}, more than {MOST_MATERIALS}", self.materials.len())
        })?;
        unique(self.materials.iter().map(|m| m.name.as_str()), "materials")?;
        for (i, material) in self.materials.iter().enumerate() {
            let name = &material.name;
            // Mesh files could not name it.
            let is_plain = name.trim() == name && !name.contains(char::is_control);
            need(is_plain, &format!("materials[{i}].name"), || {
                format!("{name:?} begins or ends with white space, or holds a control character")
            })?;
            material.spectrum.check(&format!("materials[{i}].spectrum"))?;
            if let Some(own) = material.temperature_k {
                temperature(own, &format!("materials[{i}].temperature_k"))?;
            }
            if let Some(specular) = material.specular {
                need((0.0..=1.0).contains(&specular), &format!("materials[{i}].specular"), || {
                    format!("a share of {specular} is not within 0 to 1")
                })?;
            }
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
