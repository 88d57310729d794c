//! The user's own grains: a folder with `NAME.obj`, one bare body in micrometres, and `NAME.json`
//! about it, as Blender's window saves them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::beds::solid::Solid;
use crate::geometry::ingest::obj::ObjFile;
use crate::scene::{FromLibrary, Packing, Shape, ShapeSource};
use crate::support::error::{Error, Failure};
use crate::support::file_error::FileError;
use crate::support::math;
use crate::support::output::{self, OutputError};

/// Version of the format, the value of `soilsig_grain`.
pub const FORMAT: u32 = 1;

/// The largest relative difference between the diameter in a grain's JSON and that of its mesh.
const DIAMETER_TOLERANCE: f64 = 0.01;

/// Own grains cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OwnGrainsError {
    /// The folder or a file cannot be read, or a grain is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// A scan cannot be read, or is no sound body.
    #[error(transparent)]
    Scan(FileError),
    /// The folder has no grain.
    #[error("{}: the folder has no grain (NAME.obj with NAME.json)", folder.display())]
    Empty {
        /// The folder.
        folder: PathBuf,
    },
    /// No grain stands for a shape of the scene.
    #[error("{}: no grain stands for a shape of the scene", folder.display())]
    NoneFits {
        /// The folder.
        folder: PathBuf,
        /// Shapes that the grains stand for.
        there: Vec<&'static str>,
        /// Shapes of the scene.
        wanted: Vec<&'static str>,
    },
    /// The scene names grains of another folder.
    #[error("{}: the scene already uses grains of {}, such as {grain}", folder.display(), own.display())]
    TwoFolders {
        /// The folder.
        folder: PathBuf,
        /// The scene's folder.
        own: PathBuf,
        /// A grain of the scene's folder.
        grain: String,
    },
}

impl Failure for OwnGrainsError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::File(FileError::Read { .. }) | Self::Scan(FileError::Read { .. }) => return None,
            Self::Scan(FileError::Wrong { .. }) => {
                "mend the mesh in Blender or in the program that wrote it, and import it again \
                 (docs: own grains)"
                    .into()
            }
            Self::File(FileError::Wrong { .. }) => {
                "correct it in Blender's window, whose check selects the faces (docs: own \
                 grains); `soilsig grains check FOLDER` checks all grains"
                    .into()
            }
            Self::Empty { .. } => {
                "save grains there from Blender's window: `soilsig blender --gui`".into()
            }
            Self::NoneFits { there, wanted, .. } => format!(
                "the grains stand for {}, the scene has {}: assign one of these",
                there.join(", "),
                wanted.join(", ")
            ),
            Self::TwoFolders { .. } => {
                "put all grains into one folder, and name it and them in the scene".into()
            }
        })
    }
}

/// A grain's JSON; its other keys are for people.
#[derive(Debug, Deserialize)]
struct Entry {
    soilsig_grain: u32,
    #[serde(alias = "size_class")]
    shape: Shape,
    diameter_um: f64,
}

/// A grain that passed every check.
#[derive(Debug, Clone)]
pub struct Grain {
    /// The name of its files.
    pub name: String,
    /// The shape that it stands for.
    pub shape: Shape,
    /// Diameter of the sphere of its volume, um.
    pub diameter_um: f64,
    /// The number of its faces.
    pub faces: usize,
}

impl Grain {
    /// Reads a grain and checks it.
    ///
    /// # Errors
    /// A file that is missing, cannot be read, or is wrong: what is wrong and where.
    pub fn read(folder: &Path, name: &str) -> Result<Self, FileError> {
        let (json, obj) = (file(folder, name, "json"), file(folder, name, "obj"));
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || name.len() > 40 || !name.chars().all(is_plain) {
            let problem = "a grain's name has at most 40 characters: letters, digits, _ and -";
            return Err(FileError::wrong(&json, problem));
        }
        if let Some(missing) = [&json, &obj].into_iter().find(|path| !path.exists()) {
            let ending = if missing == &json { "json" } else { "obj" };
            let problem = format!(
                "{name}.{ending} is missing: save the grain from Blender's panel, or write the file"
            );
            return Err(FileError::wrong(missing, problem));
        }
        let text = fs::read(&json).map_err(FileError::read(&json))?;
        let Entry { soilsig_grain, shape, diameter_um: stated_um } =
            serde_json::from_slice(&text).map_err(|e| FileError::wrong(&json, e.to_string()))?;
        if soilsig_grain != FORMAT {
            let problem =
                format!("version {soilsig_grain} is not known; this program reads {FORMAT}");
            return Err(FileError::wrong_at(&json, "soilsig_grain", problem));
        }
        let solid = solid(&obj)?;
        if let Some(fault) = solid.fault() {
            return Err(FileError::wrong(&obj, fault));
        }
        let diameter_um = math::cbrt(6.0 * solid.volume_um3() / std::f64::consts::PI);
        let difference = (diameter_um / stated_um - 1.0).abs();
        if difference.is_nan() || difference > DIAMETER_TOLERANCE {
            let problem = format!(
                "its volume is that of a sphere of {diameter_um:.4} um, but {name}.json states \
                 {stated_um} um: is its unit the micrometre?"
            );
            return Err(FileError::wrong(&obj, problem));
        }
        Ok(Self { name: name.to_owned(), shape, diameter_um, faces: solid.faces.len() })
    }
}

