//! `run.json`: what was done, with what, and what came out; enough to do it again.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::pipeline::Options;
use crate::report::{Reached, terminal};
use crate::support::error::{Error, Failure};
use crate::support::output;

/// The format's version, the value of `soilsig_run`.
pub const FORMAT: u32 = 1;

/// A record cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be read.
    #[error("cannot read the record {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a record.
    #[error("{}: {source}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// A value is out of its range.
    #[error("{}: {problem}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
}

/// One run of the pipeline.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Version of the format: 1.
    pub soilsig_run: u32,
    /// The command line.
    pub command: Vec<String>,
    /// What was asked, all of it.
    pub options: Options,
    /// soilsig and, where it ran, Blender, its Python and numpy; SHA-256 of shipped scenes and scripts.
    pub versions: BTreeMap<String, String>,
    /// Every seed used, by what it was for.
    pub seeds: BTreeMap<String, u64>,
    /// Files read, by path, with their SHA-256.
    pub inputs: BTreeMap<String, String>,
    /// Files written, by path below the result's folder.
    pub outputs: BTreeMap<String, Output>,
    /// The stages in their order.
    pub stages: Vec<Stage>,
    /// What was reached, by scene.
    pub reached: BTreeMap<String, Reached>,
}

/// A file written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// SHA-256 of its content.
    pub sha256: String,
    /// Whether the same run gives the same bytes. Logs, reports with timings and Blender's own file
    /// do not.
    pub reproducible: bool,
}

/// A stage of the pipeline.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// Its name.
    pub name: String,
    /// Wall time, seconds.
    pub seconds: f64,
    /// Whether the result was there already.
    pub cached: bool,
}

impl Failure for RecordError {}

impl Record {
    /// Reads a record.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let text = fs::read_to_string(path)
            .map_err(|source| RecordError::Read { path: path.to_owned(), source })?;
        let record: Self = serde_json::from_str(&text)
            .map_err(|source| RecordError::Form { path: path.to_owned(), source })?;
        let Options { tolerance, .. } = record.options;
        let problem = if record.soilsig_run != FORMAT {
            format!("version {} is not known; this program reads {FORMAT}", record.soilsig_run)
        } else if !(tolerance > 0.0 && tolerance < 1.0) {
            format!("a tolerance of {tolerance} is not above 0 and below 1")
        } else {
            return Ok(record);
        };
        Err(RecordError::Value { path: path.to_owned(), problem })
    }

    /// Writes the record.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let mut text = serde_json::to_string_pretty(self).expect("plain data");
        text.push('\n');
        Ok(output::bytes(path, text.as_bytes())?)
    }

    /// Whether every tolerance was reached.
    pub fn tolerance_reached(&self) -> bool {
        self.reached.values().all(|reached| reached.tolerance_reached)
    }
}

/// A run.
pub fn in_words(record: &Record, out: &Path) -> String {
    let mut text = String::new();
    for (name, of) in &record.reached {
        let _ = write!(text, "{name}: {}", terminal::reached(of));
    }
    if let Some(advice) = advice(record) {
        let _ = writeln!(text, "{advice}");
    }
    let seconds: f64 = record.stages.iter().map(|stage| stage.seconds).sum();
    let _ = writeln!(text, "Result in {} ({seconds:.1} s)", out.display());
    text
}

/// What it would cost to narrow the interval of a single scene by a tenth, by packings and by rays, where
/// this run shows what both cost.
fn advice(record: &Record) -> Option<String> {
    let reached = record.reached.values().next().filter(|_| record.reached.len() == 1)?;
    let seconds = |name: &str| {
        let stage = record.stages.iter().find(|stage| stage.name == name)?;
        (!stage.cached).then_some(stage.seconds)
    };
    let (drop, trace) = (seconds("drop")?, seconds("trace")?);
    if reached.packings < 2 || reached.plan.is_some() {
        return None;
    }
    // A tenth narrower is .81 of the variance, of which more rays can only take what is theirs.
    let by_packings = (1.0 / 0.81 - 1.0) * (drop + trace);
    let beyond = reached.rays_share - 0.19;
    let by_rays = (beyond > 0.0).then(|| trace * (reached.rays_share / beyond - 1.0));
    Some(match by_rays {
        None => format!(
            "A tenth narrower: {by_packings:.1} s of further packings; more rays alone cannot do it."
        ),
        Some(by_rays) => format!(
            "A tenth narrower: {by_packings:.1} s of further packings, or {by_rays:.1} s of further rays."
        ),
    })
}
