//! A recipe for a bed, which Blender carries out.

use std::collections::BTreeMap;
use std::path::PathBuf;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use super::packing_check::{
    GRAIN_NAME, LEAST_FORM, MOST, MOST_FRAMES, MOST_ITERATIONS, MOST_LAYERS, MOST_RIBS, MOST_SEED,
    MOST_SUBSTEPS, MOST_VARIANTS, NAME,
};
use super::soil::Soil;
use super::{FARTHEST_UM, Origin};

/// A recipe for a bed of grains dusted with fines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Packing {
    /// Seed of shapes, dust and drop.
    #[cfg_attr(feature = "schema", schemars(range(max = MOST_SEED)))]
    pub seed: u64,
    /// Folder of grains of the user's own, relative to the scene file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub library: Option<PathBuf>,
    /// The classes of grains, one at least.
    #[cfg_attr(feature = "schema", schemars(length(min = 1)))]
    pub grains: Vec<GrainClass>,
    /// The classes of fines, any number of them; none for bare grains.
    #[serde(default)]
    pub fines: Vec<FineClass>,
    /// How the fines sit on a grain.
    #[serde(default)]
    pub dust: Dust,
    /// How many different dressed grains are modelled of each class.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = MOST_VARIANTS)))]
    pub variants: u32,
    /// Length of the tray along x and y, um.
    #[cfg_attr(feature = "schema", schemars(inner(range(min = 0, max = FARTHEST_UM))))]
    pub tray_um: [f64; 2],
    /// Width of the rim inside the tray's walls that is not looked at, um: the walls order the
    /// grains that touch them.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub crop_um: f64,
    /// Material of the tray's floor, where a ray gets down to it.
    pub floor_material: String,
    /// The rigid-body drop.
    #[serde(default)]
    pub drop: Drop,
    /// The soil that it carries out, if the scene states one.
    #[serde(skip)]
    pub soil: Option<Box<Soil>>,
}

/// The five quartz shapes modelled after SEM images; each can have any diameter. Their earlier names
/// are read as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A fresh splinter, the most elongated and the flattest.
    Flake,
    /// A fresh splinter, less elongated.
    Chip,
    /// A grain with sharp edges.
    Angular,
    /// A grain with its edges a little rounded.
    Subangular,
    /// The most equant grain, with the roundest edges.
    Worn,
}

impl Shape {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flake => "flake",
            Self::Chip => "chip",
            Self::Angular => "angular",
            Self::Subangular => "subangular",
            Self::Worn => "worn",
        }
    }

    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "flake" | "fine_35" => Self::Flake,
            "chip" | "fine_60" => Self::Chip,
            "angular" | "grain_500" => Self::Angular,
            "subangular" | "grain_640" => Self::Subangular,
            "worn" | "grain_853" => Self::Worn,
            _ => return None,
        })
    }
}

impl<'de> Deserialize<'de> for Shape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::named(&name).ok_or_else(|| {
            let problem = "is no shape: use flake, chip, angular, subangular or worn";
            D::Error::custom(format!("{name} {problem}"))
        })
    }
}

/// Where the bodies of a class come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(
    untagged,
    expecting = "a shape is one of flake, chip, angular, subangular, worn, or {\"elongation\": x, \"flatness\": y}, or {\"library\": [names of grains]}"
)]
pub enum ShapeSource {
    /// One of the modelled shapes.
    Modelled(Shape),
    /// A modelled shape of other proportions.
    Form(Form),
    /// Grains of the library.
    Library(FromLibrary),
}

/// A modelled shape stretched to other proportions, as for plates and needles. L, I and S are its
/// longest, middle and shortest diameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Form {
    /// I/L, 0.1 to 1.
    #[cfg_attr(feature = "schema", schemars(range(min = LEAST_FORM, max = 1)))]
    pub elongation: f64,
    /// S/I, 0.1 to 1.
    #[cfg_attr(feature = "schema", schemars(range(min = LEAST_FORM, max = 1)))]
    pub flatness: f64,
    /// Wadell's sphericity, 0.1 to 1, that a body is to have within 0.03. Default: whatever the
    /// stretched shape has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = LEAST_FORM, max = 1)))]
    pub sphericity: Option<f64>,
    /// The shape that is stretched. Default: `angular`.
    #[serde(default = "angular")]
    pub like: Shape,
}

fn angular() -> Shape {
    Shape::Angular
}

/// Grains of the packing's library, in turn.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FromLibrary {
    /// Their names, those of their files.
    #[cfg_attr(feature = "schema", schemars(length(min = 1), inner(regex(pattern = GRAIN_NAME))))]
    pub library: Vec<String>,
}

/// One class of grains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GrainClass {
    /// The class's name, up to 40 characters without white space or `#`; its prototypes are called
    /// NAME_0, NAME_1, ...
    #[cfg_attr(feature = "schema", schemars(regex(pattern = NAME)))]
    pub name: String,
    /// One of the modelled shapes, or grains of the library.
    pub shape: ShapeSource,
    /// Ribs at the sides of each fracture of a modelled shape, 0 to 2: the more ribs, the more
    /// facets. Without it the shape's own number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MOST_RIBS)))]
    pub ribs: Option<u8>,
    /// Diameter of the sphere of equal volume, um; bodies are scaled to it.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub diameter_um: f64,
    /// The grain's material.
    pub material: String,
    /// How many grains of this class are dropped.
    #[cfg_attr(feature = "schema", schemars(range(max = MOST)))]
    pub count: u32,
    /// How many fines sit on each.
    pub fines: Fines,
    /// Shares of the fines on these grains by number, by the names of their classes; together 1.
    /// Default: those of the classes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fine_shares: BTreeMap<String, f64>,
}

