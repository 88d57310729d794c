//! The real Blenders of the tests.

use std::env;
use std::path::PathBuf;

/// The real Blenders to test with: the executable and the Python with `bpy`, as `make test` names
/// them. One that was left out by `make test WITHOUT=...` is absent; `make` says so at the end.
///
/// # Panics
/// Where one is neither named nor left out: a test that needs it must not pass.
pub fn real_blenders() -> Vec<PathBuf> {
    let named = |variable: &str| {
        let value = env::var_os(variable).unwrap_or_else(|| {
            panic!("{variable} is not set: run the tests by `make test`, which sets it")
        });
        (value != "none").then(|| PathBuf::from(value))
    };
    ["SOILSIG_TEST_BLENDER", "SOILSIG_TEST_BPY"].into_iter().filter_map(named).collect()
}
