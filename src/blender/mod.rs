//! Finds Blender, runs the scripts of `blender_scripts/` in it, and reports failures as one error.
//!
//! Blender is its executable, or a Python that can import `bpy`. Both run the same scripts. A
//! script reports by JSON lines ([`Event`]). All other output of Blender goes into a log.

mod error;
mod event;
mod find;
mod known;
mod probe;
mod process;
mod run;
mod scripts;
mod version;
mod window;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

pub use error::BlenderError;
pub use event::{Event, Trouble};
pub use find::{Attempt, Outcome, PATIENCE, Search, find};
pub use run::Job;
pub use scripts::{SCRIPTS, sha256 as scripts_sha256};
pub use version::Version;
pub use window::write_addon;

/// How a Blender is started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The `blender` executable.
    Executable,
    /// A Python interpreter that can import `bpy`.
    PythonModule,
}

/// A usable Blender: its version is supported, and its Python has numpy.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Blender {
    /// How it is started.
    pub kind: Kind,
    /// The executable, or the Python interpreter.
    pub path: PathBuf,
    /// Blender's version.
    pub version: Version,
    /// The version of the Python inside, such as `3.11.2`.
    pub python: String,
    /// The version of its numpy, such as `1.24.2`.
    pub numpy: String,
}

impl Blender {
    /// A warning for the user, if the version is not tested.
    pub fn warning(&self) -> Option<String> {
        (!self.version.is_tested()).then(|| {
            format!(
                "Blender {} is not a tested version (tested: {})",
                self.version,
                Version::tested_list()
            )
        })
    }
}
