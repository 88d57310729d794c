//! Where the geometry of a picture comes from.

use std::path::{Path, PathBuf};

use super::error::PictureError;
use crate::geometry::{Bed, ingest};
use crate::scene::Scene;
use crate::support::error::Error;

/// A placed scene and its file.
#[derive(Debug, Clone)]
pub struct Source {
    /// The scene.
    pub scene: Scene,
    /// Its file.
    pub path: PathBuf,
}

impl Source {
    /// Reads a placed scene: from its file, or from the folder of a pipeline's result. Of several packings it
    /// is the first one.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let path = if path.is_dir() {
            let places = ["scene.json", "packings/1/scene.json"].map(|place| path.join(place));
            let found = places.into_iter().find(|place| place.is_file());
            found.ok_or_else(|| PictureError::NoScene { folder: path.to_owned() })?
        } else {
            path.to_owned()
        };
        let scene = Scene::read(&path)?;
        scene.placed(&path)?;
        Ok(Self { scene, path })
    }

    /// Its meshes in their places.
    pub fn bed(&self) -> Result<Bed, Error> {
        Ok(ingest::load(&self.scene, &self.path)?)
    }
}
