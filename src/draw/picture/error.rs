//! What can be wrong with what a picture is to be made of.

use std::path::PathBuf;

/// Version of the record of a drop, the value of `soilsig_frames`.
pub const FORMAT: u32 = 1;
use crate::support::error::Failure;

/// A picture cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// A folder is no result of the pipeline.
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
        /// Names that there are.
        known: String,
    },
    /// The recorded drop cannot be read.
    #[error("cannot read the recorded drop {}: {source}", path.display())]
    NoFrames {
        /// The file that was looked for.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The recorded drop is not JSON of its form.
    #[error("{}: {source}", path.display())]
    FramesForm {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// The recorded drop does not hold together, or not with its scene.
    #[error("{}: {place}: {problem}", path.display())]
    FramesValue {
        /// The file.
        path: PathBuf,
        /// The key in the file.
        place: String,
        /// What is wrong with it.
        problem: String,
    },
}

impl Failure for PictureError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::NoScene { folder } => format!(
                "`soilsig pipeline --coverage sparse --out {}` makes one; or name a placed scene file",
                folder.display()
            ),
            Self::NoPrototype { known, .. } => format!("it has {known}"),
            Self::NoFrames { path, .. } => {
                let folder = path.parent().unwrap_or(path);
                format!(
                    "`soilsig pipeline` writes it beside scene.json when Blender drops a bed: run it again \
                     with --out {}",
                    folder.display()
                )
            }
            Self::FramesForm { .. } | Self::FramesValue { .. } => format!(
                "run the pipeline again; this program reads version {FORMAT} of recorded drops"
            ),
        })
    }
}
