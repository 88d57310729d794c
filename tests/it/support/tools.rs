//! What some tests need besides this crate, named by variables of the environment.
//!
//! `make test` sets all of them, and `SOILSIG_TEST_ALL`: then a tool that is missing is a failure,
//! unless its variable says `none` (`make test WITHOUT=...`). Without `SOILSIG_TEST_ALL`, as by a
//! plain `cargo test`, what a missing tool leaves out is said on standard error.

use std::env;
use std::io::{Write as _, stderr};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

#[derive(Clone, Copy)]
pub enum Tool {
    /// Blender's executable.
    Blender,
    /// A Python with the module bpy.
    Bpy,
    /// A Python with Mitsuba.
    Mitsuba,
    /// A Python with the readers of others.
    Readers,
    /// A Python with the module of this project, and what its notebooks need.
    Module,
    /// Snakemake, for the workflow.
    Snakemake,
    /// The daemon of Slurm, for the workflow on a cluster.
    Slurm,
    /// Chromium, for the page of a result.
    Browser,
    /// The X server Xvfb, for Blender's window.
    Window,
    /// A folder with files of the ECOSTRESS library, which the project may not pass on.
    Library,
}

impl Tool {
    fn variable(self) -> &'static str {
        match self {
            Self::Blender => "SOILSIG_TEST_BLENDER",
            Self::Bpy => "SOILSIG_TEST_BPY",
            Self::Mitsuba => "SOILSIG_TEST_MITSUBA",
            Self::Readers => "SOILSIG_TEST_READERS",
            Self::Module => "SOILSIG_TEST_MODULE",
            Self::Snakemake => "SOILSIG_TEST_SNAKEMAKE",
            Self::Slurm => "SOILSIG_TEST_SLURM",
            Self::Browser => "SOILSIG_TEST_BROWSER",
            Self::Window => "SOILSIG_TEST_WINDOW",
            Self::Library => "SOILSIG_TEST_LIBRARY",
        }
    }

    /// Where it is, if anywhere.
    pub(super) fn place(self) -> Option<PathBuf> {
        let variable = self.variable();
        let value = env::var_os(variable).filter(|value| !value.is_empty());
        let all = env::var_os("SOILSIG_TEST_ALL").is_some_and(|value| !value.is_empty());
        assert!(value.is_some() || !all, "{variable} names nothing, and SOILSIG_TEST_ALL is set");
        let place = PathBuf::from(value.filter(|value| value != "none")?);
        assert!(place.exists(), "{variable} names {}, which is not there", place.display());
        Some(place)
    }
}

/// The tool, or `None` after saying that this test is left out.
///
/// # Panics
/// Where it is missing and may not be.
pub fn tool(tool: Tool) -> Option<PathBuf> {
    let place = tool.place();
    if place.is_none() {
        say_left_out(&[tool]);
    }
    place
}

/// Every Blender to test with: the executable and the Python with `bpy`. For each that is missing
/// it says so.
///
/// # Panics
/// Where one is missing and may not be.
pub fn real_blenders() -> Vec<PathBuf> {
    let (found, missing): (Vec<_>, Vec<_>) = [Tool::Blender, Tool::Bpy]
        .map(|tool| (tool, tool.place()))
        .into_iter()
        .partition(|of| of.1.is_some());
    if !missing.is_empty() {
        say_left_out(&missing.iter().map(|of| of.0).collect::<Vec<_>>());
    }
    found.into_iter().filter_map(|of| of.1).collect()
}

/// One Blender, for what does not depend on which; `None` after saying that this test is left out.
///
/// # Panics
/// Where there is none and may not be none.
pub fn a_blender() -> Option<PathBuf> {
    let place = Tool::Blender.place().or_else(|| Tool::Bpy.place());
    if place.is_none() {
        say_left_out(&[Tool::Blender, Tool::Bpy]);
    }
    place
}

/// Says it to standard error itself: what the macros print is not shown of a test that passes.
fn say_left_out(tools: &[Tool]) {
    let thread = thread::current();
    let variables: Vec<&str> = tools.iter().map(|tool| tool.variable()).collect();
    let line = format!(
        "LEFT OUT: {}: nothing in {}\n",
        thread.name().unwrap_or("a test"),
        variables.join(", ")
    );
    stderr().write_all(line.as_bytes()).expect("standard error is open");
}

/// A Blender, or a Python with `bpy`, that is about to run a script in an environment of nothing.
pub fn with_script(blender: &Path, script: &str) -> Command {
    let mut command = Command::new(blender);
    // Debian's Blender takes the first python3 on PATH for its own.
    command.env_clear().env("PATH", "/usr/bin:/bin");
    if blender.file_name().is_none_or(|name| !name.to_string_lossy().contains("python")) {
        command.args(["--background", "--factory-startup", "-noaudio"]);
        command.args(["--python-exit-code", "13", "--python"]);
    }
    command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join(script));
    command
}

/// Writes a shell script.
pub fn executable(path: &Path, body: &str) {
    // By another process: a file that this one holds open for writing while another thread starts
    // a child cannot be executed.
    let mut writer = Command::new("sh")
        .args(["-c", "cat > \"$0\" && chmod 755 \"$0\""])
        .arg(path)
        .stdin(Stdio::piped())
        .spawn()
        .expect("a shell");
    let script = format!("#!/bin/sh\n{body}\n");
    writer.stdin.take().expect("a pipe").write_all(script.as_bytes()).expect("it reads");
    assert!(writer.wait().expect("it ends").success());
}
