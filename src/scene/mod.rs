//! The scene file: what the sensor sees, what it is made of, and from where.
//!
//! Two kinds of geometry share one format. A *packing* is a recipe that Blender turns into a bed.
//! *Placed* geometry names meshes and their places; the tracer reads it. Blender turns a scene of
//! the first kind into one of the second kind with the same other keys. Unknown keys are refused,
//! so that a misspelt key does not silently give a default.

mod change;
mod check;
mod geometry;
mod grid;
mod layers;
mod packing;
mod packing_check;
mod placed;
mod sensor;
pub mod shipped;
mod sizes;
mod sky;
mod soil;
mod source;

use std::fs;
use std::path::{Path, PathBuf};

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::support::error::Failure;
use crate::support::file_error::FileError;
use check::{Checked, need, temperature, unique, within};

pub use change::Change;
pub use geometry::SceneGeometry;
pub use grid::Grid;
pub use layers::{Depth, Layers, SceneTemperature, Sun};
pub use packing::{
    Collision, Cover, Drop, Dust, FineClass, Fines, Form, FromLibrary, GrainClass, Packing, Shape,
    ShapeSource,
};
pub use placed::{Domain, Floor, Instance, Origin, Placed, Prototype, Sides, UpAxis};
pub use sensor::{Noise, Optics, Sensor, SensorBands};
pub use sizes::{Distribution, Lognormal, Sizes};
pub use sky::{Sky, SkyPoint, SkyRadiance};
pub use soil::{
    ComponentShares, Dressed, DustKind, DustOn, DustShares, SizeClass, Soil, SoilComponent,
    SoilShares,
};
pub use source::{Component, Constants, ConstantsFile, Facets, Inverted, SpectrumSource};

/// The format's version, the value of `soilsig_scene`.
pub const FORMAT: u32 = 1;

/// Longest length, um: a kilometre. Beyond it the unit is probably wrong.
pub(crate) const FARTHEST_UM: f64 = 1e9;

/// Most materials: a symbol of material and cosine has 16 bits.
const MOST_MATERIALS: usize = 1000;

/// Most particles of a field.
pub const MOST_PARTICLES: f64 = 1e15;

/// A scene file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read, or is not a valid scene.
    #[error(transparent)]
    File(#[from] FileError),
    /// A packing was given where placed geometry is needed.
    #[error("{}: the scene is a packing, but placed geometry is needed", path.display())]
    NotPlaced {
        /// The scene file.
        path: PathBuf,
    },
}

impl Failure for SceneError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::File(error) => error.hint(),
            Self::NotPlaced { path } => Some(format!(
                "run `soilsig pipeline --scene {} --out FOLDER` and use FOLDER/scene.json",
                path.display()
            )),
        }
    }
}

/// A scene: what the sensor sees, what it is made of, and from where.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The scene file. Files that it names are relative to its folder.
    #[serde(skip)]
    pub file: PathBuf,
    /// Values that differ from the file's.
    #[serde(skip)]
    pub changes: Vec<Change>,
    /// Version of the format: 1.
    pub soilsig_scene: u32,
    /// Name of the scene in tables, charts and messages.
    pub name: String,
    /// Free text: the heading of the chart. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Random seed of the ray tracing, 0 to 2^64 - 1. A packing has its own.
    pub seed: u64,
    /// Temperature of all materials without their own, K, 1 to 10000, or by depth and by the sun.
    pub temperature_k: SceneTemperature,
    /// Temperature of the sky, K, 1 to 10000. Default: a cold black sky (`l_downwelling` = 0), as
    /// in the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_temperature_k: Option<Sky>,
    /// Radiance of the sky from a file, in place of `sky_temperature_k`. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_radiance: Option<SkyRadiance>,
    /// A CSV file of the atmosphere between target and sensor, relative to the scene file. Its
    /// columns are `wavelength_um`, `transmittance` and `l_path_w_m2_sr_um`. Default: no
    /// atmosphere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub atmosphere_file: Option<PathBuf>,
    /// The direction to the sensor.
    pub view: View,
    /// The sensor of `soilsig image`; other commands ignore it. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Sensor>,
    /// The surface materials, 1 to 1000: one for each size class of each mineral. The bounce table
    /// counts them in this order.
    pub materials: Vec<Material>,
    /// The bed: a soil, a recipe, or placed meshes.
    pub geometry: SceneGeometry,
}

