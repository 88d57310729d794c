//! The search for a usable Blender.

use std::env;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::probe::{Python, probe, python};
use super::{Blender, BlenderError, Kind, known};
use crate::support::monitor::Monitor;

/// The environment variable that names the Blender to use.
pub const VARIABLE: &str = "SOILSIG_BLENDER";

/// The environment variable by which the Python module names its interpreter.
const INTERPRETER: &str = "SOILSIG_PYTHON";

/// Longest that a Blender may take to say what it is.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Finds the Blender to use. `explicit` is the value of `--blender`. Known Blenders are remembered
/// in the folder `cache`. `limit` is the longest that Blender may take, at most [`PATIENCE`].
pub fn find(
    explicit: Option<&Path>,
    cache: &Path,
    limit: Duration,
    monitor: &dyn Monitor,
) -> Result<Blender, BlenderError> {
    let search = Search::new(explicit, cache);
    Search { patience: limit.min(PATIENCE), ..search }.find(monitor)
}

/// The places of a search and its time limit.
#[derive(Debug, Clone)]
pub struct Search {
    /// The value of `--blender`.
    pub explicit: Option<OsString>,
    /// The value of `SOILSIG_BLENDER`.
    pub variable: Option<OsString>,
    /// The Python that runs the program, if one does.
    pub interpreter: Option<OsString>,
    /// The folders to search, in the form of PATH.
    pub path: Option<OsString>,
    /// The folder of `.venv`.
    pub folder: PathBuf,
    /// The folder where known Blenders are remembered.
    pub cache: PathBuf,
    /// Whether to ask known Blenders again.
    pub afresh: bool,
    /// The time limit for the answer of a Blender.
    pub patience: Duration,
}

/// One place of the search and its outcome.
#[derive(Debug)]
pub struct Attempt {
    /// The place, such as `--blender` or `blender on PATH`.
    pub place: &'static str,
    /// The file at this place.
    pub path: Option<PathBuf>,
    /// The outcome.
    pub outcome: Outcome,
}

/// The outcome of one place of the search.
#[derive(Debug)]
pub enum Outcome {
    /// There is no file.
    Nothing,
    /// A Python without `bpy`, which is no error.
    NoBpy,
    /// A Blender that cannot be used.
    Failed(BlenderError),
    /// A usable Blender.
    Found(Blender),
}

impl Search {
    /// A search with the environment and the working folder of this process.
    pub fn new(explicit: Option<&Path>, cache: &Path) -> Self {
        Self {
            explicit: explicit.map(Into::into),
            variable: env::var_os(VARIABLE).filter(|value| !value.is_empty()),
            interpreter: env::var_os(INTERPRETER).filter(|value| !value.is_empty()),
            path: env::var_os("PATH"),
            folder: env::current_dir().unwrap_or_default(),
            cache: cache.to_owned(),
            afresh: false,
            patience: PATIENCE,
        }
    }

    /// Finds the Blender to use.
    ///
    /// # Errors
    /// The first error of the search. A Blender that the user named is not replaced by another one.
    pub fn find(&self, monitor: &dyn Monitor) -> Result<Blender, BlenderError> {
        Self::conclude(self.attempts(monitor))
    }

    /// Tries the places in turn, up to the first usable Blender.
    pub fn attempts(&self, monitor: &dyn Monitor) -> Vec<Attempt> {
        let mut attempts = Vec::new();
        for (place, choice) in [("--blender", &self.explicit), (VARIABLE, &self.variable)] {
            if let Some(choice) = choice {
                let (path, outcome) = self.choice(choice, monitor);
                attempts.push(Attempt { place, path: Some(path), outcome });
                return attempts;
            }
            attempts.push(Attempt { place, path: None, outcome: Outcome::Nothing });
        }
        // A working folder of somebody else may have one.
        let venv = self.folder.join(".venv/bin/python");
        let is_ours = fs::symlink_metadata(&venv)
            .is_ok_and(|now| [0, nix::unistd::geteuid().as_raw()].contains(&now.uid()));
        let own = self.interpreter.as_deref().map(|name| ("Python of soilsig", name));
        let others = [
            ("blender on PATH", OsStr::new("blender")),
            (".venv/bin/python", venv.as_os_str()),
            ("python3 on PATH", OsStr::new("python3")),
            ("python3.11 on PATH", OsStr::new("python3.11")),
            ("python on PATH", OsStr::new("python")),
        ];
        for (place, name) in own.into_iter().chain(others) {
            let path = self.which(name).filter(|_| name != venv || is_ours);
            let outcome =
                path.as_deref().map_or(Outcome::Nothing, |path| self.examine(path, monitor));
            let is_last =
                matches!(outcome, Outcome::Found(_) | Outcome::Failed(BlenderError::Interrupted));
            attempts.push(Attempt { place, path, outcome });
            if is_last {
                break;
            }
        }
        attempts
    }

    /// The usable Blender of a search, or its interrupt, or its first error.
    pub fn conclude(attempts: Vec<Attempt>) -> Result<Blender, BlenderError> {
        let places: Vec<_> = attempts.iter().map(|attempt| attempt.place).collect();
        let mut result = Err(BlenderError::Missing { looked_for: places.join(", ") });
        for attempt in attempts {
            match (attempt.outcome, &result) {
                (Outcome::Found(blender), _) => return Ok(blender),
                (Outcome::Failed(error @ BlenderError::Interrupted), _)
                | (Outcome::Failed(error), Err(BlenderError::Missing { .. })) => {
                    result = Err(error);
                }
                _ => {}
            }
        }
        result
    }

    fn which(&self, name: &OsStr) -> Option<PathBuf> {
        which::which_in(name, self.path.as_ref(), &self.folder).ok()
    }

    /// Tries the file that the user named.
    fn choice(&self, choice: &OsStr, monitor: &dyn Monitor) -> (PathBuf, Outcome) {
        let path = self.which(choice);
        let outcome = path.as_deref().map_or(Outcome::Nothing, |path| self.examine(path, monitor));
        let path = path.unwrap_or_else(|| choice.into());
        let unusable = |reason: &str| {
            let path = path.clone();
            Outcome::Failed(BlenderError::Unusable { path, reason: reason.into() })
        };
        let outcome = match outcome {
            Outcome::Nothing => unusable("there is no such executable file"),
            Outcome::NoBpy => unusable("this Python has no module bpy"),
            outcome => outcome,
        };
        (path, outcome)
    }

    /// Takes an executable's Blender from memory, or asks the executable.
    fn examine(&self, path: &Path, monitor: &dyn Monitor) -> Outcome {
        let known = if self.afresh { None } else { known::recall(&self.cache, path) };
        if let Some(blender) = known {
            return Outcome::Found(blender);
        }
        let is_python = path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("python"));
        let (answer, files) = if is_python {
            match python(path, self.patience, monitor) {
                Err(error) => return Outcome::Failed(error),
                Ok(Some(Python { interpreter, bpy: Some(bpy) })) => {
                    let answer = probe(Kind::PythonModule, &interpreter, self.patience, monitor);
                    (answer, vec![interpreter, bpy])
                }
                Ok(_) => return Outcome::NoBpy,
            }
        } else {
            (probe(Kind::Executable, path, self.patience, monitor), Vec::new())
        };
        match answer {
            Err(error) => Outcome::Failed(error),
            Ok(blender) => {
                known::remember(&self.cache, path, &files, &blender);
                Outcome::Found(blender)
            }
        }
    }
}
