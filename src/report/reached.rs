//! What a result says of itself, in numbers, for the record.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::histogram::tally::Kept;
use crate::radiometry::Method;
use crate::signature::budget::Share;
use crate::signature::plan::Plan;
use crate::spectrum::FacetSource;
use crate::spectrum::features::Features;
use crate::table::StopReason;
use crate::table::cover::Cover;
use crate::table::field::FieldSummary;
use crate::table::warning::Warning;

/// What a trace reached.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reached {
    /// Packings dropped and traced.
    pub packings: usize,
    /// How many packings the tolerance takes by a pilot, where that was asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<Plan>,
    /// Widest half-width of any band, emissivity, 95 %: of several packings with all that they differ by, of
    /// a single one the noise of its rays alone.
    pub half_width: f64,
    /// Where it is, um.
    pub widest_at_um: f64,
    /// Standard deviation between packings in that band.
    pub spread: Option<f64>,
    /// Share of the rays in the variance of that band's mean.
    pub rays_share: f64,
    /// What of the half-width paths that were given up leave open.
    pub trapped_half_width: f64,
    /// How many packings the tolerance needs, by their spread.
    pub packings_wanted: Option<usize>,
    /// Half-width asked for.
    pub tolerance: f64,
    /// Whether it was reached.
    pub tolerance_reached: bool,
    /// Paths traced.
    pub paths: u64,
    /// Where the reflectance of each material's facets comes from, and what that means.
    #[serde(default)]
    pub facets: BTreeMap<String, FacetSource>,
    /// Where the models of facets do not hold, from one wavelength to another, um.
    #[serde(default)]
    pub not_valid_um: Vec<[f64; 2]>,
    /// Share of the sensor's view that each material fills.
    pub seen_first: BTreeMap<String, f64>,
    /// What is seen of each prototype, the mean over packings.
    pub coverage: BTreeMap<String, Cover>,
    /// Share of paths that met nothing.
    pub missed: f64,
    /// Share of paths that left past the target's lower side.
    pub escaped_downward: f64,
    /// Share of paths given up.
    pub trapped: f64,
    /// What of each path's rules was kept.
    pub kept: Kept,
    /// What ended the trace of the first packing.
    pub ended_by: StopReason,
    /// Share of paths given up inside a solid; they are among the trapped.
    pub inside: f64,
    /// The field of the first packing, if there is one, and whether it is needed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<FieldSummary>,
    /// Where the uncertainty comes from, in the band where all of it is widest; `budget.csv` has every band.
    pub budget: Share,
    /// Materials whose spectra come without an error: their share is not in `budget.spectra`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spectra_unknown: Vec<String>,
    /// Most that any band's emissivity changes between a black and a white floor.
    pub floor_effect: Option<f64>,
    /// Warnings about the result.
    #[serde(default, skip_serializing_if = "Vec::is_empty", rename = "remarks")]
    pub warnings: Vec<Warning>,
    /// What can be had back from the radiance.
    pub retrieval: Retrieval,
    /// The curve's extrema and means.
    pub features: Features,
    /// How sure its means and its contrast are, by the spread between packings; `None` of a single packing.
    pub features_half_width: Option<FeatureErrors>,
}

/// What remote sensing would have of the emissivity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Retrieval {
    /// Amplification above which bands are masked.
    pub amplification_limit: f64,
    /// Bands that Eq. 2 tells nothing of, from the first to the last wavelength of each run, um.
    pub masked_um: Vec<[f64; 2]>,
    /// Why Eq. 2 is not exact in this scene; empty where it is.
    pub eq_2_not_exact: Vec<String>,
    /// Most that Eq. 2 differs from the emissivity in any band that is not masked.
    pub eq_2_difference: Option<f64>,
    /// The target's temperature by each method of separation, or why it has none.
    pub separation: BTreeMap<Method, Separation>,
}

/// What a method of temperature-emissivity separation gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Separation {
    /// A temperature, and how far Eq. 2 with it is from the emissivity.
    Found {
        /// The temperature, K.
        temperature_k: f64,
        /// Its standard error, K.
        temperature_standard_error_k: f64,
        /// Root mean square of Eq. 2 less the emissivity, over bands that are not masked.
        emissivity_rms: f64,
    },
    /// Why it gives none.
    Refused(String),
}

/// Half-widths of the 95 % intervals of numbers that many bands make, which err together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FeatureErrors {
    /// Of the contrast of the reststrahlen doublet.
    pub reststrahlen_contrast: Option<f64>,
    /// Of the mean emissivity over 8 to 9.5 um.
    pub mean_8_to_9p5_um: Option<f64>,
    /// Of the mean emissivity over 10 to 12 um.
    pub mean_10_to_12_um: Option<f64>,
}
