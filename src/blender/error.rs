//! Everything that can go wrong between soilsig and Blender.

use std::path::{Path, PathBuf};
use std::time::Duration;

use nix::sys::signal::Signal;

use super::{Kind, Version};
use crate::support::error::{Failure, Status};
use crate::support::output::OutputError;

/// Blender could not be found or did not do its work.
#[derive(Debug, thiserror::Error)]
pub enum BlenderError {
    /// The search found nothing that is a Blender.
    #[error("no Blender was found (looked for {looked_for})")]
    Missing {
        /// The places, in the order of the search.
        looked_for: String,
    },
    /// What was named or found is no working Blender.
    #[error("{} is not a Blender that works: {reason}", path.display())]
    Unusable {
        /// What was tried.
        path: PathBuf,
        /// What it did instead.
        reason: String,
    },
    /// The Blender is too old.
    #[error("{} is Blender {version}: soilsig needs {} or newer", path.display(), Version::OLDEST)]
    Unsupported {
        /// The Blender.
        path: PathBuf,
        /// Its version.
        version: Version,
    },
    /// Blender's Python has no numpy.
    #[error("the Python of {} has no numpy", path.display())]
    NumpyMissing {
        /// How it is started.
        kind: Kind,
        /// The Blender.
        path: PathBuf,
    },
    /// A script failed inside Blender, or did not write what it should.
    #[error("{message}")]
    Script {
        /// The script's own words, or the end of its traceback.
        message: String,
        /// The remedy that the script named.
        remedy: Option<String>,
        /// Everything that Blender said.
        log: PathBuf,
    },
    /// Blender was ended by a signal.
    #[error("{} crashed ({signal})", path.display())]
    Crash {
        /// The Blender.
        path: PathBuf,
        /// The signal.
        signal: Signal,
        /// Everything that Blender said, where it is kept.
        log: Option<PathBuf>,
    },
    /// Blender did not end in time and was ended.
    #[error("{} had not ended after {} s and was ended", path.display(), limit.as_secs_f64())]
    Timeout {
        /// The Blender.
        path: PathBuf,
        /// The limit.
        limit: Duration,
        /// Everything that Blender said, where it is kept.
        log: Option<PathBuf>,
    },
    /// Blender has no window, or could not open it.
    #[error("{} opens no window: {reason}", path.display())]
    NoWindow {
        /// The Blender.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The bed that came out of the drop is not to be trusted.
    #[error("the bed is refused: {message}")]
    Refused {
        /// The script's own words.
        message: String,
        /// The remedy that the script named.
        remedy: Option<String>,
        /// Everything that Blender said.
        log: PathBuf,
    },
    /// The user asked to stop; Blender was ended.
    #[error("interrupted; Blender was ended")]
    Interrupted,
    /// The log or a script could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl BlenderError {
    /// Where everything is that Blender said, if that was kept.
    pub fn log(&self) -> Option<&Path> {
        match self {
            Self::Script { log, .. } | Self::Refused { log, .. } => Some(log),
            Self::Crash { log, .. } | Self::Timeout { log, .. } => log.as_deref(),
            _ => None,
        }
    }
}

impl Failure for BlenderError {
    fn status(&self) -> Status {
        match self {
            Self::Missing { .. } | Self::Unusable { .. } | Self::NoWindow { .. } => {
                Status::BlenderMissing
            }
            Self::Unsupported { .. } => Status::BlenderVersion,
            Self::NumpyMissing { .. } => Status::BlenderNumpy,
            Self::Script { .. } => Status::BlenderScript,
            Self::Crash { .. } => Status::BlenderCrash,
            Self::Timeout { .. } => Status::BlenderTimeout,
            Self::Refused { .. } => Status::BlenderRefused,
            Self::Interrupted => Status::Interrupted,
            Self::Output(_) => Status::Files,
        }
    }

    fn hint(&self) -> Option<String> {
        let remedy = match self {
            Self::Missing { .. } => {
                "install one (on Debian: apt install blender python3-numpy), or name a blender or \
                 a Python with bpy by --blender or SOILSIG_BLENDER"
            }
            Self::Unusable { .. } => {
                "name a blender or a Python with bpy by --blender or SOILSIG_BLENDER"
            }
            Self::Unsupported { .. } => {
                "install a newer one, or name another by --blender or SOILSIG_BLENDER"
            }
            Self::NumpyMissing { kind: Kind::PythonModule, path } => {
                return Some(format!("{} -m pip install numpy", path.display()));
            }
            Self::NumpyMissing { kind: Kind::Executable, .. } => {
                "install numpy for the Python that this Blender uses (Debian's: apt install \
                 python3-numpy)"
            }
            Self::Crash { signal: Signal::SIGKILL, .. } => {
                "the system may have run out of memory: ask for fewer grains"
            }
            Self::Crash { .. } => "try again, or another Blender by --blender",
            Self::NoWindow { .. } => {
                "name a blender executable by --blender, and start it where there is a display; \
                 without one the scripts still run: `soilsig pipeline`"
            }
            Self::Timeout { log: None, .. } => "start it by hand to see what holds it up",
            Self::Timeout { .. } => "allow more seconds by --blender-timeout",
            Self::Script { remedy, .. } | Self::Refused { remedy, .. } => {
                remedy.as_deref().unwrap_or_default()
            }
            Self::Interrupted => return None,
            Self::Output(error) => return error.hint(),
        };
        let log = self.log().map(|log| format!("Blender's log: {}", log.display()));
        let parts = [remedy, log.as_deref().unwrap_or_default()];
        Some(parts.iter().filter(|part| !part.is_empty()).copied().collect::<Vec<_>>().join("; "))
    }
}
