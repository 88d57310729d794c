//! What can go wrong, as the command line reports it: a message, a remedy, an exit status.

use std::path::PathBuf;

use crate::beds::own_grains::LibraryError;
use crate::blender::BlenderError;
use crate::draw::picture::PictureError;
use crate::draw::plot::PlotError;
use crate::geometry::ingest::IngestError;
use crate::pipeline::record::RecordError;
use crate::products::export::DirsigError;
use crate::products::image::ImageError;
use crate::radiometry::RadiometryError;
use crate::scene::SceneError;
use crate::spectrum::SpectrumError;
use crate::studies::chart::BesideError;
use crate::support::envi::EnviError;
use crate::support::output::OutputError;
use crate::table::TableError;

/// Exit statuses of the program, so that scripts can tell failures apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// A file could not be read or written.
    Files = 1,
    /// The command line is wrong (clap's own status).
    Usage = 2,
    /// A scene, spectrum, mesh or table is wrong.
    Input = 3,
    /// The caps on paths or time ended the trace before its tolerance; the result is written.
    ToleranceNotReached = 4,
    /// A replayed run gave other bytes.
    ReplayDiffers = 5,
    /// No Blender was found.
    BlenderMissing = 10,
    /// The Blender found is of a version that will not do.
    BlenderVersion = 11,
    /// Blender's Python has no numpy.
    BlenderNumpy = 12,
    /// A script failed inside Blender.
    BlenderScript = 13,
    /// Blender crashed.
    BlenderCrash = 14,
    /// Blender did not end within its time limit.
    BlenderTimeout = 15,
    /// The bed that came out of the drop is not to be trusted.
    BlenderRefused = 16,
    /// Ctrl-C.
    Interrupted = 130,
}

/// Any failure of the library.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Blender could not be found or did not do its work.
    #[error(transparent)]
    Blender(#[from] BlenderError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The cache cannot be used.
    #[error("the cache: {0}")]
    Cache(OutputError),
    /// Several packings are wanted of a scene that is one.
    #[error("{}: several packings are wanted, but the scene is placed: it is one packing", scene.display())]
    OnePacking {
        /// The scene file.
        scene: PathBuf,
    },
    /// A field is wanted of a scene that says itself what is at its sides.
    #[error("{}: a field is wanted, but the scene is placed: it says itself what is at its sides", scene.display())]
    FieldOfPlaced {
        /// The scene file.
        scene: PathBuf,
    },
    /// Grains are given for a scene whose grains are placed already.
    #[error("{}: grains are given, but the scene is placed: it has its own", scene.display())]
    GrainsOfPlaced {
        /// The scene file.
        scene: PathBuf,
    },
    /// A grain of the user's cannot be used.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// An input of a recorded run is gone.
    #[error("an input of the recorded run: {0}")]
    Input(OutputError),
    /// A scene file is wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A mesh file is wrong.
    #[error(transparent)]
    Ingest(#[from] IngestError),
    /// A spectrum is wrong or does not reach as far as is wanted.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// A material's spectrum is wrong.
    #[error("{}: material {material:?}: {source}", scene.display())]
    Material {
        /// The scene file.
        scene: PathBuf,
        /// The material.
        material: String,
        /// What is wrong with its spectrum.
        source: SpectrumError,
    },
    /// An image cannot be made.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A DIRSIG file is wrong.
    #[error(transparent)]
    Dirsig(#[from] DirsigError),
    /// An ENVI image is wrong.
    #[error(transparent)]
    Envi(#[from] EnviError),
    /// A file of radiances is wrong or does not reach as far as is wanted.
    #[error(transparent)]
    Radiometry(#[from] RadiometryError),
    /// A bounce table is wrong.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Settings measured elsewhere cannot be charted.
    #[error(transparent)]
    Beside(#[from] BesideError),
    /// A chart could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// There is nothing to make a picture of.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A record of a run is wrong.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// There is no such coverage.
    #[error("there is no coverage {wanted:?}")]
    Coverage {
        /// The coverage wanted.
        wanted: String,
        /// Those that there are.
        known: String,
    },
    /// The user asked to stop.
    #[error("interrupted; nothing half-written was left")]
    Interrupted,
}

impl Error {
    /// The program's exit status.
    pub fn status(&self) -> Status {
        match self {
            Self::Blender(error) => error.status(),
            Self::Output(_) | Self::Cache(_) | Self::Input(_) => Status::Files,
            Self::Coverage { .. }
            | Self::OnePacking { .. }
            | Self::FieldOfPlaced { .. }
            | Self::GrainsOfPlaced { .. } => Status::Usage,
            Self::Scene(_)
            | Self::Ingest(_)
            | Self::Library(_)
            | Self::Spectrum(_)
            | Self::Material { .. }
            | Self::Image(_)
            | Self::Dirsig(_)
            | Self::Envi(_)
            | Self::Radiometry(_)
            | Self::Table(_)
            | Self::Beside(_)
            | Self::Plot(_)
            | Self::Picture(_)
            | Self::Record(_) => Status::Input,
            Self::Interrupted => Status::Interrupted,
        }
    }

    /// What the user can do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Blender(error) => error.hint(),
            Self::Output(error) => error.hint(),
            Self::Cache(_) => {
                Some("name another folder in SOILSIG_CACHE, or use --no-cache".into())
            }
            Self::Input(_) => Some("put it back where it was, or run the pipeline anew".into()),
            Self::Scene(error) => error.hint(),
            Self::Ingest(error) => error.hint(),
            Self::Library(error) => error.hint(),
            Self::GrainsOfPlaced { .. } => {
                Some("give the recipe that it was dropped from, or leave --grains out".into())
            }
            Self::Spectrum(error) | Self::Material { source: error, .. } => error.hint(),
            Self::Image(error) => error.hint(),
            Self::Dirsig(error) => error.hint(),
            Self::Envi(error) => error.hint(),
            Self::Radiometry(error) => error.hint(),
            Self::Table(error) => error.hint(),
            Self::Beside(error) => error.hint(),
            Self::Plot(error) => error.hint(),
            Self::Coverage { known, .. } => {
                Some(format!("there are {known}, all, and any share from 0 to 1"))
            }
            Self::Picture(error) => error.hint(),
            Self::FieldOfPlaced { .. } => Some(
                r#"write "sides": {"field": {"particles": N}} into its geometry.placed.domain"#
                    .into(),
            ),
            Self::OnePacking { .. } => {
                Some("give the recipe that it was dropped from, or leave --packings out".into())
            }
            Self::Record(_) | Self::Interrupted => None,
        }
    }
}
