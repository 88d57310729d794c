//! The scripts' own tests (`tests/python/test_*.py`), run by the Python of every real Blender.

use crate::support::{real_blenders, with_script};

#[test]
fn the_tests_of_the_scripts_pass_in_every_blender() {
    for blender in real_blenders() {
        let output = with_script(&blender, "tests/python/run.py").output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stdout);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}\n{said}\n{errors}", blender.display());
        // An exit status alone would not tell tests that ran from a script that did not.
        assert!(said.lines().any(|line| line.starts_with("Ran ")), "{said}\n{errors}");
    }
}