/// How many fines sit on a grain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged, expecting = "fines are a whole number, or {\"silhouette\": share}")]
pub enum Fines {
    /// So many.
    Count(#[cfg_attr(feature = "schema", schemars(range(max = MOST)))] u32),
    /// As many as it takes.
    Cover(Cover),
}

/// The cover that fines are to reach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Cover {
    /// Share of the dusty grain's silhouette that is fines, seen from afar and averaged over all
    /// directions: 0 to 1.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Dust {
    /// Most layers: fines that find no free seat on the grain sit on the fines of the layer below,
    /// up to this many layers.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = MOST_LAYERS)))]
    pub layers: u32,
    /// How deep a fine may pass through its neighbours, as a share of its diameter: 0 keeps them
    /// apart, 1 asks nothing of them.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    pub overlap: f64,
}

impl Default for Dust {
    fn default() -> Self {
        Self { layers: 8, overlap: 0.0 }
    }
}

/// One class of fines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FineClass {
    /// The class's name, up to 40 characters without white space or `#`.
    #[cfg_attr(feature = "schema", schemars(regex(pattern = NAME)))]
    pub name: String,
    /// One of the modelled shapes, or grains of the library.
    pub shape: ShapeSource,
    /// Ribs at the sides of each fracture of a modelled shape, 0 to 2: the more ribs, the more
    /// facets. Without it the shape's own number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(max = MOST_RIBS)))]
    pub ribs: Option<u8>,
    /// Diameter of the sphere of equal volume, um; bodies are scaled to it.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub diameter_um: f64,
    /// The fine's material.
    pub material: String,
    /// Share of the fines by number; all shares together make 1.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    pub share: f64,
}

/// Settings of the rigid-body drop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Drop {
    /// What of a dusty grain collides.
    pub collision: Collision,
    /// Steps of the solver within a frame of 1/24 s.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = MOST_SUBSTEPS)))]
    pub substeps: u32,
    /// Iterations of the solver within a step.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = MOST_ITERATIONS)))]
    pub iterations: u32,
    /// Frames after which a bed that still moves is refused.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = MOST_FRAMES)))]
    pub max_frames: u32,
    /// Length of the mean grain diameter in the solver's units: it is at home with a few.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub scale: f64,
    /// Gravity in the solver's units: only the clock depends on it.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub gravity: f64,
    /// Distance that the solver keeps between hulls, in its units.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub margin: f64,
}

/// What of a dusty grain collides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Collision {
    /// The convex hull of the dusty grain: the fastest.
    Hull,
    /// The hull until the bed rests, then every fine and the grain itself, so that fines touch
    /// fines.
    HullThenFines,
    /// The dusty grain's own mesh from the first frame on: for a few grains.
    Mesh,
}

impl Collision {
    /// About what a bed takes with its trace, in beds of hulls (docs: stages). A mesh was not
    /// measured.
    pub const fn cost(self) -> f64 {
        match self {
            Self::Hull => 1.0,
            Self::HullThenFines | Self::Mesh => 3.5,
        }
    }
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

impl Packing {
    /// What its beds are. Hulls keep dust apart, if there is any.
    pub fn origin(&self) -> Origin {
        let is_dusted = self.grains.iter().any(|class| !class.fines.is_none());
        let hulls = self.drop.collision == Collision::Hull;
        if is_dusted && hulls { Origin::DrawnApart } else { Origin::Drawn }
    }

    /// The shapes of all classes and the ribs asked of them, with the classes' places in the scene
    /// file.
    pub fn shapes(&self) -> impl Iterator<Item = (String, &ShapeSource, Option<u8>)> {
        let grains = self.grains.iter().map(|c| ("grains", &c.shape, c.ribs)).enumerate();
        let fines = self.fines.iter().map(|c| ("fines", &c.shape, c.ribs)).enumerate();
        grains.chain(fines).map(|(i, (kind, shape, ribs))| (format!("{kind}[{i}]"), shape, ribs))
    }

    /// The same, to be changed.
    pub fn shapes_mut(&mut self) -> impl Iterator<Item = (&mut ShapeSource, &mut Option<u8>)> {
        let grains = self.grains.iter_mut().map(|class| (&mut class.shape, &mut class.ribs));
        grains.chain(self.fines.iter_mut().map(|class| (&mut class.shape, &mut class.ribs)))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{from_value, json, to_value};

    use super::ShapeSource;

    #[test]
    fn earlier_names_of_shapes_are_read_and_the_present_ones_are_written() {
        for (earlier, name) in [
            ("fine_35", "flake"),
            ("fine_60", "chip"),
            ("grain_500", "angular"),
            ("grain_640", "subangular"),
            ("grain_853", "worn"),
        ] {
            let stretched = |like: &str| json!({"elongation": 0.5, "flatness": 0.5, "like": like});
            for (given, written) in
                [(json!(earlier), json!(name)), (stretched(earlier), stretched(name))]
            {
                let shape: ShapeSource = from_value(given).expect("a shape");
                assert_eq!(to_value(&shape).expect("plain data"), written);
                assert_eq!(from_value::<ShapeSource>(written).expect("a shape"), shape);
            }
        }
    }
}
