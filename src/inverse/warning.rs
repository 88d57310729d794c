//! What a user has to mind of a match.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::support::linear::span;

/// A warning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Warning {
    /// No parameter makes the fit good.
    NoGoodFit {
        /// Root mean square of the residuals.
        rms: f64,
        /// Where they are largest, um.
        bands_um: Vec<[f64; 2]>,
    },
    /// The bands do not tell two parameters apart.
    Correlated {
        /// One parameter.
        one: String,
        /// The other.
        other: String,
        /// Their correlation.
        correlation: f64,
    },
    /// The bands tell less of a parameter than its prior does.
    NotTold {
        /// The parameter.
        parameter: String,
        /// Its degrees of freedom.
        degrees_of_freedom: f64,
    },
    /// A parameter is at its bound.
    AtBound {
        /// The parameter.
        parameter: String,
        /// The bound.
        bound: f64,
    },
    /// Another model of facets, or another place of the second component, gives another cover.
    ModelsDiffer {
        /// The other model.
        model: String,
        /// Its cover and its standard error.
        cover: [f64; 2],
    },
    /// Half of the bands give another cover.
    HalvesDiffer {
        /// The covers.
        covers: [f64; 2],
    },
    /// Fits from other starts end in another minimum that is nearly as good.
    SeveralMinima {
        /// Its cover.
        cover: f64,
        /// Its root mean square.
        rms: f64,
    },
    /// Few draws carry most of the posterior's weight.
    FewDraws {
        /// As many independent draws would tell as much.
        effective: f64,
    },
    /// Linear mixing fits better.
    LinearIsBetter {
        /// Its root mean square.
        rms: f64,
    },
}

/// The name of a parameter for people.
pub fn named(parameter: &str) -> &str {
    match parameter {
        "cover" => "cover with fines",
        "second" => "second component",
        "level" => "its emissivity",
        "large_fines" => "large fines",
        "medium_grains" => "medium grains",
        "flat" => "flat component",
        other => other,
    }
}

/// The same where no second component is named before it.
fn alone(parameter: &str) -> &str {
    match parameter {
        "level" => "emissivity of the second component",
        other => named(other),
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoGoodFit { rms, bands_um } => {
                let bands: Vec<String> = bands_um.iter().map(|&run| span(run)).collect();
                let bands = bands.join(", ");
                write!(
                    f,
                    "no values of the parameters fit well: RMS {rms:.3}. The fit misses by more than \
                     0.03 at {bands} um: the soil has something that the model has not"
                )
            }
            Self::Correlated { one, other, correlation } => write!(
                f,
                "these bands do not tell {} and {} apart (correlation {correlation:.2}): give one \
                 of them with --prior {one}=VALUE or --prior {other}=VALUE",
                alone(one),
                alone(other)
            ),
            Self::NotTold { parameter, degrees_of_freedom } => write!(
                f,
                "these bands do not tell the {}: {:.0} % of its value comes from its prior",
                alone(parameter),
                100.0 * (1.0 - degrees_of_freedom)
            ),
            Self::AtBound { parameter, bound } => write!(
                f,
                "the best fit has the {} at its bound of {bound:.3}: read its interval one-sided",
                alone(parameter)
            ),
            Self::ModelsDiffer { model, cover: [cover, error] } => write!(
                f,
                "another model gives another cover: {model}, {cover:.2} +- {error:.2}; that is \
                 beyond the errors of both"
            ),
            Self::HalvesDiffer { covers: [even, odd] } => write!(
                f,
                "every other band gives a cover of {even:.2}, the rest {odd:.2}: the answer \
                 depends on the bands"
            ),
            Self::SeveralMinima { cover, rms } => write!(
                f,
                "a cover of {cover:.2} fits nearly as well (RMS {rms:.3}): the errors do not hold it"
            ),
            Self::FewDraws { effective } => write!(
                f,
                "the errors come from {effective:.0} effective draws only: they are uncertain by \
                 {:.0} %",
                100.0 / (2.0 * effective).sqrt()
            ),
            Self::LinearIsBetter { rms } => write!(
                f,
                "linear mixing with a flat component fits better than the traced model: RMS {rms:.3}"
            ),
        }
    }
}
