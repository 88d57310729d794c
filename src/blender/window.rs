//! Blender's window with the add-on of `blender_scripts/soilsig_addon`, and the add-on as a file to install.

use std::ffi::OsString;
use std::io::{Cursor, Write};
use std::path::Path;
use std::time::Duration;

use zip::write::SimpleFileOptions;

use super::process::Ending;
use super::run::{Scratch, does_not_start, last_words, run_logged};
use super::{Blender, BlenderError, Kind, SCRIPTS};
use crate::support::monitor::Monitor;
use crate::support::output::{self, OutputError};

/// The add-on's folder.
const ADDON: &str = "soilsig_addon";
/// As good as without end.
const NO_LIMIT: Duration = Duration::from_secs(1 << 32);

impl Blender {
    /// Opens Blender's window with the add-on loaded and waits until it is closed. `grains` is the library's
    /// folder, `more` are arguments for Blender itself.
    ///
    /// # Errors
    /// A `bpy` without a window, a Blender that does not open one, or one that crashes.
    pub fn open_window(
        &self,
        grains: Option<&Path>,
        more: &[OsString],
        monitor: &dyn Monitor,
    ) -> Result<(), BlenderError> {
        let path = self.path.clone();
        if self.kind == Kind::PythonModule {
            let reason = "bpy is Blender without a window".into();
            return Err(BlenderError::NoWindow { path, reason });
        }
        let scratch = Scratch::new()?;
        let mut command = scratch.window(&self.path, more, "window.py");
        if let Some(folder) = grains {
            command.arg("--grains").arg(folder);
        }
        let log = scratch.log();
        let ending = run_logged(command, &log, NO_LIMIT, monitor, &mut |_| ())?
            .map_err(|source| does_not_start(&path, &source))?;
        match ending {
            Ending::Exited(0) => Ok(()),
            Ending::Interrupted => Err(BlenderError::Interrupted),
            Ending::Crashed(signal) => Err(BlenderError::Crash { path, signal, log: None }),
            Ending::Exited(_) | Ending::TimedOut => {
                let reason = last_words(&log).unwrap_or_else(|| "it says nothing".into());
                Err(BlenderError::NoWindow { path, reason })
            }
        }
    }
}

/// Writes the add-on as a zip that Blender's preferences install.
pub fn write_addon(path: &Path) -> Result<(), OutputError> {
    output::bytes(path, &addon())
}

/// The add-on with the scripts that it needs within it.
fn addon() -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let of_it = |path: &str| path.starts_with(ADDON);
    let needed = |path: &str| path.starts_with("soilsig_blender/") || path == "drop.py";
    for (path, text) in SCRIPTS {
        let name = match path {
            path if of_it(path) => (*path).to_owned(),
            path if needed(path) => format!("{ADDON}/{path}"),
            _ => continue,
        };
        let options =
            SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        zip.start_file(name, options).expect("names are short and no two alike");
        zip.write_all(text.as_bytes()).expect("memory takes it");
    }
    zip.finish().expect("memory takes it").into_inner()
}
