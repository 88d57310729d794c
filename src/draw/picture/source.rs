//! The scene of a picture.

use std::path::Path;

use crate::scene::Scene;
use crate::support::error::{Error, Failure};
use crate::support::file_error::FileError;

/// A file or folder does not have what a picture needs.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct PictureError(#[from] FileError);

impl Failure for PictureError {
    fn hint(&self) -> Option<String> {
        match &self.0 {
            FileError::Wrong { .. } => self.0.hint(),
            FileError::Read { .. } => Some(
                "`soilsig pipeline` writes it beside scene.json when Blender drops a bed: run it \
                 again"
                    .into(),
            ),
        }
    }
}

/// Reads a placed scene from its file, or from the folder of a pipeline's result. Of several
/// packings it reads the first.
///
/// # Errors
/// The folder has no scene, or the scene is not valid or not placed.
pub fn placed_scene(path: &Path) -> Result<Scene, Error> {
    let file = if path.is_dir() {
        let places = ["scene.json", "packings/1/scene.json"].map(|place| path.join(place));
        places.into_iter().find(|place| place.is_file()).ok_or_else(|| {
            let wrong = FileError::wrong(path, "there is no scene.json in this folder");
            PictureError(wrong.with_hint(
                "`soilsig pipeline --coverage sparse --out FOLDER` makes one; or name a placed \
                 scene file",
            ))
        })?
    } else {
        path.to_owned()
    };
    let scene = Scene::read(&file)?;
    scene.placed()?;
    Ok(scene)
}
