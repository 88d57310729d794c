//! A folder of its own for each test, and the program run there.

use std::fs;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::process::{self, Output};
use std::sync::{Arc, OnceLock};

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

use super::bed::OfBlenders;
use super::told::told;
use super::tools::{Tool, executable};

/// A cache for tests that take a bed as it comes, and do not mind who dropped it.
pub fn shared_cache() -> &'static Path {
    static CACHE: OnceLock<PathBuf> = OnceLock::new();
    CACHE.get_or_init(|| Place::kept().path("cache"))
}

/// The list of known Blenders in a cache.
const KNOWN: &str = "blenders.json";

/// What the program knows of a real Blender when it has asked it once, which takes a second.
fn versions(blender: &Path) -> Arc<Vec<u8>> {
    static KNOWN_BY_NOW: OfBlenders<Vec<u8>> = OfBlenders::new();
    KNOWN_BY_NOW.of(blender, |blender| {
        let place = Place::new();
        place.soilsig(&["doctor"]).env("SOILSIG_BLENDER", blender).output().expect("it runs");
        fs::read(place.cache.join(KNOWN)).unwrap_or_default()
    })
}

/// The folder, with a cache of its own.
pub struct Place {
    folder: PathBuf,
    cache: PathBuf,
    /// Takes the folder away in the end.
    _kept: Option<TempDir>,
}

impl Place {
    pub fn new() -> Self {
        let kept = tempfile::tempdir().expect("a temporary folder");
        let folder = kept.path().to_owned();
        Self { cache: folder.join("cache"), folder, _kept: Some(kept) }
    }

    /// With the cache of others.
    pub fn with_shared_cache() -> Self {
        Self { cache: shared_cache().to_owned(), ..Self::new() }
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
        let folder = folder.expect("a folder").keep();
        Self { cache: folder.join("cache"), folder, _kept: None }
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
        command.env("SOILSIG_CACHE", &self.cache).env_remove("SOILSIG_BLENDER");
        command
    }

    /// The same with this Blender.
    pub fn soilsig_with(&self, blender: &Path, args: &[&str]) -> Command {
        let is_real = |tool: &Tool| (*tool).place().as_deref() == Some(blender);
        if [Tool::Blender, Tool::Bpy].iter().any(is_real) && !self.cache.exists() {
            fs::DirBuilder::new().recursive(true).mode(0o700).create(&self.cache).expect("made");
            fs::write(self.cache.join(KNOWN), &*versions(blender)).expect("written");
        }
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