/// The direction to the sensor, which sees parallel rays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Angle from the vertical (+z), degrees, 0 (nadir view) to 89.9.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 89.9)))]
    pub zenith_deg: f64,
    /// Azimuth of the sensor, from +x towards +y, degrees. Default: 0.
    #[serde(default)]
    pub azimuth_deg: f64,
}

/// A surface material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Name of the material for `usemtl` in .obj files, for glTF materials and for other keys of
    /// the scene. No two materials have the same name.
    pub name: String,
    /// Emissivity of a facet by wavelength.
    pub spectrum: SpectrumSource,
    /// Temperature of the material, K, 1 to 10000. Default: the scene's `temperature_k`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1.0, max = 10_000.0)))]
    pub temperature_k: Option<f64>,
    /// Specular share of the reflectance, 0 to 1; the rest is Lambertian. Default: 1 for `fresnel`
    /// spectra, 0 for others. Refractive facets have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    pub specular: Option<f64>,
}

/// A file that a scene names.
#[derive(Debug)]
pub struct SceneFile<'a> {
    /// Its path, relative to the scene's folder.
    pub path: &'a mut PathBuf,
    /// What it is, and the number of its material or band.
    label: String,
    is_table: bool,
}

impl SceneFile<'_> {
    /// Name of a copy beside another scene file, unique within the scene. `file` is this file, or
    /// one that belongs to it.
    pub fn copy_name(&self, file: &Path) -> String {
        let label = &self.label;
        if self.is_table {
            // Tables of several packings usually have the same name.
            return format!("{label}.json");
        }
        format!("{label}_{}", file.file_name().unwrap_or_default().to_string_lossy())
    }
}

