//! A bed of a study, and where its files are kept.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::pipeline::TABLE;
use crate::support::error::{Error, Status};
use crate::table::Table;

/// Folder of finished beds below that of the results.
pub(super) const BEDS: &str = "beds";
/// Folder of the records of failures.
pub(super) const FAILED: &str = "failed";
pub(super) const SIGNATURE: &str = "signature.csv";

/// A bed of a study: a point and a seed.
pub struct Bed {
    /// The point.
    pub point: usize,
    /// The seed.
    pub seed: u64,
    /// SHA-256 of all that its table depends on, cut short: the name of its folder.
    pub id: String,
}

/// Why a bed has no table.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FailedBed {
    /// Exit status that a run of this bed alone would have.
    pub status: u8,
    /// What happened.
    pub reason: String,
    /// What to do about it.
    pub hint: Option<String>,
}

impl FailedBed {
    /// Whether another try may end otherwise.
    pub(super) fn may_pass(&self) -> bool {
        ![Status::BlenderRefused as u8, Status::Input as u8].contains(&self.status)
    }
}

/// The folder of a bed's files, below the folder of the results.
pub(super) fn folder_of(id: &str) -> PathBuf {
    // No folder has more entries than file systems like.
    Path::new(BEDS).join(&id[..2]).join(&id[2..])
}

/// Where its failure is recorded, below the folder of the results.
pub(super) fn failure_of(id: &str) -> PathBuf {
    Path::new(FAILED).join(format!("{id}.json"))
}

/// The failure of a bed, if it is recorded.
pub(super) fn failure(out: &Path, id: &str) -> Option<FailedBed> {
    serde_json::from_slice(&fs::read(out.join(failure_of(id))).ok()?).ok()
}

/// The table of a finished bed; `None` where it is not there.
pub(super) fn table(out: &Path, id: &str) -> Result<Option<Table>, Error> {
    let path = out.join(folder_of(id)).join(TABLE);
    match fs::symlink_metadata(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        _ => Ok(Some(Table::read(&path)?)),
    }
}
