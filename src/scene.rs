//! The scene file: what is looked at, what it is made of, and how.
//!
//! Two kinds of geometry share one format. A *packing* is a recipe that Blender turns into a bed;
//! *placed* geometry names meshes and where they stand, and is what the tracer reads. Blender's
//! answer to the first is a scene file of the second kind, alike in everything else. Keys that
//! are not known are refused, so that a misspelt key cannot pass for a default.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The format's version, the value of `soilsig_scene`.
pub const FORMAT: u32 = 1;

/// Lengths beyond a kilometre are taken for a mistake in units, um.
const FARTHEST_UM: f64 = 1e9;

/// Most particles of a field.
pub const MOST_PARTICLES: f64 = 1e15;

/// Most grains of a class, and most fines on one.
const MOST: u32 = 100_000;

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

/// Temperature of the sky.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Sky {
    /// The same in all directions, kelvin.
    Isotropic(f64),
    /// By zenith angle: points in ascending order from 0 to 90 degrees, with straight lines between them.
    ByZenith(Vec<SkyPoint>),
}

/// Temperature of the sky at a zenith angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkyPoint {
    /// Angle from the vertical, degrees.
    pub zenith_deg: f64,
    /// Temperature, kelvin.
    pub temperature_k: f64,
}

impl Sky {
    /// The temperature at a zenith angle from 0 to 90 degrees.
    pub fn temperature_k(&self, zenith_deg: f64) -> f64 {
        match self {
            Self::Isotropic(kelvin) => *kelvin,
            Self::ByZenith(points) => {
                let above = points
                    .partition_point(|p| p.zenith_deg < zenith_deg)
                    .clamp(1, points.len() - 1);
                let [a, b] = [points[above - 1], points[above]];
                let share = (zenith_deg - a.zenith_deg) / (b.zenith_deg - a.zenith_deg);
                a.temperature_k + share * (b.temperature_k - a.temperature_k)
            }
        }
    }

    /// What is wrong with it, if anything is.
    pub fn problem(&self) -> Option<String> {
        let bad = |kelvin: &f64| temperature(*kelvin, "").err().map(|(_, problem)| problem);
        match self {
            Self::Isotropic(kelvin) => bad(kelvin),
            Self::ByZenith(points) => {
                let zeniths: Vec<f64> = points.iter().map(|p| p.zenith_deg).collect();
                let whole = zeniths.first() == Some(&0.0) && zeniths.last() == Some(&90.0);
                if !whole || !zeniths.is_sorted_by(|a, b| a < b) {
                    return Some("the zenith angles do not ascend from 0 to 90 degrees".into());
                }
                points.iter().find_map(|p| bad(&p.temperature_k))
            }
        }
    }
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

/// A recipe for a bed of grains dusted with fines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Packing {
    /// Seed of shapes, dust and drop.
    pub seed: u64,
    /// The classes of grains, any number of them.
    pub grains: Vec<GrainClass>,
    /// The classes of fines, any number of them; none for bare grains.
    #[serde(default)]
    pub fines: Vec<FineClass>,
    /// How the fines sit on a grain.
    #[serde(default)]
    pub dust: Dust,
    /// How many different dressed grains are modelled of each class.
    pub variants: u32,
    /// Length of the tray along x and y, um.
    pub tray_um: [f64; 2],
    /// Width of the rim inside the tray's walls that is not looked at, um: the walls order the
    /// grains that touch them.
    pub crop_um: f64,
    /// Material of the tray's floor, where a ray gets down to it.
    pub floor_material: String,
    /// The rigid-body drop.
    #[serde(default)]
    pub drop: Drop,
}

/// The five quartz shapes modelled after SEM images; each can have any diameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Shape {
    /// A fresh splinter, the most elongated.
    #[serde(rename = "fine_35")]
    Fine35,
    /// A splinter.
    #[serde(rename = "fine_60")]
    Fine60,
    /// An angular grain.
    #[serde(rename = "grain_500")]
    Grain500,
    /// A grain with its edges a little rounded.
    #[serde(rename = "grain_640")]
    Grain640,
    /// The most equant grain, with the roundest edges.
    #[serde(rename = "grain_853")]
    Grain853,
}

/// One class of grains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainClass {
    /// The class's name; its prototypes are called NAME_0, NAME_1, ...
    pub name: String,
    /// Which of the modelled shapes.
    pub shape: Shape,
    /// Diameter of the sphere of equal volume, um.
    pub diameter_um: f64,
    /// The grain's material.
    pub material: String,
    /// How many grains of this class are dropped.
    pub count: u32,
    /// How many fines sit on each.
    pub fines: Fines,
}

