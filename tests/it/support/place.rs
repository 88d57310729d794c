//! A folder of its own for each test, and the program run there.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{self, Output};

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

use super::told::told;
use super::tools::executable;

/// The folder, with a cache of its own.
pub struct Place {
    folder: PathBuf,
    /// Takes the folder away in the end.
    _kept: Option<TempDir>,
}

impl Place {
    pub fn new() -> Self {
        let kept = tempfile::tempdir().expect("a temporary folder");
        Self { folder: kept.path().to_owned(), _kept: Some(kept) }
    }

    /// In a folder that outlives this process, since nothing drops what is static; those of earlier
    /// ones go.
    pub fn kept() -> Self {
        let all = Path::new(env!("CARGO_TARGET_TMPDIR"));
        for entry in fs::read_dir(all).expect("Cargo made it").flatten() {
            let name = entry.file_name().into_string().unwrap_or_default();
            let process = name.strip_prefix("bed-").and_then(|name| name.split('-').next());
            if process.is_some_and(|id| !Path::new("/proc").join(id).exists()) {
                let _ = fs::remove_dir_all(entry.path());
            }
        }
        let name = format!("bed-{}-", process::id());
        let folder = tempfile::Builder::new().prefix(&name).tempdir_in(all);
        Self { folder: folder.expect("a folder").keep(), _kept: None }
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("written");
    }

    pub fn read(&self, name: impl AsRef<Path>) -> String {
        fs::read_to_string(self.path(name)).expect("written")
    }

    pub fn json(&self, name: impl AsRef<Path>) -> Value {
        serde_json::from_str(&self.read(name)).expect("JSON")
    }

    /// The program there, without a word about Blender.
    pub fn soilsig(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
        command.args(args).current_dir(&self.folder);
        command.env("SOILSIG_CACHE", self.path("cache")).env_remove("SOILSIG_BLENDER");
        command
    }

    /// The same with this Blender.
    pub fn soilsig_with(&self, blender: &Path, args: &[&str]) -> Command {
        let mut command = self.soilsig(args);
        command.env("SOILSIG_BLENDER", blender);
        command
    }

    /// This Blender, by a script that counts its starts.
    pub fn counted(&self, blender: &Path) -> PathBuf {
        fs::create_dir(self.path("blenders")).expect("made");
        let script = self.path("blenders").join(blender.file_name().expect("a file"));
        let (count, blender) = (self.path("starts"), blender.display());
        let body = format!("echo x >> '{}'\nexec '{blender}' \"$@\"", count.display());
        executable(&script, &body);
        script
    }

    /// How often it was started.
    pub fn starts(&self) -> usize {
        self.read("starts").lines().count()
    }

    /// Runs and expects that exit status; returns standard output and standard error.
    pub fn run(&self, args: &[&str], status: i32) -> (String, String) {
        Self::ended(&mut self.soilsig(args), status)
    }

    /// Runs with this Blender and expects success; returns standard output.
    pub fn run_with(&self, blender: &Path, args: &[&str]) -> String {
        Self::ended(&mut self.soilsig_with(blender, args), 0).0
    }

    /// Runs a command as [`Self::run`] does.
    pub fn ended(command: &mut Command, status: i32) -> (String, String) {
        let Output { status: found, stdout, stderr } = command.output().expect("it runs");
        let [out, err] = [stdout, stderr].map(|bytes| String::from_utf8(bytes).expect("UTF-8"));
        assert_eq!(found.code(), Some(status), "{command:?}\n{out}\n{err}");
        assert!(!err.contains("panicked"), "{err}");
        (out, err)
    }

    /// Runs, expects a failure of any exit status and returns the message for a snapshot, which has
    /// the status too.
    pub fn failed(&self, args: &[&str]) -> String {
        let output = self.soilsig(args).output().expect("it runs");
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        let status = output.status.code().expect("an exit status");
        assert!(status != 0 && said.contains("error:"), "{args:?}: {status}: {said}");
        assert!(!said.contains("panicked"), "{said}");
        told(args, status, &said)
    }

    /// Runs, expects a failure of that exit status and returns the message for a snapshot.
    pub fn refused(&self, args: &[&str], status: i32) -> String {
        let (_, err) = self.run(args, status);
        assert!(err.contains("error:"), "{err}");
        told(args, status, &err)
    }
}

/// The path of a shipped scene.
pub fn shipped(name: &str) -> String {
    shipped_path(name).display().to_string()
}

/// The same as a path.
pub fn shipped_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

/// A shipped scene as JSON, its meshes named where they are.
pub fn shipped_json(name: &str) -> Value {
    let text = fs::read_to_string(shipped_path(name)).expect("shipped");
    let mut scene: Value = serde_json::from_str(&text).expect("JSON");
    let prototypes = scene.pointer_mut("/geometry/placed/prototypes");
    for prototype in prototypes.and_then(Value::as_array_mut).into_iter().flatten() {
        prototype["file"] = shipped(prototype["file"].as_str().expect("a file")).into();
    }
    scene
}
