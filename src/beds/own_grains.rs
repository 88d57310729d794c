//! The user's own grains: a folder with `NAME.obj`, one bare body in micrometres, and `NAME.json` about it,
//! as Blender's window saves them (docs/authoring.md).

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::beds::solid::Solid;
use crate::geometry::ingest::obj::ObjFile;
use crate::scene::{FromLibrary, Packing, Shape, ShapeSource};
use crate::support::error::Failure;
use crate::support::file_error::FileError;
use crate::support::output::{self, OutputError};

/// Version of the format, the value of `soilsig_grain`.
pub const FORMAT: u32 = 1;

/// The diameter that a grain's JSON names may differ by this share from that of its mesh.
const DIAMETER: f64 = 0.01;

/// A library of grains cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// The folder cannot be read.
    #[error("cannot read the grains in {}: {source}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The folder has no grain.
    #[error("{}: there is no grain: no NAME.json beside a NAME.obj", folder.display())]
    Empty {
        /// The folder.
        folder: PathBuf,
    },
    /// A grain is refused.
    #[error("{}: {problem}", path.display())]
    Refused {
        /// Its file.
        path: PathBuf,
        /// What is wrong, and where.
        problem: String,
    },
    /// No grain is of a size class that the scene has.
    #[error("{}: none of the grains stands for a shape of the scene", folder.display())]
    NoneFits {
        /// The folder.
        folder: PathBuf,
        /// Size classes of the grains.
        there: Vec<&'static str>,
        /// Shapes of the scene.
        wanted: Vec<&'static str>,
    },
    /// The scene has grains of a library of its own.
    #[error("{}: the scene has grains of its own library {} already, {grain:?} for one", folder.display(), own.display())]
    TwoLibraries {
        /// The folder.
        folder: PathBuf,
        /// The scene's own.
        own: PathBuf,
        /// A grain of that.
        grain: String,
    },
}

impl Failure for LibraryError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Folder { .. } => return None,
            Self::Empty { .. } => {
                "save grains there from Blender's window: `soilsig blender --gui`".into()
            }
            Self::Refused { .. } => "mend it in Blender, where the check selects the faces \
                                     (docs/authoring.md); `soilsig grains check FOLDER` looks at all"
                .into(),
            Self::NoneFits { there, wanted, .. } => format!(
                "they are of the size classes {}, the scene has the shapes {}: assign one of these",
                there.join(", "),
                wanted.join(", ")
            ),
            Self::TwoLibraries { .. } => {
                "put all grains into one folder, and name it and them in the scene".into()
            }
        })
    }
}

/// What a grain's JSON says; the rest of it is for people.
#[derive(Debug, Clone, Deserialize)]
struct Entry {
    soilsig_grain: u32,
    size_class: Shape,
    diameter_um: f64,
}

/// A grain that passed every check.
#[derive(Debug, Clone)]
pub struct Grain {
    /// Its name, that of its files.
    pub name: String,
    /// The shape that it stands for.
    pub size_class: Shape,
    /// Diameter of the sphere of its volume, um.
    pub diameter_um: f64,
    /// How many faces it has.
    pub faces: usize,
}

impl Grain {
    /// Reads a grain and checks it.
    ///
    /// # Errors
    /// [`LibraryError::Refused`] with what is wrong and where.
    pub fn read(folder: &Path, name: &str) -> Result<Self, LibraryError> {
        let (json, obj) = (file(folder, name, "json"), file(folder, name, "obj"));
        let refused =
            |path: &Path, problem: String| LibraryError::Refused { path: path.to_owned(), problem };
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || name.len() > 40 || !name.chars().all(is_plain) {
            let problem = "a grain's name is up to 40 letters, digits, _ and -".to_owned();
            return Err(refused(&json, problem));
        }
        let text = fs::read_to_string(&json).map_err(|error| refused(&json, error.to_string()))?;
        let entry: Entry =
            serde_json::from_str(&text).map_err(|error| refused(&json, error.to_string()))?;
        if entry.soilsig_grain != FORMAT {
            let problem = format!(
                "soilsig_grain: version {} is not known; this program reads {FORMAT}",
                entry.soilsig_grain
            );
            return Err(refused(&json, problem));
        }
        let solid = solid(&obj).map_err(|problem| refused(&obj, problem))?;
        if let Some(fault) = solid.fault() {
            return Err(refused(&obj, fault));
        }
        let diameter_um = (6.0 * solid.volume_um3() / std::f64::consts::PI).cbrt();
        let said_um = entry.diameter_um;
        let agrees = (diameter_um / said_um - 1.0).abs() <= DIAMETER;
        if !agrees {
            let problem = format!(
                "its volume is that of a sphere of {diameter_um:.4} um, and {name}.json says \
                 {said_um} um: is its unit the micrometre?"
            );
            return Err(refused(&obj, problem));
        }
        let Entry { size_class, .. } = entry;
        Ok(Self { name: name.to_owned(), size_class, diameter_um, faces: solid.faces.len() })
    }
}