/// How many fines sit on a grain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Fines {
    /// So many.
    Count(u32),
    /// As many as it takes.
    Cover(Cover),
}

/// The cover that fines are to reach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cover {
    /// Share of the dusty grain's silhouette, seen from afar and averaged over all directions, that is
    /// fines: 0 to 1.
    pub silhouette: f64,
}

impl Fines {
    /// Whether there is none.
    pub fn is_none(self) -> bool {
        match self {
            Self::Count(count) => count == 0,
            Self::Cover(cover) => cover.silhouette == 0.0,
        }
    }
}

/// How the fines sit on a grain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Dust {
    /// Most layers: fines that find no free seat on the grain sit on the fines of the layer below, up to
    /// this many layers.
    pub layers: u32,
    /// How deep a fine may pass through its neighbours, as a share of its diameter: 0 keeps them apart, 1 asks
    /// nothing of them.
    pub overlap: f64,
}

impl Default for Dust {
    fn default() -> Self {
        Self { layers: 8, overlap: 0.0 }
    }
}

/// One class of fines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FineClass {
    /// The class's name.
    pub name: String,
    /// Which of the modelled shapes.
    pub shape: Shape,
    /// Diameter of the sphere of equal volume, um.
    pub diameter_um: f64,
    /// The fine's material.
    pub material: String,
    /// Share of the fines by number; all shares together make 1.
    pub share: f64,
}

/// Settings of the rigid-body drop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Drop {
    /// What of a dusty grain collides.
    pub collision: Collision,
    /// Steps of the solver within a frame of 1/24 s.
    pub substeps: u32,
    /// Iterations of the solver within a step.
    pub iterations: u32,
    /// Frames after which a bed that still moves is refused.
    pub max_frames: u32,
    /// Length of the mean grain diameter in the solver's units: it is at home with a few.
    pub scale: f64,
    /// Gravity in the solver's units: only the clock depends on it.
    pub gravity: f64,
    /// Distance that the solver keeps between hulls, in its units.
    pub margin: f64,
}

/// What of a dusty grain collides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Collision {
    /// The convex hull of the dusty grain: the fastest.
    Hull,
    /// The hull until the bed rests, then every fine and the grain itself, so that fines touch fines.
    HullThenFines,
    /// The dusty grain's own mesh from the first frame on: for a few grains.
    Mesh,
}

