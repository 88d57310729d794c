//! Shell scripts that pose as Blender.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use crate::support::executable;

/// A folder with a shell script in the place of Blender, which counts its starts.
pub struct Fake {
    pub folder: TempDir,
    pub path: PathBuf,
}

impl Fake {
    /// A Blender 3.4.1 that passes the probe and runs `job` for any other script, with `$out` set
    /// to the job's folder and `$here` to its own.
    pub fn blender(job: &str) -> Self {
        Self::named("blender", &format!("{}\n{job}", probe_with("3.4.1", "\"1.24.2\"")))
    }

    /// An executable of this name and with this body, `$here` and `$out` set as above.
    pub fn named(name: &str, body: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let here = folder.path().display();
        let start = format!("here='{here}'\necho start >> \"$here/starts\"\nfor out; do :; done");
        executable(&path, &format!("{start}\n{body}"));
        Self { folder, path }
    }

    /// How often it was started.
    pub fn starts(&self) -> usize {
        let starts = fs::read_to_string(self.folder.path().join("starts"));
        starts.unwrap_or_default().lines().count()
    }

    /// What it wrote into a file of its folder.
    pub fn note(&self, name: &str) -> String {
        fs::read_to_string(self.folder.path().join(name)).unwrap_or_default()
    }
}

/// The part of a fake's body that answers the probe; `numpy` is JSON.
pub fn probe_with(version: &str, numpy: &str) -> String {
    let answer = format!(
        r#"@soilsig {{"event":"probe","blender":"{version}","python":"3.11.2","numpy":{numpy}}}"#
    );
    format!("case \"$*\" in *probe.py*) echo '{answer}'; exit 0;; esac")
}
