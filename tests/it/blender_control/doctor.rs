//! `soilsig doctor` as a user or a script meets it.

use std::process::{Command, Output};

use insta::assert_snapshot;
use serde_json::Value;
use soilsig::support::error::Status;

use super::fake::{Fake, probe_with};
use crate::support::without_places;

/// Runs `soilsig doctor` in a folder and with a PATH of its own.
fn doctor(fake: &Fake, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_soilsig"))
        .arg("doctor")
        .args(args)
        .env_clear()
        .env("PATH", fake.folder.path())
        .env("HOME", fake.folder.path())
        .current_dir(fake.folder.path())
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// A report without its first line, which is of this machine.
fn places(report: &str) -> String {
    without_places(report.split_once('\n').expect("several lines").1)
}

#[test]
fn a_blender_that_will_do_is_shown_with_its_versions() {
    let fake = Fake::blender("");
    let output = doctor(&fake, &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report = text(&output.stdout);
    assert!(report.contains(fake.path.to_str().unwrap()), "{report}");
    assert!(report.contains(env!("CARGO_PKG_VERSION")), "{report}");
    assert_snapshot!(places(report));
}

#[test]
fn json_says_the_same_to_a_script() {
    let fake = Fake::blender("");
    let output = doctor(&fake, &["--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["will_do"], true);
    assert_eq!(report["blender"]["version"], "3.4.1");
    assert_eq!(report["blender"]["path"], fake.path.to_str().unwrap());
    assert_eq!(report["searched"][2]["place"], "blender on PATH");
}

#[test]
fn a_blender_that_will_not_do_ends_with_the_status_of_its_trouble() {
    let mut told = String::new();
    for (version, numpy, status) in
        [("2.93.0", "\"1.17\"", Status::BlenderVersion), ("3.4.1", "null", Status::BlenderNumpy)]
    {
        let fake = Fake::named("blender", &probe_with(version, numpy));
        let output = doctor(&fake, &["--json"]);
        assert_eq!(output.status.code(), Some(status as i32));
        told += text(&output.stderr);
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((&report["will_do"], &report["blender"]), (&false.into(), &Value::Null));
        assert!(report["searched"][2]["problem"].is_string(), "{report}");
    }
    let elsewhere = Fake::named("not-blender", "");
    let output = doctor(&elsewhere, &[]);
    assert_eq!(output.status.code(), Some(Status::BlenderMissing as i32));
    told += &places(text(&output.stdout));
    assert_snapshot!(without_places(&told));
}