impl Default for Drop {
    fn default() -> Self {
        Self {
            collision: Collision::Hull,
            substeps: 6,
            iterations: 30,
            max_frames: 400,
            scale: 6.5,
            gravity: 98.1,
            margin: 0.04,
        }
    }
}

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

    fn check(&self) -> Result<(), (String, String)> {
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
            SceneGeometry::Packing(packing) => self.check_packing(packing),
            SceneGeometry::Placed(placed) => self.check_placed(placed),
        }
    }

    fn check_packing(&self, packing: &Packing) -> Result<(), (String, String)> {
        let at = |key: &str| format!("geometry.packing.{key}");
        unique(
            packing.grains.iter().map(|g| &*g.name).chain(packing.fines.iter().map(|f| &*f.name)),
            &at("grains"),
        )?;
        for (i, grain) in packing.grains.iter().enumerate() {
            positive(grain.diameter_um, &at(&format!("grains[{i}].diameter_um")))?;
            self.known(&grain.material, &at(&format!("grains[{i}].material")))?;
            need(grain.count <= MOST, &at(&format!("grains[{i}].count")), || {
                format!("{} is more than {MOST}", grain.count)
            })?;
            match grain.fines {
                Fines::Count(count) => {
                    need(count <= MOST, &at(&format!("grains[{i}].fines")), || {
                        format!("{count} is more than {MOST}")
                    })?;
                }
                Fines::Cover(Cover { silhouette }) => need(
                    (0.0..=1.0).contains(&silhouette),
                    &at(&format!("grains[{i}].fines.silhouette")),
                    || format!("{silhouette} is not within 0 to 1"),
                )?,
            }
            need(grain.fines.is_none() || !packing.fines.is_empty(), &at("fines"), || {
                format!("{} wants fines, but there is no class of them", grain.name)
            })?;
        }
        need((1..=100).contains(&packing.dust.layers), &at("dust.layers"), || {
            format!("{} is not within 1 to 100", packing.dust.layers)
        })?;
        need((0.0..=1.0).contains(&packing.dust.overlap), &at("dust.overlap"), || {
            format!("{} is not within 0 to 1", packing.dust.overlap)
        })?;
        for (i, fine) in packing.fines.iter().enumerate() {
            positive(fine.diameter_um, &at(&format!("fines[{i}].diameter_um")))?;
            self.known(&fine.material, &at(&format!("fines[{i}].material")))?;
            need((0.0..=1.0).contains(&fine.share), &at(&format!("fines[{i}].share")), || {
                format!("{} is not within 0 to 1", fine.share)
            })?;
        }
        let shares: f64 = packing.fines.iter().map(|fine| fine.share).sum();
        need(packing.fines.is_empty() || (shares - 1.0).abs() < 1e-6, &at("fines"), || {
            format!("the shares make {shares}, not 1")
        })?;
        need(packing.grains.iter().any(|grain| grain.count > 0), &at("grains"), || {
            "there is no grain to drop".into()
        })?;
        need(packing.variants > 0, &at("variants"), || "must be at least 1".into())?;
        self.known(&packing.floor_material, &at("floor_material"))?;
        need(packing.crop_um >= 0.0, &at("crop_um"), || "must not be negative".into())?;
        for length in packing.tray_um {
            positive(length, &at("tray_um"))?;
            need(length < FARTHEST_UM, &at("tray_um"), || format!("{length} um is too long"))?;
            need(length > 2.0 * packing.crop_um, &at("crop_um"), || {
                format!("a rim of {} um leaves nothing of a tray of {length} um", packing.crop_um)
            })?;
        }
        for (key, value) in [
            ("drop.substeps", packing.drop.substeps),
            ("drop.iterations", packing.drop.iterations),
            ("drop.max_frames", packing.drop.max_frames),
        ] {
            need(value > 0, &at(key), || "must be at least 1".into())?;
        }
        positive(packing.drop.scale, &at("drop.scale"))?;
        positive(packing.drop.gravity, &at("drop.gravity"))?;
        need(
            packing.drop.margin.is_finite() && packing.drop.margin >= 0.0,
            &at("drop.margin"),
            || "must not be negative".into(),
        )
    }

    fn check_placed(&self, placed: &Placed) -> Result<(), (String, String)> {
        let at = |key: &str| format!("geometry.placed.{key}");
        need(!placed.prototypes.is_empty(), &at("prototypes"), || {
            "there must be at least one".into()
        })?;
        unique(placed.prototypes.iter().map(|p| p.name.as_str()), &at("prototypes"))?;
        for (i, prototype) in placed.prototypes.iter().enumerate() {
            if let Some(unit_um) = prototype.unit_um {
                positive(unit_um, &at(&format!("prototypes[{i}].unit_um")))?;
            }
            if let Some(material) = &prototype.material {
                self.known(material, &at(&format!("prototypes[{i}].material")))?;
            }
        }
        let names: HashSet<&str> = placed.prototypes.iter().map(|p| p.name.as_str()).collect();
        for (i, instance) in placed.instances.iter().flatten().enumerate() {
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
            placed.instances.as_ref().is_none_or(|instances| !instances.is_empty()),
            &at("instances"),
            || "the list is empty: leave it out to have each prototype once".into(),
        )?;
        let Some(domain) = &placed.domain else { return Ok(()) };
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
            self.known(&floor.material, &at("domain.floor.material"))?;
            need(floor.z_um.is_finite(), &at("domain.floor.z_um"), || "not a number".into())?;
        }
        Ok(())
    }

    fn known(&self, material: &str, place: &str) -> Result<(), (String, String)> {
        need(self.material_index(material).is_some(), place, || {
            let names: Vec<&str> = self.materials.iter().map(|m| m.name.as_str()).collect();
            format!("there is no material {material:?}; the scene has {}", names.join(", "))
        })
    }
}

fn need(
    holds: bool,
    place: &str,
    problem: impl FnOnce() -> String,
) -> Result<(), (String, String)> {
    if holds { Ok(()) } else { Err((place.to_owned(), problem())) }
}

fn positive(value: f64, place: &str) -> Result<(), (String, String)> {
    need(value.is_finite() && value > 0.0, place, || format!("{value} is not above 0"))
}

fn temperature(kelvin: f64, place: &str) -> Result<(), (String, String)> {
    need((1.0..=10_000.0).contains(&kelvin), place, || {
        format!("{kelvin} K is not within 1 to 10000 K")
    })
}

fn unique<'a>(names: impl Iterator<Item = &'a str>, place: &str) -> Result<(), (String, String)> {
    let mut seen = HashSet::new();
    for name in names {
        need(seen.insert(name), place, || format!("the name {name:?} stands twice"))?;
    }
    Ok(())
}
