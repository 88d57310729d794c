//! Blender's window with the add-on of `blender_scripts/soilsig_addon`, and the add-on as a zip
//! file.

use std::env;
use std::ffi::OsString;
use std::io::{Cursor, Write};
use std::path::Path;
use std::time::Duration;

use zip::write::SimpleFileOptions;

use super::run::{Scratch, last_words, run_logged};
use super::{Blender, BlenderError, Kind, SCRIPTS, process};
use crate::support::monitor::Monitor;
use crate::support::output::{self, OutputError};

/// The add-on's folder.
const ADDON: &str = "soilsig_addon";
/// A limit that is never reached.
const NO_LIMIT: Duration = Duration::from_secs(1 << 32);
/// The environment variables by which a window finds its display.
const DISPLAY: [&str; 6] = [
    "DISPLAY",
    "WAYLAND_DISPLAY",
    "XAUTHORITY",
    "XDG_RUNTIME_DIR",
    "XDG_SESSION_TYPE",
    "LIBGL_ALWAYS_SOFTWARE",
];

impl Blender {
    /// Opens Blender's window with the add-on and the user's own preferences, and waits until it is
    /// closed. `grains` is the folder of the user's grains, `more` are arguments for Blender.
    ///
    /// # Errors
    /// A `bpy` without a window, a Blender that does not open one, or one that crashes.
    pub fn open_window(
        &self,
        grains: Option<&Path>,
        more: &[OsString],
        monitor: &dyn Monitor,
    ) -> Result<(), BlenderError> {
        let no_window = |reason| BlenderError::NoWindow { path: self.path.clone(), reason };
        if self.kind == Kind::PythonModule {
            return Err(no_window("it is the module bpy, which has no window".into()));
        }
        let scratch = Scratch::new()?;
        let mut command = process::tied_to_this_process(&self.path);
        command.args(more);
        scratch.add_script(&mut command, self.kind, "window.py");
        // Blender's automatic saves must outlive the window.
        command.env_remove("TMPDIR");
        command.envs(DISPLAY.iter().filter_map(|name| Some((name, env::var_os(name)?))));
        if let Some(folder) = grains {
            command.arg("--grains").arg(folder);
        }
        let log = scratch.log();
        let ending = run_logged(&self.path, command, &log, NO_LIMIT, monitor, &mut |_| ())?;
        match ending.exit_code(&self.path, NO_LIMIT, None)? {
            0 => Ok(()),
            _ => Err(no_window(last_words(&log))),
        }
    }
}

/// Writes the add-on as a zip file that Blender's preferences install.
pub fn write_addon(path: &Path) -> Result<(), OutputError> {
    output::bytes(path, &addon())
}

/// The add-on, with the scripts that it uses inside its folder.
fn addon() -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (path, text) in SCRIPTS {
        let name = match *path {
            path if path.starts_with(ADDON) => path.to_owned(),
            path if path.starts_with("soilsig_blender/") || path == "drop.py" => {
                format!("{ADDON}/{path}")
            }
            _ => continue,
        };
        zip.start_file(name, options).expect("names are short and differ");
        zip.write_all(text.as_bytes()).expect("memory can be written");
    }
    zip.finish().expect("memory can be written").into_inner()
}
