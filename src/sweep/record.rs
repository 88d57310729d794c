//! `sweep.json`: what was done, from which files, and the result; enough to repeat the sweep.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::study::Study;
use crate::pipeline::MOST_SECONDS;
use crate::pipeline::record::Output;
use crate::support::error::{Failure, Status};
use crate::support::file_error::FileError;

/// The format's version, the value of `soilsig_sweep`.
pub(super) const FORMAT: u32 = 1;

/// The record's file.
pub const SWEEP: &str = "sweep.json";

/// A finished sweep.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Sweep {
    /// Version of the format: 1.
    pub soilsig_sweep: u32,
    /// The command line.
    pub command: Vec<String>,
    /// The study file.
    pub study_file: PathBuf,
    /// What it asked for.
    pub study: Study,
    /// Longest that Blender may take for a bed, seconds.
    pub blender_timeout_s: u64,
    /// soilsig and, where it ran, Blender, its Python and numpy; SHA-256 of its scripts.
    pub versions: BTreeMap<String, String>,
    /// Files read, by path, with their SHA-256.
    pub inputs: BTreeMap<String, String>,
    /// Files written, by path below the result's folder. `beds.csv` has the sums of all tables.
    pub outputs: BTreeMap<String, Output>,
    /// Points of the study.
    pub points: usize,
    /// Beds that are finished.
    pub beds: usize,
    /// Beds that failed; `failures.csv` lists them.
    pub failed: usize,
    /// Points whose tolerance was not reached.
    pub above_tolerance: usize,
}

/// A record cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("the record of a sweep: {0}")]
pub struct SweepError(#[from] FileError);

impl Failure for SweepError {}

impl Sweep {
    /// Reads a record.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        let text = fs::read_to_string(path).map_err(FileError::read(path))?;
        let record: Self = serde_json::from_str(&text)
            .map_err(|error| FileError::wrong(path, error.to_string()))?;
        let problem = if record.soilsig_sweep != FORMAT {
            let version = record.soilsig_sweep;
            Some(format!("version {version} is not known; this program reads {FORMAT}"))
        } else if !(1..=MOST_SECONDS).contains(&record.blender_timeout_s) {
            Some(format!("blender_timeout_s is not 1 to {MOST_SECONDS}"))
        } else {
            None
        };
        problem.map_or(Ok(record), |problem| Err(FileError::wrong(path, problem).into()))
    }
}

/// What a sweep came to.
#[derive(Debug, Clone)]
pub struct Ended {
    /// The record, unless only a part of the study was asked for.
    pub record: Option<Sweep>,
    /// What it came to, in a sentence.
    pub answer: String,
    /// Beds that failed, with the reasons.
    pub failed: Vec<String>,
}

impl Ended {
    /// The exit status of a sweep that is less than was asked for.
    pub fn status(&self) -> Option<Status> {
        if !self.failed.is_empty() {
            return Some(Status::BedsFailed);
        }
        let above = self.record.as_ref().is_some_and(|record| record.above_tolerance > 0);
        above.then_some(Status::ToleranceNotReached)
    }
}
