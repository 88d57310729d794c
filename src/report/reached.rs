//! The numbers of a result, for the record.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Retrieval;
use crate::histogram::kept::Kept;
use crate::scene::SoilShares;
use crate::signature::Window;
use crate::signature::budget::Share;
use crate::signature::plan::Plan;
use crate::spectrum::FacetSource;
use crate::spectrum::features::Features;
use crate::support::error::Status;
use crate::table::StopReason;
use crate::table::cover::Cover;
use crate::table::field::FieldSummary;
use crate::table::warning::Warning;

/// The numbers of a scene's result. Half-widths are those of 95 % intervals in emissivity.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Reached {
    /// Mean emissivity over windows of wavelengths, with the total uncertainty.
    #[serde(default)]
    pub windows: Vec<Window>,
    /// Packings dropped and traced; one that is there as hulls and with fines that touch counts once.
    pub packings: usize,
    /// How many packings the tolerance takes, in a planned run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<Plan>,
    /// Widest half-width of any band, of what the tolerance is asked of.
    pub half_width: f64,
    /// The band of it, um.
    pub widest_at_um: f64,
    /// Standard deviation between packings in that band.
    pub spread: Option<f64>,
    /// Share of the rays in the variance of that band's mean.
    pub rays_share: f64,
    /// Part of the half-width that given-up paths leave open.
    pub trapped_half_width: f64,
    /// Packings that the tolerance takes, by their spread.
    pub packings_wanted: Option<usize>,
    /// Half-width asked for.
    pub tolerance: f64,
    /// What it is asked of.
    #[serde(default)]
    pub tolerance_of: ToleranceOf,
    /// Whether it was reached.
    pub tolerance_reached: bool,
    /// Paths traced.
    pub paths: u64,
    /// Source of the reflectance of each material's facets, and its meaning for the result.
    #[serde(default)]
    pub facets: BTreeMap<String, FacetSource>,
    /// Where the models of facets do not hold: the first and the last band of each run, um.
    #[serde(default)]
    pub not_valid_um: Vec<[f64; 2]>,
    /// Share of the sensor's view that each material fills.
    pub seen_first: BTreeMap<String, f64>,
    /// Materials of each prototype's silhouette, the mean over packings.
    pub coverage: BTreeMap<String, Cover>,
    /// Share of paths that met nothing.
    pub missed: f64,
    /// Share of paths that left past the target's lower side.
    pub escaped_downward: f64,
    /// Share of paths given up.
    pub trapped: f64,
    /// What was recorded of each path.
    pub kept: Kept,
    /// The end of the trace of the first packing.
    pub ended_by: StopReason,
    /// Share of paths given up inside a solid; `trapped` includes them.
    pub inside: f64,
    /// The field of the first packing, if there is one, and whether it is needed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<FieldSummary>,
    /// The budget of the band with the widest total; `budget.csv` has every band.
    pub budget: Share,
    /// Materials whose spectra have an error that is not, or not wholly, known. `budget.spectra`
    /// holds the known part.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spectra_unknown: Vec<String>,
    /// Largest change of any band's emissivity between a black and a white floor.
    pub floor_effect: Option<f64>,
    /// Warnings.
    #[serde(default, skip_serializing_if = "Vec::is_empty", rename = "remarks")]
    pub warnings: Vec<Warning>,
    /// Results of Eq. 2.
    pub retrieval: Retrieval,
    /// The shares of the soil that the scene states, if it does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub soil: Option<SoilShares>,
    /// Why Blender refused beds of a planned run, and which beds stand for them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// The curve's extrema and means.
    pub features: Features,
    /// Half-widths of features by the spread between packings; `None` for a single packing.
    pub features_half_width: Option<FeatureErrors>,
}

/// What a tolerance is asked of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ToleranceOf {
    /// The 95 % interval of the rays and, of several packings, of their spread.
    #[default]
    Interval,
    /// The total, bounds included.
    Total,
    /// The rays of each packing alone: a number of packings was asked for, and no tolerance.
    Rays,
}

impl Reached {
    /// The exit status of a result below its tolerance. A number of paths asked for has no
    /// tolerance.
    pub fn status(&self) -> Option<Status> {
        let enough = self.tolerance_reached || self.ended_by == StopReason::Paths;
        (!enough).then_some(Status::ToleranceNotReached)
    }

    /// Whether the beds are draws of a recipe, so that others differ.
    pub(super) fn is_drawn(&self) -> bool {
        self.budget.facets.is_some()
    }
}

/// Half-widths of numbers that many bands make together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FeatureErrors {
    /// Contrast of the reststrahlen doublet.
    pub reststrahlen_contrast: Option<f64>,
    /// Mean emissivity over 8 to 9.5 um.
    pub mean_8_to_9p5_um: Option<f64>,
    /// Mean emissivity over 10 to 12 um.
    pub mean_10_to_12_um: Option<f64>,
}
