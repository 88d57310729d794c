//! The scripts of `blender_scripts/`, carried inside the binary and unpacked for a run.

use std::path::Path;

use sha2::{Digest, Sha256};

use crate::support::output::{self, OutputError};

macro_rules! scripts {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_str!(concat!("../../blender_scripts/", $path)))),*]
    };
}

/// Every script: its path below `blender_scripts/` and its text.
pub const SCRIPTS: &[(&str, &str)] = scripts![
    "drop.py",
    "grains.py",
    "probe.py",
    "window.py",
    "soilsig_addon/__init__.py",
    "soilsig_addon/dress.py",
    "soilsig_addon/form.py",
    "soilsig_addon/keep.py",
    "soilsig_addon/objects.py",
    "soilsig_addon/panel.py",
    "soilsig_addon/reference.py",
    "soilsig_addon/settings.py",
    "soilsig_addon/start.py",
    "soilsig_addon/step.py",
    "soilsig_blender/attempts.py",
    "soilsig_blender/author_scene.py",
    "soilsig_blender/bed.py",
    "soilsig_blender/blend_addresses.py",
    "soilsig_blender/checks.py",
    "soilsig_blender/clearance.py",
    "soilsig_blender/contact.py",
    "soilsig_blender/convex.py",
    "soilsig_blender/cover.py",
    "soilsig_blender/descriptors.py",
    "soilsig_blender/dust.py",
    "soilsig_blender/errors.py",
    "soilsig_blender/export_blender.py",
    "soilsig_blender/export_json.py",
    "soilsig_blender/export_obj.py",
    "soilsig_blender/files.py",
    "soilsig_blender/from_silhouette.py",
    "soilsig_blender/hull.py",
    "soilsig_blender/library.py",
    "soilsig_blender/make_bed.py",
    "soilsig_blender/make_grains.py",
    "soilsig_blender/mesh_checks.py",
    "soilsig_blender/neighbours.py",
    "soilsig_blender/pieces.py",
    "soilsig_blender/polyhedron.py",
    "soilsig_blender/progress.py",
    "soilsig_blender/prototype.py",
    "soilsig_blender/randomness.py",
    "soilsig_blender/recipe.py",
    "soilsig_blender/rigid.py",
    "soilsig_blender/rows.py",
    "soilsig_blender/script.py",
    "soilsig_blender/seats.py",
    "soilsig_blender/settle.py",
    "soilsig_blender/shapes.py",
    "soilsig_blender/silhouette.py",
    "soilsig_blender/solid_checks.py",
    "soilsig_blender/solids.py",
    "soilsig_blender/sphere.py",
];

/// SHA-256 of all scripts.
pub fn sha256() -> String {
    output::hex(&Sha256::digest(serde_json::to_vec(SCRIPTS).expect("plain data")))
}

/// Writes all scripts into a folder.
pub(super) fn unpack(folder: &Path) -> Result<(), OutputError> {
    SCRIPTS.iter().try_for_each(|(path, text)| output::bytes(&folder.join(path), text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use super::SCRIPTS;

    fn python_files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        entries
            .flat_map(|path| if path.is_dir() { python_files(&path) } else { vec![path] })
            .filter(|path| path.extension().is_some_and(|extension| extension == "py"))
            .collect()
    }

    #[test]
    fn the_binary_carries_exactly_the_scripts_of_the_folder() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("blender_scripts");
        let mut there = python_files(&folder);
        there.sort();
        let mut carried: Vec<_> = SCRIPTS.iter().map(|(path, _)| folder.join(path)).collect();
        carried.sort();
        assert_eq!(carried, there);
    }
}
