//! Why a picture cannot be made.

use std::path::PathBuf;

use crate::support::error::Failure;
use crate::support::file_error::FileError;

/// Version of the record of a drop, the value of `soilsig_frames`.
pub const FORMAT: u32 = 1;

/// A picture cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// A folder is not a result of the pipeline.
    #[error("{}: there is no scene.json in this folder", folder.display())]
    NoScene {
        /// The folder.
        folder: PathBuf,
    },
    /// The scene has no prototype of that name.
    #[error("{}: there is no prototype {wanted:?}", scene.display())]
    NoPrototype {
        /// The scene file.
        scene: PathBuf,
        /// The name.
        wanted: String,
        /// The names of the scene's prototypes.
        known: String,
    },
    /// The record of the drop cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
}

impl Failure for PictureError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::NoScene { folder } => format!(
                "`soilsig pipeline --coverage sparse --out {}` makes one; or name a placed scene \
                 file",
                folder.display()
            ),
            Self::NoPrototype { known, .. } => format!("it has {known}"),
            Self::File(FileError::Read { path, .. }) => format!(
                "`soilsig pipeline` writes it beside scene.json when Blender drops a bed: run it \
                 again with --out {}",
                path.parent().unwrap_or(path).display()
            ),
            Self::File(FileError::Wrong { .. }) => format!(
                "run the pipeline again; this program reads version {FORMAT} of recorded drops"
            ),
        })
    }
}