impl Scene {
    /// Reads a scene file and checks it.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        Self::parse(&fs::read_to_string(path).map_err(FileError::read(path))?, path)
    }

    /// Reads a scene from text; `path` is its file.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        let text = text.trim_start_matches('\u{feff}');
        Self::of(serde_json::from_str(text), path)
    }

    /// A scene that was read, checked; `path` is its file.
    fn of(read: serde_json::Result<Self>, path: &Path) -> Result<Self, SceneError> {
        let mut scene = read
            .map_err(|error| FileError::wrong(path, error.to_string()).with_hint(change::FORMAT))?;
        let checked = scene.check().and_then(|()| scene.resolve());
        checked.map_err(|(place, problem)| FileError::wrong_at(path, place, problem))?;
        path.clone_into(&mut scene.file);
        Ok(scene)
    }

    /// The path of a file that the scene names.
    pub fn path_of(&self, file: &Path) -> PathBuf {
        self.folder().join(file)
    }

    /// The folder of its file.
    pub fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    /// The placed geometry.
    ///
    /// # Errors
    /// A packing: Blender has not made the bed.
    pub fn placed(&self) -> Result<&Placed, SceneError> {
        match &self.geometry {
            SceneGeometry::Placed(placed) => Ok(placed),
            SceneGeometry::Packing(_) => Err(SceneError::NotPlaced { path: self.file.clone() }),
        }
    }

    /// The temperature of a material, K; where the scene has layers that of the first.
    pub fn temperature_of(&self, material: &Material) -> f64 {
        material.temperature_k.unwrap_or(self.temperature_k.kelvin())
    }

    /// Whether facets differ in temperature.
    pub fn is_of_temperatures(&self) -> bool {
        let kelvin = self.temperature_k.kelvin();
        self.temperature_k.layers().is_some()
            || self.materials.iter().any(|m| self.temperature_of(m) != kelvin)
    }

    /// Whether the sky's radiance depends on the zenith angle.
    pub fn sky_is_by_zenith(&self) -> bool {
        matches!(self.sky_temperature_k, Some(Sky::ByZenith(_)))
            || matches!(self.sky_radiance, Some(SkyRadiance::ByZenith(_)))
    }

    /// The paths of all files that the scene names besides meshes and grains.
    pub fn files(&self) -> Vec<PathBuf> {
        self.clone().files_mut().iter().map(|file| self.path_of(file.path)).collect()
    }

    /// All files that the scene names besides meshes and grains: spectra, pure beds, sky,
    /// atmosphere and responses of the sensor's bands.
    pub fn files_mut(&mut self) -> Vec<SceneFile<'_>> {
        let mut files = Vec::new();
        let mut add =
            |label: String, path, is_table| files.push(SceneFile { path, label, is_table });
        for (i, material) in self.materials.iter_mut().enumerate() {
            material.spectrum.files_mut(&i.to_string(), &mut add);
        }
        if let Some(sky) = &mut self.sky_radiance {
            add("sky".into(), sky.file_mut(), false);
        }
        if let Some(path) = &mut self.atmosphere_file {
            add("atmosphere".into(), path, false);
        }
        let bands = self.sensor.iter_mut().flat_map(|sensor| &mut sensor.bands).flatten();
        for (i, band) in bands.enumerate() {
            if let SensorBands::File(path) = band {
                add(format!("band{i}"), path, false);
            }
        }
        files
    }

    /// The index of a material.
    pub fn material_index(&self, name: &str) -> Option<usize> {
        self.materials.iter().position(|material| material.name == name)
    }

    /// Makes the packing of a soil, and checks it.
    fn resolve(&mut self) -> Checked {
        if let SceneGeometry::Packing(packing) = &mut self.geometry
            && let Some(soil) = packing.soil.take()
        {
            *packing = soil.resolve()?.0;
            // Keys that a soil has in common with a packing stand in the soil.
            packing.check(&self.materials).map_err(|(place, problem)| {
                (place.replace("geometry.packing", "geometry.soil"), problem)
            })?;
        }
        Ok(())
    }

    /// The soil of the scene with the shares that its packing reaches, before Blender dresses the
    /// grains; `None` if the scene states no soil.
    pub fn soil_shares(&self) -> Option<SoilShares> {
        let SceneGeometry::Packing(packing) = &self.geometry else { return None };
        Some(packing.soil.as_ref()?.resolve().ok()?.1)
    }

    fn check(&self) -> Checked {
        need(self.soilsig_scene == FORMAT, "soilsig_scene", || {
            format!(
                "version {} is unknown; this program reads version {FORMAT}",
                self.soilsig_scene
            )
        })?;
        self.temperature_k.check(self.materials.len())?;
        if let Some(problem) = self.sky_temperature_k.as_ref().and_then(Sky::problem) {
            return Err(("sky_temperature_k".into(), problem));
        }
        need(
            self.sky_temperature_k.is_none() || self.sky_radiance.is_none(),
            "sky_radiance",
            || "the scene also has sky_temperature_k: give only one".into(),
        )?;
        within(self.view.zenith_deg, 0.0..=89.9, "view.zenith_deg")?;
        need(self.view.azimuth_deg.is_finite(), "view.azimuth_deg", || {
            "it is not a finite number".into()
        })?;
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
            // Mesh files could not name such a material.
            let place = format!("materials[{i}].name");
            need(!name.is_empty(), &place, || "a material needs a name".into())?;
            let is_plain = name.trim() == name && !name.contains(char::is_control);
            need(is_plain, &place, || {
                format!("{name:?} begins or ends with white space, or holds a control character")
            })?;
            material.spectrum.check(&format!("materials[{i}].spectrum"))?;
            if let Some(own) = material.temperature_k {
                temperature(own, &format!("materials[{i}].temperature_k"))?;
            }
            let is_refractive = matches!(
                material.spectrum,
                SpectrumSource::Refractive(_) | SpectrumSource::Auto(_)
            );
            let place = format!("materials[{i}].specular");
            need(!is_refractive || material.specular.is_none(), &place, || {
                "refractive facets reflect as mirrors: leave it out".into()
            })?;
            if let Some(specular) = material.specular {
                within(specular, 0.0..=1.0, &place)?;
            }
        }
        match &self.geometry {
            SceneGeometry::Packing(packing) => match &packing.soil {
                Some(soil) => soil.check(&self.materials),
                None => packing.check(&self.materials),
            },
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
