//! Scenes, grids of bands and radiance images.

use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use soilsig::products::cube::Cube;
use soilsig::scene::{Scene, SceneGeometry};

use crate::bytes;
use crate::failure::raised;

/// Checks a scene, whose relative paths are those of a folder. Returns its text with paths that
/// hold anywhere.
#[pyfunction]
pub fn scene(text: &str, folder: PathBuf) -> PyResult<String> {
    let folder = std::path::absolute(folder)?;
    let mut scene = Scene::parse(text, &folder.join("scene")).map_err(raised)?;
    let hold = |path: &mut PathBuf| *path = folder.join(&*path);
    scene.files_mut().into_iter().for_each(|file| hold(file.path));
    match &mut scene.geometry {
        SceneGeometry::Placed(placed) => {
            placed.prototypes.iter_mut().for_each(|mesh| hold(&mut mesh.file));
        }
        SceneGeometry::Packing(packing) => {
            packing.library.iter_mut().for_each(hold);
            packing.soil.iter_mut().flat_map(|soil| &mut soil.library).for_each(hold);
        }
    }
    Ok(serde_json::to_string_pretty(&scene.stated()).expect("plain data") + "\n")
}

/// The wavelengths of bands from one to another, um.
#[pyfunction]
pub fn wavelengths(
    py: Python<'_>,
    from_um: f64,
    to_um: f64,
    step_um: f64,
) -> PyResult<Bound<'_, PyBytes>> {
    let grid = soilsig::Grid::new(from_um, to_um, step_um).map_err(PyValueError::new_err)?;
    Ok(bytes(py, grid.wavelengths_um()))
}

/// Lines, samples, wavelengths, and values of an image.
type Image<'py> = ((usize, usize), Bound<'py, PyBytes>, Bound<'py, PyBytes>);

/// An ENVI image: its values by band, line and sample.
#[pyfunction]
pub fn cube(py: Python<'_>, path: PathBuf) -> PyResult<Image<'_>> {
    let cube = Cube::read(&path).map_err(raised)?;
    let um = bytes(py, cube.wavelengths_um.iter().copied());
    Ok(((cube.lines, cube.samples), um, bytes(py, cube.data.iter().map(|&x| x.into()))))
}
