//! The Python module's own tests (`tests/python_module`), where it is installed.

use std::path::Path;
use std::process::Command;

use crate::support::{Tool, a_blender, shared_cache, tool};

#[test]
fn the_tests_of_the_python_module_pass() {
    let Some(python) = tool(Tool::Module) else { return };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut pytest = Command::new(python);
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/python_module"]);
    pytest.current_dir(root).env("SOILSIG_CACHE", shared_cache());
    match a_blender() {
        Some(blender) => pytest.env("SOILSIG_BLENDER", blender),
        None => pytest.env_remove("SOILSIG_BLENDER"),
    };
    if tool(Tool::Bpy).is_none() {
        pytest.env_remove("SOILSIG_TEST_BPY");
    }
    let output = pytest.output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}\n{errors}");
    // An exit status alone would not tell tests that ran from those that were left out.
    assert!(said.contains(" passed"), "{said}");
}
