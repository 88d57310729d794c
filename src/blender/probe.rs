//! Asks an executable whether it is a Blender that will do.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde::Deserialize;

use super::process::{self, Ending};
use super::run::{Scratch, does_not_start, last_words, run_logged};
use super::{Blender, BlenderError, Event, Kind, Version};
use crate::support::monitor::Monitor;

/// Starts a Blender to ask what it is.
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
    let ending = run_logged(command, &log, patience, monitor, &mut |event| {
        if let Event::Probe { blender, python, numpy } = event {
            answer = Some((blender, python, numpy));
        }
    })?
    .map_err(|source| does_not_start(path, &source))?;

    let path = path.to_owned();
    match ending {
        Ending::Interrupted => return Err(BlenderError::Interrupted),
        Ending::TimedOut => {
            return Err(BlenderError::Timeout { path, limit: patience, log: None });
        }
        Ending::Crashed(signal) => return Err(BlenderError::Crash { path, signal, log: None }),
        Ending::Exited(_) => {}
    }
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

/// Why there is no answer: a Blender whose Python is too old for the script still says its
/// version when it starts.
fn no_answer(path: PathBuf, log: &Path) -> BlenderError {
    let text = fs::read(log).unwrap_or_default();
    let version = String::from_utf8_lossy(&text)
        .lines()
        .find_map(|line| line.strip_prefix("Blender ")?.parse::<Version>().ok())
        .filter(|version| !version.is_supported());
    match (version, last_words(log)) {
        (Some(version), _) => BlenderError::Unsupported { path, version },
        (None, Some(words)) => {
            BlenderError::Unusable { path, reason: format!("it says \"{words}\"") }
        }
        (None, None) => BlenderError::Unusable { path, reason: "it says nothing".into() },
    }
}

/// A Python that has `bpy`.
#[derive(Debug)]
pub(super) struct PythonWithBpy {
    /// The interpreter itself: pyenv and others put scripts in its place.
    pub(super) interpreter: PathBuf,
    /// The module's main file.
    pub(super) bpy: PathBuf,
}

/// Asks a Python for its `bpy`; quick, because nothing is imported.
pub(super) fn python_with_bpy(
    path: &Path,
    patience: Duration,
    monitor: &dyn Monitor,
) -> Result<Option<PythonWithBpy>, BlenderError> {
    const QUESTION: &str = "import importlib.util, json, sys; \
        bpy = importlib.util.find_spec('bpy'); \
        print(json.dumps({'interpreter': sys.executable, 'bpy': bpy and bpy.origin}))";

    #[derive(Deserialize)]
    struct Answer {
        interpreter: PathBuf,
        bpy: Option<PathBuf>,
    }

    let mut command = Command::new(path);
    command.args(["-c", QUESTION]).env_remove("PYTHONPATH").env_remove("PYTHONHOME");
    let mut text = Vec::new();
    let errors = File::options().write(true).open("/dev/null");
    let ending = errors
        .and_then(|errors| {
            process::supervise(command, &errors, patience, monitor, &mut |line| {
                text.extend_from_slice(line);
            })
        })
        .map_err(|source| does_not_start(path, &source))?;
    match ending {
        Ending::Interrupted => Err(BlenderError::Interrupted),
        Ending::TimedOut => {
            Err(BlenderError::Timeout { path: path.to_owned(), limit: patience, log: None })
        }
        // A Python too old for the question, or a shim with no version chosen, has no bpy either.
        Ending::Exited(_) | Ending::Crashed(_) => {
            let answer: Option<Answer> = serde_json::from_slice(&text).ok();
            Ok(answer.and_then(|Answer { interpreter, bpy }| {
                Some(PythonWithBpy { interpreter, bpy: bpy? })
            }))
        }
    }
}
