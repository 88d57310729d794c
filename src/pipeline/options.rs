//! The options of a run of the pipeline.

use std::fmt::Display;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::histogram::estimate;
use crate::report::ToleranceOf;
use crate::scene::{Change, Facets, Grid, MOST_PARTICLES, SceneGeometry};
use crate::table::Target;

/// Longest time limit of a Blender, seconds: some thirty years.
pub const MOST_SECONDS: u64 = 1_000_000_000;

/// Half-width to which each planned bed is traced. Coarser rays would hide what touching fines
/// change and cost more beds than they save.
const RAYS_OF_PLANNED: f64 = 0.0012;

/// What is run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Source {
    /// A shipped scene by its coverage: `full`, `less`, `sparse`, `bare`; `all` of them; or the
    /// share of the grains' silhouettes to be covered with fines, 0 to 1.
    Coverage(String),
    /// A scene file, packing or placed.
    Scene(PathBuf),
}

/// Everything that a run depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Options {
    /// The scene.
    pub source: Source,
    /// Values that replace the scene's, each as `KEY=VALUE`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>"))]
    pub set: Vec<Change>,
    /// What the spectra of powders give to facets; `None` leaves the scene as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facets: Option<Facets>,
    /// The user's grains, which replace the shapes that they stand for.
    #[serde(default)]
    pub grains: Option<PathBuf>,
    /// A seed that replaces the scene's, of packing and rays both.
    pub seed: Option<u64>,
    /// How many packings are dropped. Of a placed scene this does not count.
    pub packings: HowMany,
    /// Particles of the field that each packing is a patch of; `None` for mirror sides.
    pub field: Option<f64>,
    /// Half-width that every band is to reach: the total where packings are planned, else the 95 %
    /// interval of the rays and, of several packings, of their spread. `None` for rays to 0.005.
    pub tolerance: Option<f64>,
    /// Most paths for a packing.
    pub max_paths: u64,
    /// Longest that the trace of a packing may take, seconds.
    #[serde(default)]
    pub max_seconds: Option<f64>,
    /// The bands.
    pub grid: Grid,
    /// Whether the settled patch is also exported flat.
    pub patch_obj: bool,
    /// The Blender to use.
    pub blender: Option<PathBuf>,
    /// Longest that Blender may take, seconds.
    pub blender_timeout_s: u64,
}

/// Half-width of the rays where no other is asked for.
pub const TOLERANCE: f64 = 0.005;

impl Options {
    /// What is wrong with options that another hand wrote, if anything is: the command line takes
    /// no such numbers.
    pub fn problem(&self) -> Option<String> {
        let Self { packings, field, tolerance, max_paths, max_seconds, blender_timeout_s, .. } =
            self;
        let wrong = |what: &str, value: &dyn Display, range: &str| {
            Some(format!("{what} is {value}, which is not {range}"))
        };
        match packings {
            HowMany::Number(n) if !(1..=estimate::MOST).contains(n) => {
                return wrong("packings", n, &format!("1 to {}", estimate::MOST));
            }
            _ => {}
        }
        if let Some(n) = field.filter(|n| !(1.0..=MOST_PARTICLES).contains(n)) {
            wrong("field", &n, &format!("1 to {MOST_PARTICLES:e}"))
        } else if let Some(x) = tolerance.filter(|x| !(*x > 0.0 && *x < 1.0)) {
            wrong("tolerance", &x, "above 0 and below 1")
        } else if *max_paths < 2 {
            wrong("max_paths", max_paths, "2 or more")
        } else if let Some(s) = max_seconds.filter(|s| !(*s > 0.0 && s.is_finite())) {
            wrong("max_seconds", &s, "above 0")
        } else if !(1..=MOST_SECONDS).contains(blender_timeout_s) {
            wrong("blender_timeout_s", blender_timeout_s, &format!("1 to {MOST_SECONDS}"))
        } else {
            None
        }
    }

    /// The tolerance asked for, else that of the rays.
    pub(super) fn tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(TOLERANCE)
    }

    /// What the tolerance is asked of. Nobody asks beds of a given number to agree unless a tolerance
    /// is named.
    pub(super) fn tolerance_of(&self, geometry: &SceneGeometry) -> ToleranceOf {
        match (self.packings, geometry) {
            (HowMany::Planned(_), SceneGeometry::Packing(_)) => ToleranceOf::Total,
            (HowMany::Number(2..), SceneGeometry::Packing(_)) if self.tolerance.is_none() => {
                ToleranceOf::Rays
            }
            _ => ToleranceOf::Interval,
        }
    }

    /// The target of the trace of each of several beds. The rays of all together make at most half
    /// of the tolerance, since the spread between beds needs the rest. Of planned beds it does not
    /// depend on their number, so that none is traced twice: rays are cheap beside a drop, and
    /// more beds lessen their noise as well. Where light passes through grains rays cost more than a
    /// drop.
    pub(super) fn target(&self, beds: usize, is_planned: bool, refracts: bool) -> Target {
        let Self { max_paths, max_seconds, .. } = *self;
        let target = match (is_planned, refracts) {
            (true, false) => Target::of(self.tolerance().min(RAYS_OF_PLANNED)),
            (true, true) => Target::of(self.tolerance()),
            (false, _) => target_of(self.tolerance(), beds),
        };
        Target { max_paths, max_seconds, ..target }
    }
}

/// The target of the trace of each of several beds, of which the mean is to reach a tolerance. The
/// rays of all together make at most half of it, since the spread between beds needs the rest.
pub(crate) fn target_of(tolerance: f64, beds: usize) -> Target {
    let of_each = match beds {
        1 => tolerance,
        n => (tolerance * (n as f64).sqrt() / 2.0).min(0.5),
    };
    // Given-up paths leave the same open in every bed: more beds do not lessen it.
    Target { tolerance: of_each, ..Target::of(tolerance) }
}

/// How many packings are dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "packings is a whole number or \"auto\"")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum HowMany {
    /// This number.
    Number(usize),
    /// As many as the tolerance takes.
    Planned(Auto),
}

/// The word for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Auto {
    /// As many as the tolerance takes.
    Auto,
}