/// Names of the grains in a folder, sorted: of every `.obj`, and every `.json` about a grain.
pub fn names(folder: &Path) -> Result<Vec<String>, OwnGrainsError> {
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(folder).map_err(FileError::read(folder))? {
        let path = entry.map_err(FileError::read(folder))?.path();
        let is_grain = match path.extension().and_then(|ending| ending.to_str()) {
            Some("obj") => true,
            // Other files, such as a scene, may lie in the folder.
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
        return Err(OwnGrainsError::Empty { folder: folder.to_owned() });
    }
    Ok(names.into_iter().collect())
}

/// Replaces the shapes of a packing by the grains of a folder that stand for them. The
/// packing then names the grains and the folder, and no ribs for them.
pub fn replace_shapes(packing: &mut Packing, folder: &Path) -> Result<(), OwnGrainsError> {
    let mut of_shape: BTreeMap<Shape, Vec<String>> = BTreeMap::new();
    for name in names(folder)? {
        let grain = Grain::read(folder, &name)?;
        of_shape.entry(grain.shape).or_default().push(grain.name);
    }
    if let (Some(own), Some(grain)) = (packing.library.clone(), named(packing).next().cloned()) {
        return Err(OwnGrainsError::TwoFolders { folder: folder.to_owned(), own, grain });
    }
    let mut wanted = BTreeSet::new();
    let mut is_used = false;
    for (shape, ribs) in packing.shapes_mut() {
        let ShapeSource::Modelled(modelled) = *shape else { continue };
        wanted.insert(modelled.name());
        if let Some(names) = of_shape.get(&modelled) {
            *shape = ShapeSource::Library(FromLibrary { library: names.clone() });
            *ribs = None;
            is_used = true;
        }
    }
    if !is_used {
        return Err(OwnGrainsError::NoneFits {
            folder: folder.to_owned(),
            there: of_shape.into_keys().map(Shape::name).collect(),
            wanted: wanted.into_iter().collect(),
        });
    }
    packing.library = Some(folder.to_owned());
    Ok(())
}

/// Names of the own grains in a packing.
fn named(packing: &Packing) -> impl Iterator<Item = &String> {
    let of_shape = |(_, shape, _)| match shape {
        &ShapeSource::Library(FromLibrary { ref library }) => library.as_slice(),
        ShapeSource::Modelled(_) | ShapeSource::Form(_) => &[],
    };
    packing.shapes().flat_map(of_shape)
}

/// The own grains of a packing.
#[derive(Debug)]
pub struct OwnGrains {
    folder: PathBuf,
    /// SHA-256 of the mesh of each grain, by its name.
    sha256: BTreeMap<String, String>,
}

impl OwnGrains {
    /// Checks the grains that a packing names; `None` if it names none. The path of the packing's
    /// folder of grains is relative to `folder`.
    pub fn of(packing: &Packing, folder: &Path) -> Result<Option<Self>, Error> {
        let Some(library) = &packing.library else { return Ok(None) };
        let folder = folder.join(library);
        let mut sha256 = BTreeMap::new();
        for name in named(packing) {
            if !sha256.contains_key(name) {
                Grain::read(&folder, name).map_err(OwnGrainsError::from)?;
                sha256.insert(name.clone(), output::sha256_hex(&file(&folder, name, "obj"))?);
            }
        }
        Ok((!sha256.is_empty()).then_some(Self { folder, sha256 }))
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

    /// Copies the files into another folder.
    pub(super) fn copy_to(&self, folder: &Path) -> Result<(), OutputError> {
        self.files().iter().try_for_each(|from| {
            output::copy(from, &folder.join(from.file_name().expect("a file has a name")))
        })
    }
}

fn file(folder: &Path, name: &str, ending: &str) -> PathBuf {
    folder.join(format!("{name}.{ending}"))
}

/// All faces of an .obj file as one mesh.
fn solid(path: &Path) -> Result<Solid, FileError> {
    let (vertices, faces) = ObjFile::read_whole(path)?.polygons(None);
    Ok(Solid { vertices, faces })
}
