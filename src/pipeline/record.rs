//! `run.json`: what was done, from which files, and the result; enough to repeat the run.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::pipeline::Options;
use crate::report::{Cost, Reached};
use crate::support::error::{Failure, Status};
use crate::support::file_error::FileError;

/// The format's version, the value of `soilsig_run`.
const FORMAT: u32 = 1;

/// A record cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("the record of a run: {0}")]
pub struct RecordError(#[from] FileError);

impl Failure for RecordError {}

/// One run of the pipeline.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Record {
    /// Version of the format: 1.
    pub soilsig_run: u32,
    /// The command line.
    pub command: Vec<String>,
    /// All options.
    pub options: Options,
    /// soilsig, the processor and, where it ran, Blender, its Python and numpy; SHA-256 of shipped
    /// scenes and scripts.
    pub versions: BTreeMap<String, String>,
    /// Every seed, by its use.
    pub seeds: BTreeMap<String, u64>,
    /// Files read, by path, with their SHA-256.
    pub inputs: BTreeMap<String, String>,
    /// Files written, by path below the result's folder.
    pub outputs: BTreeMap<String, Output>,
    /// The stages in their order.
    pub stages: Vec<Stage>,
    /// The numbers of each scene's result.
    pub reached: BTreeMap<String, Reached>,
}

/// A file written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Stage {
    /// Its name.
    pub name: String,
    /// Wall time, seconds.
    pub seconds: f64,
    /// Whether the result came from the cache.
    pub cached: bool,
}

/// The processor of this machine.
pub fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = line.map_or("", |(_, model)| model.trim());
    format!("{} {model}", std::env::consts::ARCH).trim_end().to_owned()
}

impl Record {
    /// The record of a run that begins.
    pub(super) fn new(command: Vec<String>, options: &Options) -> Self {
        let version = env!("CARGO_PKG_VERSION").into();
        Self {
            soilsig_run: FORMAT,
            command,
            options: options.clone(),
            versions: BTreeMap::from([
                ("soilsig".into(), version),
                ("processor".into(), processor()),
            ]),
            seeds: BTreeMap::new(),
            inputs: BTreeMap::new(),
            outputs: BTreeMap::new(),
            stages: Vec::new(),
            reached: BTreeMap::new(),
        }
    }

    /// Reads a record.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let text = fs::read_to_string(path).map_err(FileError::read(path))?;
        let record: Self = serde_json::from_str(&text)
            .map_err(|error| FileError::wrong(path, error.to_string()))?;
        let problem = if record.soilsig_run == FORMAT {
            record.options.problem()
        } else {
            Some(format!(
                "version {} is not known; this program reads {FORMAT}",
                record.soilsig_run
            ))
        };
        match problem {
            None => Ok(record),
            Some(problem) => Err(FileError::wrong_at(path, "options", problem).into()),
        }
    }

    /// The exit status, if a scene did not reach its tolerance.
    pub fn status(&self) -> Option<Status> {
        self.reached.values().find_map(Reached::status)
    }

    /// The time that the drop and the trace of a scene took, if both ran.
    pub fn cost(&self, scene: &str) -> Option<Cost> {
        let seconds = |name: &str| {
            let of_scene = format!("{scene}/{name}");
            let is_it = |stage: &&Stage| stage.name == name || stage.name == of_scene;
            self.stages.iter().find(is_it).filter(|stage| !stage.cached).map(|s| s.seconds)
        };
        Some(Cost { drop_s: seconds("drop")?, trace_s: seconds("trace")? })
    }
}