/// Names of the grains in a folder, sorted: of every `.obj`, and every `.json` that is about a grain.
pub fn names(folder: &Path) -> Result<Vec<String>, LibraryError> {
    let failed = |source| LibraryError::Folder { folder: folder.to_owned(), source };
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_grain = match path.extension().and_then(|ending| ending.to_str()) {
            Some("obj") => true,
            // Others, such as a scene, may stand beside them.
            Some("json") => {
                fs::read_to_string(&path).is_ok_and(|t| t.contains("\"soilsig_grain\""))
            }
            _ => false,
        };
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        if is_grain && !stem.starts_with('.') {
            names.insert(stem.into_owned());
        }
    }
    if names.is_empty() {
        return Err(LibraryError::Empty { folder: folder.to_owned() });
    }
    Ok(names.into_iter().collect())
}

/// Puts the grains of a folder in the place of the shapes that are their size classes, and of the ribs asked of
/// these: the recipe then names them, and the folder.
pub fn stand_in(packing: &mut Packing, folder: &Path) -> Result<(), LibraryError> {
    let mut classes: BTreeMap<Shape, Vec<String>> = BTreeMap::new();
    for name in names(folder)? {
        let grain = Grain::read(folder, &name)?;
        classes.entry(grain.size_class).or_default().push(grain.name);
    }
    let named = packing.shapes().find_map(|(_, shape, _)| match shape {
        ShapeSource::Library(FromLibrary { library }) => library.first().cloned(),
        ShapeSource::Modelled(_) => None,
    });
    if let (Some(grain), Some(own)) = (named, packing.library.clone()) {
        return Err(LibraryError::TwoLibraries { folder: folder.to_owned(), own, grain });
    }
    let mut wanted = BTreeSet::new();
    let mut any = false;
    for (shape, ribs) in packing.shapes_mut() {
        let ShapeSource::Modelled(modelled) = *shape else { continue };
        wanted.insert(modelled.name());
        if let Some(names) = classes.get(&modelled) {
            *shape = ShapeSource::Library(FromLibrary { library: names.clone() });
            *ribs = None;
            any = true;
        }
    }
    if !any {
        return Err(LibraryError::NoneFits {
            folder: folder.to_owned(),
            there: classes.into_keys().map(Shape::name).collect(),
            wanted: wanted.into_iter().collect(),
        });
    }
    packing.library = Some(folder.to_owned());
    Ok(())
}

/// The grains that a packing names.
#[derive(Debug)]
pub struct Library {
    folder: PathBuf,
    /// SHA-256 of the mesh of each grain, by its name.
    sha256: BTreeMap<String, String>,
}

impl Library {
    /// Checks the grains that a packing names; `None` if it names none. Its library is relative to `folder`.
    pub fn of(
        packing: &Packing,
        folder: &Path,
    ) -> Result<Option<Self>, crate::support::error::Error> {
        let names: BTreeSet<&String> = packing
            .shapes()
            .filter_map(|(_, shape, _)| match shape {
                ShapeSource::Library(FromLibrary { library }) => Some(library),
                ShapeSource::Modelled(_) => None,
            })
            .flatten()
            .collect();
        let (false, Some(library)) = (names.is_empty(), &packing.library) else { return Ok(None) };
        let folder = folder.join(library);
        let mut sha256 = BTreeMap::new();
        for name in names {
            Grain::read(&folder, name)?;
            sha256.insert(name.clone(), output::sha256_hex(&file(&folder, name, "obj"))?);
        }
        Ok(Some(Self { folder, sha256 }))
    }

    /// SHA-256 of the mesh of each grain, by its name.
    pub fn sha256(&self) -> &BTreeMap<String, String> {
        &self.sha256
    }

    /// The files of the grains.
    pub fn files(&self) -> Vec<PathBuf> {
        let both = |name: &String| ["json", "obj"].map(|ending| file(&self.folder, name, ending));
        self.sha256.keys().flat_map(both).collect()
    }

    /// Copies them.
    pub(crate) fn copy_to(&self, folder: &Path) -> Result<(), OutputError> {
        self.files().iter().try_for_each(|from| {
            output::copy(from, &folder.join(from.file_name().expect("a file has a name")))
        })
    }
}

fn file(folder: &Path, name: &str, ending: &str) -> PathBuf {
    folder.join(format!("{name}.{ending}"))
}

/// The mesh of a .obj file, all of it.
fn solid(path: &Path) -> Result<Solid, String> {
    let file = ObjFile::read(path).map_err(|error| match error {
        FileError::Read { source, .. } => source.to_string(),
        FileError::Wrong { place: Some(place), problem, .. } => format!("{place}: {problem}"),
        FileError::Wrong { problem, .. } => problem,
    })?;
    let (vertices, faces) = file.polygons(None);
    Ok(Solid { vertices, faces })
}
