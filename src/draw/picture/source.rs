//! The scene of a picture.

use std::path::Path;

use super::error::PictureError;
use crate::scene::Scene;
use crate::support::error::Error;

/// Reads a placed scene from its file, or from the folder of a pipeline's result. Of several packings
/// it reads the first.
pub fn placed_scene(path: &Path) -> Result<Scene, Error> {
    let file = if path.is_dir() {
        let places = ["scene.json", "packings/1/scene.json"].map(|place| path.join(place));
        let found = places.into_iter().find(|place| place.is_file());
        found.ok_or_else(|| PictureError::NoScene { folder: path.to_owned() })?
    } else {
        path.to_owned()
    };
    let scene = Scene::read(&file)?;
    scene.placed()?;
    Ok(scene)
}
