//! The program, run in a folder of its own with a real Blender.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

/// Runs it there, with a cache there.
///
/// # Panics
/// Where it fails.
pub fn run_in(folder: &Path, blender: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
    command.args(args).current_dir(folder);
    command.env("SOILSIG_CACHE", folder.join("cache")).env("SOILSIG_BLENDER", blender);
    let output = command.output().expect("it runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {}\n{errors}", output.status);
    output
}
