//! Writes that fail, and runs that are killed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use serde_json::Value;
use soilsig::support::output;

/// A library that lets the n-th write, rename or other change of a file fail.
pub fn failing_library() -> &'static Path {
    static MADE: OnceLock<PathBuf> = OnceLock::new();
    MADE.get_or_init(|| {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/failing_writes.c");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let library = folder.join(format!("failing_writes_{}.so", std::process::id()));
        let made = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .args([&library, &source])
            .status()
            .expect("a C compiler, which Rust needs too");
        assert!(made.success());
        library
    })
}

/// What a result is, by its record.
#[derive(Debug, PartialEq, Eq)]
pub enum Found {
    /// There is no record: nothing is claimed.
    Nothing,
    /// All files are as recorded. The SHA-256 of the signature.
    Whole(String),
}

/// Checks a result against its record.
///
/// # Panics
/// Where a file is not as recorded.
pub fn found(out: &Path) -> Found {
    let Ok(text) = fs::read(out.join("run.json")) else { return Found::Nothing };
    let record: Value = serde_json::from_slice(&text).expect("a whole record");
    for (name, output) in record["outputs"].as_object().expect("outputs") {
        let sum = output::sha256_hex(&out.join(name)).expect(name);
        assert_eq!(output["sha256"], sum, "{name} is not as recorded");
    }
    Found::Whole(record["outputs"]["signature.csv"]["sha256"].as_str().expect("a sum").into())
}

/// Files that only a run at work should have, below folders.
pub fn left_over(folders: &[PathBuf]) -> Vec<PathBuf> {
    let is_left = |name: &str| {
        [".soilsig-", ".making-", "soilsig-run-", "blender.unfinished"]
            .iter()
            .any(|begin| name.starts_with(begin))
    };
    let mut all = Vec::new();
    for folder in folders {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if is_left(&entry.file_name().to_string_lossy()) {
                all.push(entry.path());
            } else if entry.path().is_dir() {
                all.extend(left_over(&[entry.path()]));
            }
        }
    }
    all
}

/// Starts a command and kills it after a time.
pub fn killed_after(command: &mut Command, time: Duration) {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
    std::thread::sleep(time);
    let _ = child.kill();
    child.wait().expect("it ends");
}
