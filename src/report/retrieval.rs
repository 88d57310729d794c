//! What remote sensing would retrieve from the radiance of a scene, by Eq. 2.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::radiometry::{Assumed, Method, Retrieved, masked_in_words, masked_um, separate};
use crate::signature::{Band, retrieve};
use crate::table::Table;

/// Results of Eq. 2 for a known and for an unknown temperature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Retrieval {
    /// Amplification above which bands are masked.
    pub amplification_limit: f64,
    /// Masked bands: the first and the last of each run, um.
    pub masked_um: Vec<[f64; 2]>,
    /// Why Eq. 2 is not exact in this scene; empty where it is.
    pub eq_2_not_exact: Vec<String>,
    /// Largest difference between Eq. 2 and the emissivity in any band that is not masked.
    pub eq_2_difference: Option<f64>,
    /// The target's temperature by each method of separation, or why it has none.
    pub separation: BTreeMap<Method, Separation>,
}

/// The result of a method of temperature-emissivity separation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Separation {
    /// A temperature, and the error of Eq. 2 with it.
    Found {
        /// The temperature, K.
        temperature_k: f64,
        /// Its standard error, K.
        temperature_standard_error_k: f64,
        /// Root mean square of Eq. 2 less the emissivity, over bands that are not masked, if any.
        emissivity_rms: Option<f64>,
    },
    /// Why it gives none.
    Refused(String),
}

impl Retrieval {
    /// From the bands of a scene.
    pub fn new(table: &Table, bands: &[Band], assumed: Assumed) -> Self {
        let known = retrieve(bands, table.temperature(), assumed);
        let differences = |retrieved: &[Retrieved]| -> Vec<f64> {
            let both = retrieved.iter().zip(bands);
            both.filter_map(|(r, b)| r.emissivity.map(|[e, _]| e - b.emissivity.mean)).collect()
        };
        let measured: Vec<_> = bands.iter().map(Band::measured).collect();
        let by = |method| match separate(method, &measured, assumed) {
            Err(error) => Separation::Refused(error.to_string()),
            Ok(temperature) => {
                let off = differences(&retrieve(bands, temperature, assumed));
                let squares: f64 = off.iter().map(|d| d * d).sum();
                Separation::Found {
                    temperature_k: temperature.k,
                    temperature_standard_error_k: temperature.error_k,
                    emissivity_rms: (!off.is_empty()).then(|| (squares / off.len() as f64).sqrt()),
                }
            }
        };
        Self {
            amplification_limit: assumed.amplification_limit,
            masked_um: masked_um(&known),
            eq_2_not_exact: table.eq_2_not_exact(),
            eq_2_difference: differences(&known).into_iter().map(f64::abs).reduce(f64::max),
            separation: Method::ALL.into_iter().map(|method| (method, by(method))).collect(),
        }
    }

    /// Lines on the bands that are masked and on what makes Eq. 2 inexact, if anything.
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> =
            masked_in_words(&self.masked_um, self.amplification_limit).into_iter().collect();
        if !self.eq_2_not_exact.is_empty() {
            let reasons = self.eq_2_not_exact.join(" and ");
            let by = self.eq_2_difference;
            let by = by.map_or(String::new(), |d| {
                format!("; it differs from the emissivity by up to {d:.4}")
            });
            lines.push(format!("Eq. 2 is not exact here, since {reasons}{by}"));
        }
        lines
    }
}
