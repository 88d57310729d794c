//! Failures of Blender and of its scripts.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use nix::sys::signal::Signal;

use super::{Kind, Version};
use crate::support::error::{Failure, Status};
use crate::support::output::OutputError;
use crate::support::scratch::ScratchError;

/// Blender was not found or failed.
#[derive(Debug, thiserror::Error)]
pub enum BlenderError {
    /// The search found no Blender.
    #[error("no Blender was found (looked for {looked_for})")]
    Missing {
        /// The places, in the order of the search.
        looked_for: String,
    },
    /// A program is not a working Blender.
    #[error("{} is not a working Blender: {reason}", path.display())]
    Unusable {
        /// The program.
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
    /// A script failed in Blender, or its files are missing.
    #[error("{message}")]
    Script {
        /// The script's message, or the end of its traceback.
        message: String,
        /// The script's remedy.
        remedy: Option<String>,
        /// The file with Blender's output.
        log: PathBuf,
    },
    /// A signal ended Blender.
    #[error("{} crashed ({signal})", path.display())]
    Crash {
        /// The Blender.
        path: PathBuf,
        /// The signal.
        signal: Signal,
        /// The file with Blender's output, if it was kept.
        log: Option<PathBuf>,
    },
    /// Blender was stopped at its time limit.
    #[error("{} was stopped at its time limit of {} s", path.display(), limit.as_secs_f64())]
    Timeout {
        /// The Blender.
        path: PathBuf,
        /// The limit.
        limit: Duration,
        /// The file with Blender's output, if it was kept.
        log: Option<PathBuf>,
    },
    /// Blender has no window, or could not open it.
    #[error("{} cannot open a window: {reason}", path.display())]
    NoWindow {
        /// The Blender.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The bed failed its checks.
    #[error("the bed is refused: {message}")]
    Refused {
        /// The script's message.
        message: String,
        /// The script's remedy.
        remedy: Option<String>,
        /// The file with Blender's output.
        log: PathBuf,
    },
    /// The user interrupted; Blender was stopped.
    #[error("interrupted; Blender was stopped")]
    Interrupted,
    /// The disk was full, or could not be written to, while Blender ran.
    #[error("Blender could not write into {}: {message}", folder.display())]
    Disk {
        /// The folder.
        folder: PathBuf,
        /// The script's message.
        message: String,
        /// The file with Blender's output.
        log: PathBuf,
    },
    /// The log could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The scripts could not be written.
    #[error(transparent)]
    Scratch(#[from] ScratchError),
}

impl BlenderError {
    /// The file with Blender's output, if it was kept.
    pub fn log(&self) -> Option<&Path> {
        match self {
            Self::Script { log, .. } | Self::Refused { log, .. } | Self::Disk { log, .. } => {
                Some(log)
            }
            Self::Crash { log, .. } | Self::Timeout { log, .. } => log.as_deref(),
            _ => None,
        }
    }
}

/// Whether a program is a script around another one, or is shut into a folder of its own.
fn is_wrapper(path: &Path) -> bool {
    let mut start = [0; 2];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut start));
    path.starts_with("/snap") || (read.is_ok() && &start == b"#!")
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
            Self::Disk { .. } | Self::Output(_) | Self::Scratch(_) => Status::Files,
        }
    }

    fn hint(&self) -> Option<String> {
        let remedy = match self {
            Self::Missing { .. } => {
                "install Blender (Debian: apt install blender python3-numpy), or name a blender or \
                 a Python with bpy in --blender or SOILSIG_BLENDER"
            }
            Self::Unusable { path, .. } if is_wrapper(path) => {
                "it is a script, and is started with a cleared environment (PATH is /usr/bin:/bin; \
                 HOME and LD_LIBRARY_PATH are kept): let it set what it needs, and name programs \
                 by their paths; it must see the folder for temporary files (TMPDIR); or name a \
                 blender or a Python with bpy in --blender or SOILSIG_BLENDER"
            }
            Self::Unusable { .. } => {
                "name a blender or a Python with bpy in --blender or SOILSIG_BLENDER"
            }
            Self::Disk { .. } => {
                "free some space, or name other folders in SOILSIG_CACHE (earlier results) and \
                 TMPDIR (temporary files)"
            }
            Self::Unsupported { .. } => {
                "install a newer Blender, or name another one in --blender or SOILSIG_BLENDER"
            }
            Self::NumpyMissing { kind: Kind::PythonModule, path } => {
                return Some(format!("run {} -m pip install numpy", path.display()));
            }
            Self::NumpyMissing { kind: Kind::Executable, .. } => {
                "install numpy for Blender's Python (Debian: apt install python3-numpy)"
            }
            Self::Crash { signal: Signal::SIGKILL, .. } => {
                "the memory may have run out: ask for fewer grains"
            }
            Self::Crash { .. } => "try again, or name another Blender in --blender",
            Self::NoWindow { .. } => {
                "name a blender executable in --blender and start it on a display; `soilsig \
                 pipeline` needs no display"
            }
            Self::Timeout { log: None, .. } => "start it by hand to find the cause",
            Self::Timeout { .. } => "allow more seconds with --blender-timeout",
            Self::Script { remedy, .. } | Self::Refused { remedy, .. } => {
                remedy.as_deref().unwrap_or_default()
            }
            Self::Interrupted => return None,
            Self::Output(error) => return error.hint(),
            Self::Scratch(error) => return error.hint(),
        };
        let log = self.log().map(|log| format!("Blender's log: {}", log.display()));
        let parts = [remedy, log.as_deref().unwrap_or_default()];
        Some(parts.iter().filter(|part| !part.is_empty()).copied().collect::<Vec<_>>().join("; "))
    }
}
