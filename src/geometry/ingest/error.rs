//! Why the meshes of a scene cannot be used.

use std::path::PathBuf;

use crate::geometry::{MOST_PATCHES, MOST_PLACEMENTS, MOST_TRIANGLES};
use crate::scene::SceneError;
use crate::support::error::Failure;
use crate::support::file_error::FileError;
use crate::support::resources::ResourceError;

/// A mesh file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum IngestError {
    /// The scene is a recipe, not placed geometry.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The file cannot be read or is broken.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file has a format that cannot be read.
    #[error("{}: meshes are read from .obj, .gltf and .glb files", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The file has no object of that name.
    #[error("{}: there is no object {object:?}", path.display())]
    NoObject {
        /// The file.
        path: PathBuf,
        /// The name wanted.
        object: String,
        /// Names of the objects in the file.
        present: Vec<String>,
    },
    /// Faces name a material that the scene does not have.
    #[error("{}: {object}: {}", path.display(), match material {
        Some(name) => format!("faces have the material {name:?}, which the scene does not name"),
        None => "faces have no material".to_owned(),
    })]
    NoMaterial {
        /// The file.
        path: PathBuf,
        /// The object.
        object: String,
        /// The material of the faces, if any.
        material: Option<String>,
        /// Materials of the scene.
        known: Vec<String>,
    },
    /// The patch cannot be repeated to a field of so many particles.
    #[error(
        "{}: geometry.placed.domain.sides.field: {particles:e} particles need more than \
         {MOST_PATCHES} patches a side, or the patch has no particle",
        path.display()
    )]
    Field {
        /// The scene file.
        path: PathBuf,
        /// Particles wanted.
        particles: f64,
    },
    /// The bed reaches too far, as after a mistake in units.
    #[error("{}: the bed reaches {farthest_um:e} um from the origin, beyond a kilometre", path.display())]
    Far {
        /// The scene file.
        path: PathBuf,
        /// Its greatest coordinate, um.
        farthest_um: f64,
    },
    /// There are more placements, or triangles of a mesh, than can be traced.
    #[error(
        "{}: {placements} placed meshes, or {triangles} triangles in one mesh, cannot be traced: \
         the most are {MOST_PLACEMENTS} and {MOST_TRIANGLES}",
        path.display()
    )]
    Many {
        /// The scene file.
        path: PathBuf,
        /// Its placements.
        placements: usize,
        /// Triangles of its largest mesh.
        triangles: usize,
    },
    /// There is not memory enough.
    #[error("{}: {source}", path.display())]
    Memory {
        /// The scene file.
        path: PathBuf,
        /// What is needed, and what is free.
        source: ResourceError,
    },
    /// Nothing is placed in the domain.
    #[error("{}: nothing stands within the domain", path.display())]
    Empty {
        /// The scene file.
        path: PathBuf,
    },
}

impl Failure for IngestError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Scene(error) => return error.hint(),
            Self::File(error) => {
                return error.hint_or("export the mesh again as triangles, or mend it in Blender");
            }
            Self::NoObject { present, .. } if present.is_empty() => "the file names none".into(),
            Self::NoObject { present, .. } => format!("it has {}", listed(present)),
            Self::NoMaterial { known, .. } => format!(
                "name it under \"materials\" in the scene, or give the prototype a \"material\": {}",
                listed(known)
            ),
            Self::Field { .. } => {
                "ask for fewer particles, or widen the domain so that it holds their middles".into()
            }
            Self::Far { .. } => {
                "give its prototypes the right \"unit_um\", and place it near the origin".into()
            }
            Self::Many { .. } | Self::Memory { .. } => {
                "trace a smaller part of the bed, with \"sides\": \"mirror\" or \"field\"".into()
            }
            Self::Empty { .. } => "compare the domain with where the instances stand".into(),
            Self::Format { .. } => "export the mesh as .obj or .glb, for example in Blender".into(),
        })
    }
}

fn listed(names: &[String]) -> String {
    let shown = names.iter().take(8).map(String::as_str).collect::<Vec<_>>().join(", ");
    if names.len() > 8 { format!("{shown}, ... ({} in all)", names.len()) } else { shown }
}
