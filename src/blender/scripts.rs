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
    "soilsig_addon/blender_manifest.toml",
    "soilsig_addon/body.py",
    "soilsig_addon/dress.py",
    "soilsig_addon/drop_handful.py",
    "soilsig_addon/export_scene.py",
    "soilsig_addon/objects.py",
    "soilsig_addon/operators.py",
    "soilsig_addon/panel.py",
    "soilsig_addon/reference.py",
    "soilsig_addon/save_grain.py",
    "soilsig_addon/settings.py",
    "soilsig_addon/start.py",
    "soilsig_blender/__init__.py",
    "soilsig_blender/check/__init__.py",
    "soilsig_blender/check/attempts.py",
    "soilsig_blender/check/bed_check.py",
    "soilsig_blender/check/distance.py",
    "soilsig_blender/check/hollow_distance.py",
    "soilsig_blender/check/porosity.py",
    "soilsig_blender/common/__init__.py",
    "soilsig_blender/common/arrays.py",
    "soilsig_blender/common/directions.py",
    "soilsig_blender/common/errors.py",
    "soilsig_blender/common/events.py",
    "soilsig_blender/common/files.py",
    "soilsig_blender/common/neighbours.py",
    "soilsig_blender/common/randomness.py",
    "soilsig_blender/common/recipe.py",
    "soilsig_blender/common/script.py",
    "soilsig_blender/common/sphere.py",
    "soilsig_blender/drop/__init__.py",
    "soilsig_blender/drop/collision.py",
    "soilsig_blender/drop/near_fines.py",
    "soilsig_blender/drop/rigid_bodies.py",
    "soilsig_blender/drop/settle.py",
    "soilsig_blender/dust/__init__.py",
    "soilsig_blender/dust/bodies.py",
    "soilsig_blender/dust/clearance.py",
    "soilsig_blender/dust/cover.py",
    "soilsig_blender/dust/dressing.py",
    "soilsig_blender/dust/ground.py",
    "soilsig_blender/dust/hollow_core.py",
    "soilsig_blender/dust/prototype.py",
    "soilsig_blender/dust/reduced_hull.py",
    "soilsig_blender/dust/seats.py",
    "soilsig_blender/dust/solids.py",
    "soilsig_blender/export/__init__.py",
    "soilsig_blender/export/blender_files.py",
    "soilsig_blender/export/colours.py",
    "soilsig_blender/export/glb_file.py",
    "soilsig_blender/export/grain_files.py",
    "soilsig_blender/export/json_files.py",
    "soilsig_blender/export/obj_files.py",
    "soilsig_blender/export/own_scene.py",
    "soilsig_blender/export/report.py",
    "soilsig_blender/make_bed.py",
    "soilsig_blender/make_grains.py",
    "soilsig_blender/model/__init__.py",
    "soilsig_blender/model/blender_meshes.py",
    "soilsig_blender/model/body_check.py",
    "soilsig_blender/model/convex_hull.py",
    "soilsig_blender/model/descriptors.py",
    "soilsig_blender/model/hollow_body.py",
    "soilsig_blender/model/hollow_outline.py",
    "soilsig_blender/model/mesh_faults.py",
    "soilsig_blender/model/outline_body.py",
    "soilsig_blender/model/own_grains.py",
    "soilsig_blender/model/polyhedron.py",
    "soilsig_blender/model/relief.py",
    "soilsig_blender/model/shapes.py",
    "soilsig_blender/model/silhouette.py",
    "soilsig_blender/model/silhouette_body.py",
];

/// SHA-256 of all scripts.
pub fn sha256() -> String {
    output::hex(&Sha256::digest(serde_json::to_vec(SCRIPTS).expect("plain data")))
}

/// Writes all scripts into a folder.
pub(super) fn unpack(folder: &Path) -> Result<(), OutputError> {
    SCRIPTS.iter().try_for_each(|(path, text)| output::scratch(&folder.join(path), text))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use super::SCRIPTS;

    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        entries
            .flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] })
            .filter(|path| {
                path.extension().is_some_and(|ending| ending == "py" || ending == "toml")
            })
            .collect()
    }

    #[test]
    fn the_binary_carries_exactly_the_scripts_of_the_folder() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("blender_scripts");
        let mut there = files(&folder);
        there.sort();
        let mut carried: Vec<_> = SCRIPTS.iter().map(|(path, _)| folder.join(path)).collect();
        carried.sort();
        assert_eq!(carried, there);
    }
}
