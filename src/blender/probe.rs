//! Asks an executable for its Blender.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde::Deserialize;

use super::process::{self, Ending};
use super::run::{Scratch, does_not_start, last_words, run_logged};
use super::{Blender, BlenderError, Event, Kind, Version};
use crate::support::monitor::Monitor;

/// Starts a Blender and asks for its versions.
pub(super) fn probe(
    kind: Kind,
    path: &Path,
    patience: Duration,
    monitor: &dyn Monitor,
) -> Result<Blender, BlenderError> {
    let scratch = Scratch::new()?;
    let log = scratch.log();
    let mut answer = None;
    let command = scratch.command(kind, path, "probe.py");
    let ending = run_logged(path, command, &log, patience, monitor, &mut |event| {
        if let Event::Probe { blender, python, numpy } = event {
            answer = Some((blender, python, numpy));
        }
    })?;
    ending.exit_code(path, patience, None)?;
    let path = path.to_owned();
    let Some((version, python, numpy)) = answer else { return Err(no_answer(path, &log)) };
    let version = match version.parse::<Version>() {
        Err(reason) => return Err(BlenderError::Unusable { path, reason }),
        Ok(version) if !version.is_supported() => {
            return Err(BlenderError::Unsupported { path, version });
        }
        Ok(version) => version,
    };
    match numpy {
        Some(numpy) => Ok(Blender { kind, path, version, python, numpy }),
        None => Err(BlenderError::NumpyMissing { kind, path }),
    }
}

/// The error of a program that did not answer. A Blender whose Python is too old for the script
/// still prints its version.
fn no_answer(path: PathBuf, log: &Path) -> BlenderError {
    let text = fs::read(log).unwrap_or_default();
    let version = String::from_utf8_lossy(&text)
        .lines()
        .find_map(|line| line.strip_prefix("Blender ")?.parse::<Version>().ok())
        .filter(|version| !version.is_supported());
    match version {
        Some(version) => BlenderError::Unsupported { path, version },
        None => BlenderError::Unusable { path, reason: last_words(log) },
    }
}

/// The answer of a Python.
#[derive(Debug, Deserialize)]
pub(super) struct Python {
    /// The interpreter itself: pyenv and others put a script in its place.
    pub(super) interpreter: PathBuf,
    /// The main file of the module `bpy`, if there is one.
    pub(super) bpy: Option<PathBuf>,
}

/// Asks a Python for its `bpy`, without importing it; `None` if the Python gives no answer.
pub(super) fn python(
    path: &Path,
    patience: Duration,
    monitor: &dyn Monitor,
) -> Result<Option<Python>, BlenderError> {
    const QUESTION: &str = "import importlib.util, json, sys; \
        bpy = importlib.util.find_spec('bpy'); \
        print(json.dumps({'interpreter': sys.executable, 'bpy': bpy and bpy.origin}))";
    let mut command = Command::new(path);
    command.args(["-c", QUESTION]).env_remove("PYTHONPATH").env_remove("PYTHONHOME");
    let mut text = Vec::new();
    let mut on_line = |line: &[u8]| text.extend_from_slice(line);
    let ending = File::options()
        .write(true)
        .open("/dev/null")
        .and_then(|errors| process::supervise(command, &errors, patience, monitor, &mut on_line))
        .map_err(|source| does_not_start(path, &source))?;
    // A Python that is too old for the question, or a shim without a version, has no bpy either.
    if !matches!(ending, Ending::Crashed(_)) {
        ending.exit_code(path, patience, None)?;
    }
    Ok(serde_json::from_slice(&text).ok())
}
