//! The scripts' own tests (`tests/python/test_*.py`), run by the Python of every real Blender.

use std::path::Path;
use std::process::Command;

use crate::support::real_blenders;

#[test]
fn the_tests_of_the_scripts_pass_in_every_blender() {
    let run = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/run.py");
    for blender in real_blenders() {
        let mut command = Command::new(&blender);
        // Debian's Blender takes the first python3 on PATH for its own.
        command.env_clear().env("PATH", "/usr/bin:/bin");
        let is_python =
            blender.file_name().is_some_and(|name| name.to_string_lossy().contains("python"));
        if !is_python {
            command.args(["--background", "--factory-startup", "-noaudio"]);
            command.args(["--python-exit-code", "13", "--python"]);
        }
        let output = command.arg(&run).output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stdout);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}\n{said}\n{errors}", blender.display());
        // An exit status alone would not tell tests that ran from a script that did not.
        assert!(said.lines().any(|line| line.starts_with("Ran ")), "{said}\n{errors}");
    }
}
