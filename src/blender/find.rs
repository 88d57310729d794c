//! The search for a Blender that will do.

use std::env;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::probe::{PythonWithBpy, probe, python_with_bpy};
use super::{Blender, BlenderError, Kind, known};
use crate::support::monitor::Monitor;

/// The environment variable that names the Blender to use.
pub const VARIABLE: &str = "SOILSIG_BLENDER";

/// Finds the Blender to use; `explicit` is the one of `--blender`, `cache` the folder of what is
/// remembered between runs.
pub fn find(
    explicit: Option<&Path>,
    cache: &Path,
    monitor: &dyn Monitor,
) -> Result<Blender, BlenderError> {
    Search::new(explicit, cache).find(monitor)
}

/// Where to look, and how long to wait for an answer.
#[derive(Debug, Clone)]
pub struct Search {
    /// The choice of `--blender`.
    pub explicit: Option<OsString>,
    /// The choice of `SOILSIG_BLENDER`.
    pub variable: Option<OsString>,
    /// The folders to look in, as in PATH.
    pub path: Option<OsString>,
    /// The folder in which `.venv` is looked for.
    pub folder: PathBuf,
    /// Where Blenders met before are remembered.
    pub cache: PathBuf,
    /// Whether to ask again those that are remembered.
    pub afresh: bool,
    /// How long a Blender may take to tell what it is.
    pub patience: Duration,
}

/// One place of the search and what was there.
#[derive(Debug)]
pub struct Attempt {
    /// `--blender`, `blender on PATH` ...
    pub place: &'static str,
    /// What was there.
    pub path: Option<PathBuf>,
    /// Whether it will do.
    pub outcome: Outcome,
}

/// What came of one place of the search.
#[derive(Debug)]
pub enum Outcome {
    /// Nothing is there.
    Nothing,
    /// A Python without `bpy`: nothing wrong, but no Blender.
    NoBpy,
    /// A Blender that will not do.
    Failed(BlenderError),
    /// A Blender that will do.
    Found(Blender),
}

impl Search {
    /// The search of this process: its environment, its working folder.
    pub fn new(explicit: Option<&Path>, cache: &Path) -> Self {
        Self {
            explicit: explicit.map(Into::into),
            variable: env::var_os(VARIABLE).filter(|value| !value.is_empty()),
            path: env::var_os("PATH"),
            folder: env::current_dir().unwrap_or_default(),
            cache: cache.to_owned(),
            afresh: false,
            patience: Duration::from_secs(60),
        }
    }

    /// Finds the Blender to use.
    ///
    /// # Errors
    /// The first thing that was wrong with what was found. A choice of the user's that does not
    /// work is not replaced by another Blender.
    pub fn find(&self, monitor: &dyn Monitor) -> Result<Blender, BlenderError> {
        Self::conclude(self.attempts(monitor))
    }

    /// Looks at one place after the other, up to the first Blender that will do.
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
        let venv = self.folder.join(".venv/bin/python");
        let names = [
            ("blender on PATH", OsStr::new("blender")),
            (".venv/bin/python", venv.as_os_str()),
            ("python3 on PATH", OsStr::new("python3")),
            ("python3.11 on PATH", OsStr::new("python3.11")),
            ("python on PATH", OsStr::new("python")),
        ];
        for (place, name) in names {
            let path = self.which(name);
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

    /// The Blender that a search found, or the first thing that was wrong.
    pub fn conclude(attempts: Vec<Attempt>) -> Result<Blender, BlenderError> {
        let places: Vec<_> = attempts.iter().map(|attempt| attempt.place).collect();
        let looked_for = places.join(", ");
        let mut trouble = None;
        for attempt in attempts {
            match attempt.outcome {
                Outcome::Found(blender) => return Ok(blender),
                Outcome::Failed(BlenderError::Interrupted) => {
                    return Err(BlenderError::Interrupted);
                }
                Outcome::Failed(error) => trouble = trouble.or(Some(error)),
                Outcome::Nothing | Outcome::NoBpy => {}
            }
        }
        Err(trouble.unwrap_or(BlenderError::Missing { looked_for }))
    }

    fn which(&self, name: &OsStr) -> Option<PathBuf> {
        which::which_in(name, self.path.as_ref(), &self.folder).ok()
    }

    /// Looks at what the user named.
    fn choice(&self, choice: &OsStr, monitor: &dyn Monitor) -> (PathBuf, Outcome) {
        let unusable = |path: &Path, reason: &str| {
            let path = path.to_owned();
            Outcome::Failed(BlenderError::Unusable { path, reason: reason.into() })
        };
        let Some(path) = self.which(choice) else {
            let path = PathBuf::from(choice);
            let outcome = unusable(&path, "there is no such executable file");
            return (path, outcome);
        };
        let outcome = match self.examine(&path, monitor) {
            Outcome::NoBpy => unusable(&path, "this Python has no module bpy"),
            outcome => outcome,
        };
        (path, outcome)
    }

    /// Tells whether an executable is a Blender that will do: from memory, or by asking it.
    fn examine(&self, path: &Path, monitor: &dyn Monitor) -> Outcome {
        if !self.afresh
            && let Some(blender) = known::recall(&self.cache, path)
        {
            return Outcome::Found(blender);
        }
        let (answer, files) = match kind_of(path) {
            Kind::Executable => (probe(Kind::Executable, path, self.patience, monitor), Vec::new()),
            Kind::PythonModule => match python_with_bpy(path, self.patience, monitor) {
                Err(error) => return Outcome::Failed(error),
                Ok(None) => return Outcome::NoBpy,
                Ok(Some(PythonWithBpy { interpreter, bpy })) => {
                    let answer = probe(Kind::PythonModule, &interpreter, self.patience, monitor);
                    (answer, vec![interpreter, bpy])
                }
            },
        };
        match answer {
            Err(error) => Outcome::Failed(error),
            Ok(blender) => {
                let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
                // To be unable to remember costs the next run a second, nothing else.
                let _ = known::remember(&self.cache, path, &files, &blender);
                Outcome::Found(blender)
            }
        }
    }
}

/// Told by the name: interpreters are called `python`, `python3`, `python3.11` ...
fn kind_of(path: &Path) -> Kind {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if name.starts_with("python") { Kind::PythonModule } else { Kind::Executable }
}
