//! What a match found: `match.json`.

use serde::{Deserialize, Serialize};

use super::discrepancy::Discrepancy;
use super::estimation::Parameter;
use super::facets::FacetModel;
use super::soil::On;
use super::warning::Warning;

/// The format's version, the value of `soilsig_match`.
pub const FORMAT: u32 = 1;

/// The result of a match.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Match {
    /// Version of the format: 1.
    pub soilsig_match: u32,
    /// The version of soilsig.
    pub soilsig: String,
    /// The measured spectrum: its file, without folder.
    pub spectrum: String,
    /// SHA-256 of that file.
    pub spectrum_sha256: String,
    /// What was observed: emissivity or radiance.
    pub observed: Quantity,
    /// Number of bands that were fitted.
    pub bands: usize,
    /// The first and the last of them, um.
    pub range_um: [f64; 2],
    /// Random seed of beds, order of the fines, paths and draws.
    pub seed: u64,
    /// The second component.
    pub second: SecondComponent,
    /// The beds that the model was made of.
    pub beds: Beds,
    /// The answer: the fit of the facet model that was asked for.
    pub answer: Fit,
    /// The other facet models, for comparison.
    pub other_facets: Vec<Fit>,
    /// The answer's facets with the second component at the other places.
    pub other_places: Vec<Fit>,
    /// Linear mixing of the same spectra by area, without and with a spectrally flat component.
    pub linear: Vec<Fit>,
    /// The answer's parameters from every other band: the even and the odd ones.
    pub halves: Vec<Fit>,
    /// The scene that represents the soil best.
    pub best: Option<Best>,
    /// What to mind.
    pub warnings: Vec<Warning>,
}

/// What was observed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Quantity {
    /// Emissivity.
    #[default]
    Emissivity,
    /// Radiance.
    Radiance,
}

/// The second component.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SecondComponent {
    /// Its spectrum; `flat` for a spectrally flat one.
    pub spectrum: String,
    /// Where it is.
    pub on: On,
}

/// The beds that the model was made of.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Beds {
    /// Covers of the steps in which each bed of full cover was thinned.
    pub thinned: Vec<Vec<f64>>,
    /// Covers of the beds that were dropped anew.
    pub fresh: Vec<f64>,
    /// What a fresh drop changes against thinning in place: the emissivity at 9 um, or at the band
    /// nearest to it, for each of these covers.
    pub fresh_less_thinned: Vec<f64>,
    /// Standard error of the model at the answer by the spread of beds: the mean over the bands.
    pub spread: f64,
}

/// The fit of a model.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Fit {
    /// The model in words.
    pub model: String,
    /// The facets, of a traced model.
    pub facets: Option<FacetModel>,
    /// The parameters.
    pub parameters: Vec<Fitted>,
    /// Covariance of the posterior, in the order of the parameters.
    pub covariance: Vec<Vec<f64>>,
    /// Averaging kernel, in the order of the parameters: rows are retrieved, columns true values.
    pub averaging_kernel: Vec<Vec<f64>>,
    /// Degrees of freedom for signal: the trace of the averaging kernel.
    pub degrees_of_freedom: f64,
    /// Root mean square of the residuals.
    pub rms: f64,
    /// The model discrepancy of the greatest evidence.
    pub discrepancy: Discrepancy,
    /// Chi-square of the residuals with the known errors alone: measurement, beds, spectra.
    pub known_errors: ChiSquare,
    /// The same with the discrepancy.
    pub with_discrepancy: ChiSquare,
    /// Logarithm of the evidence. Differences between models of the same bands count.
    pub ln_evidence: f64,
    /// Autocorrelation of the residuals by distance.
    pub autocorrelation: Vec<Autocorrelation>,
    /// Draws of the posterior are weighed: as many independent ones would tell as much.
    pub effective_draws: f64,
    /// The next best of the minima that the starts led to, if there are several.
    pub other_minimum: Option<OtherMinimum>,
    /// Whether the fit settled.
    pub converged: bool,
}

/// Another minimum of the sum of squares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OtherMinimum {
    /// The parameters, in their order.
    pub parameters: Vec<f64>,
    /// Root mean square of the residuals.
    pub rms: f64,
}

/// A parameter and what the bands say of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Fitted {
    /// The parameter and its prior.
    #[serde(flatten)]
    pub parameter: Parameter,
    /// Its value in the best fit.
    pub best: f64,
    /// Mean of its posterior.
    pub mean: f64,
    /// Standard deviation of its posterior.
    pub standard_error: f64,
    /// The posterior's 95 % interval.
    pub interval_95: [f64; 2],
    /// Its degrees of freedom for signal: 1 where the bands alone decide, 0 where the prior does.
    pub degrees_of_freedom: f64,
    /// Whether the best fit lies at a bound.
    pub at_bound: bool,
    /// Profile likelihood, where the 95 % interval comes near a bound.
    pub profile: Option<Profile>,
}

/// A profile likelihood.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Profile {
    /// Values of the parameter.
    pub values: Vec<f64>,
    /// Logarithm of the likelihood, with all others fitted, less its greatest.
    pub ln_likelihood: Vec<f64>,
}

/// A chi-square.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChiSquare {
    /// The sum of squares.
    pub value: f64,
    /// Bands less the degrees of freedom for signal.
    pub freedom: f64,
    /// Probability of a value as great or greater by chance.
    pub p: f64,
}

/// The correlation of residuals at a distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Autocorrelation {
    /// Mean distance, um.
    pub distance_um: f64,
    /// Correlation.
    pub correlation: f64,
}

/// The scene that represents the soil best, dropped and traced by the pipeline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Best {
    /// The recipe, below the result's folder.
    pub recipe: String,
    /// Cover of its bed, measured.
    pub cover: f64,
    /// Root mean square of the measured emissivity less the bed's.
    pub rms: f64,
    /// Mean of the fit less the bed's emissivity: what one bed differs from the model.
    pub bias: f64,
}
