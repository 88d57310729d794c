//! A folder of its own for each test.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use tempfile::TempDir;

/// The folder, with a cache of its own.
pub struct Place(TempDir);

impl Place {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The program there, without a word about Blender.
    pub fn soilsig(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
        command.args(args).current_dir(self.0.path());
        command.env("SOILSIG_CACHE", self.path("cache")).env_remove("SOILSIG_BLENDER");
        command
    }
}

/// The path of a shipped scene.
pub fn shipped(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).display().to_string()
}
