//! From a scene's files to a [`Bed`].

mod gltf;
mod obj;

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};

use crate::geometry::{self, Bed, Domain, Mesh, Placement};
use crate::scene::{FARTHEST_UM, Placed, Prototype, Scene, SceneError, Sides, UpAxis};
use crate::support::error::Failure;

/// A mesh file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum IngestError {
    /// The scene is a recipe, not placed geometry.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The file cannot be read.
    #[error("cannot read the mesh {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is of no kind that can be read.
    #[error("{}: meshes are read from .obj, .gltf and .glb files", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The file is broken.
    #[error("{}: {place}: {problem}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// Line, object or node.
        place: String,
        /// What is wrong there.
        problem: String,
    },
    /// The file has no object of that name.
    #[error("{}: there is no object {object:?}", path.display())]
    NoObject {
        /// The file.
        path: PathBuf,
        /// The name wanted.
        object: String,
        /// Names that there are.
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
    /// A field of so many particles cannot be made of the patch.
    #[error(
        "{}: geometry.placed.domain.sides.field: {particles:e} particles would be more than {} patches a side, \
         or the patch has none",
        path.display(),
        geometry::MOST_PATCHES
    )]
    Field {
        /// The scene file.
        path: PathBuf,
        /// Particles wanted.
        particles: f64,
    },
    /// The bed reaches farther than a mistake in units lets it.
    #[error("{}: the bed reaches as far as {farthest_um:e} um, beyond a kilometre", path.display())]
    Far {
        /// The scene file.
        path: PathBuf,
        /// Its greatest coordinate, um.
        farthest_um: f64,
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
            Self::NoObject { present, .. } if present.is_empty() => "the file names none".into(),
            Self::NoObject { present, .. } => format!("it has {}", listed(present)),
            Self::NoMaterial { known, .. } => format!(
                "name it under \"materials\" in the scene, or give the prototype a \"material\": {}",
                listed(known)
            ),
            Self::Broken { .. } => {
                "export the mesh again as triangles, or mend it in Blender".into()
            }
            Self::Field { .. } => {
                "ask for fewer, or for a domain within which particles have their middle".into()
            }
            Self::Far { .. } => {
                "give its prototypes the right \"unit_um\", and place it near the origin".into()
            }
            Self::Empty { .. } => "compare the domain with where the instances stand".into(),
            Self::Format { .. } => "export the mesh as .obj or .glb, with Blender for one".into(),
            Self::Read { .. } => return None,
        })
    }
}

fn listed(names: &[String]) -> String {
    let shown = names.iter().take(8).map(String::as_str).collect::<Vec<_>>().join(", ");
    if names.len() > 8 { format!("{shown}, ... ({} in all)", names.len()) } else { shown }
}

/// The scene's materials by name, or the one that stands for all.
pub(crate) struct Materials<'a> {
    scene: &'a Scene,
    instead: Option<&'a str>,
}

impl Materials<'_> {
    pub(crate) fn index(
        &self,
        path: &Path,
        object: &str,
        name: Option<&str>,
    ) -> Result<u16, IngestError> {
        let wanted = self.instead.or(name);
        wanted
            .and_then(|name| self.scene.material_index(name))
            .map(|index| index as u16)
            .ok_or_else(|| IngestError::NoMaterial {
                path: path.to_owned(),
                object: object.to_owned(),
                material: wanted.map(str::to_owned),
                known: self.scene.materials.iter().map(|m| m.name.clone()).collect(),
            })
    }
}

/// A mesh of a file with the place that the file gives it.
pub(crate) type Part = (Mesh, DAffine3);

/// Reads all meshes of a placed scene.
pub fn load(scene: &Scene) -> Result<Bed, IngestError> {
    let placed = scene.placed()?;
    let path = &scene.file;
    let mut obj_files = HashMap::new();
    let mut meshes = Vec::new();
    let mut parts: BTreeMap<&str, Vec<Placement>> = BTreeMap::new();
    for prototype in &placed.prototypes {
        let read = read_prototype(scene, prototype, &mut obj_files)?;
        let placements = parts.entry(&prototype.name).or_default();
        for (mesh, places) in read {
            placements.extend(
                places.into_iter().map(|to_scene| Placement { mesh: meshes.len(), to_scene }),
            );
            meshes.push(mesh);
        }
    }
    let placements: Vec<Placement> = match &placed.instances {
        None => parts.into_values().flatten().collect(),
        Some(instances) => instances
            .iter()
            .flat_map(|instance| {
                let place = affine(&instance.transform);
                parts[instance.prototype.as_str()]
                    .iter()
                    .map(move |part| Placement { mesh: part.mesh, to_scene: place * part.to_scene })
            })
            .collect(),
    };
    let (low, high) = Bed::bounds_um(&meshes, &placements);
    let farthest_um = low.abs().max(high.abs()).max_element();
    if !placements.is_empty() && (farthest_um.is_nan() || farthest_um >= FARTHEST_UM) {
        return Err(IngestError::Far { path: path.to_owned(), farthest_um });
    }
    let domain = domain(scene, placed, &meshes, &placements)
        .ok_or_else(|| IngestError::Empty { path: path.to_owned() })?;
    let floor_um = domain.floor.map_or(0.0, |(z_um, _)| z_um.abs());
    let farthest_um = domain.min_um.abs().max(domain.max_um.abs()).max_element().max(floor_um);
    if farthest_um.is_nan() || farthest_um >= FARTHEST_UM {
        return Err(IngestError::Far { path: path.to_owned(), farthest_um });
    }
    let mut bed = Bed {
        meshes,
        placements,
        domain,
        to_sensor: geometry::to_sensor(scene.view),
        materials: scene.materials.len(),
    };
    if let Sides::Field { particles, .. } = bed.domain.sides {
        let patches = geometry::patches(&bed, particles);
        bed.domain.patches =
            patches.ok_or_else(|| IngestError::Field { path: path.to_owned(), particles })?;
    }
    Ok(bed)
}

/// All mesh files of a placed scene, those that glTF files refer to as well.
pub fn files(scene: &Scene) -> Result<Vec<PathBuf>, IngestError> {
    let mut files = Vec::new();
    for prototype in &scene.placed()?.prototypes {
        let file = scene.path_of(&prototype.file);
        if Format::of(&file)? == Format::Gltf {
            files.extend(gltf::buffer_files(&file)?);
        }
        files.push(file);
    }
    files.sort_unstable();
    files.dedup();
    match files.iter().find_map(|file| Some((file, File::open(file).err()?))) {
        Some((file, source)) => Err(IngestError::Read { path: file.clone(), source }),
        None => Ok(files),
    }
}

#[derive(PartialEq)]
enum Format {
    Obj,
    Gltf,
}

impl Format {
    fn of(file: &Path) -> Result<Self, IngestError> {
        let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match ending.as_str() {
            "obj" => Ok(Self::Obj),
            "gltf" | "glb" => Ok(Self::Gltf),
            _ => Err(IngestError::Format { path: file.to_owned() }),
        }
    }
}

type ObjFiles = HashMap<PathBuf, obj::ObjFile>;

/// The meshes of one prototype, each with the places at which its file has it.
fn read_prototype(
    scene: &Scene,
    prototype: &Prototype,
    obj_files: &mut ObjFiles,
) -> Result<Vec<(Mesh, Vec<DAffine3>)>, IngestError> {
    let path = scene.path_of(&prototype.file);
    let materials = Materials { scene, instead: prototype.material.as_deref() };
    let is_gltf = Format::of(&path)? == Format::Gltf;
    let unit_um = prototype.unit_um.unwrap_or(if is_gltf { 1e6 } else { 1.0 });
    let up = prototype.up.unwrap_or(if is_gltf { UpAxis::Y } else { UpAxis::Z });
    let turn = match up {
        UpAxis::Z => DMat3::IDENTITY,
        UpAxis::Y => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
    };
    let object = prototype.object.as_deref();
    if is_gltf {
        gltf::read(&path, object, unit_um, turn, &materials)
    } else {
        if !obj_files.contains_key(&path) {
            obj_files.insert(path.clone(), obj::ObjFile::read(&path)?);
        }
        let (mesh, place) =
            obj_files[&path].mesh(&path, &prototype.name, object, unit_um, turn, &materials)?;
        Ok(vec![(mesh, vec![place])])
    }
}

fn affine(m: &[f64; 12]) -> DAffine3 {
    DAffine3::from_cols(
        DVec3::new(m[0], m[4], m[8]),
        DVec3::new(m[1], m[5], m[9]),
        DVec3::new(m[2], m[6], m[10]),
        DVec3::new(m[3], m[7], m[11]),
    )
}

fn domain(
    scene: &Scene,
    placed: &Placed,
    meshes: &[Mesh],
    placements: &[Placement],
) -> Option<Domain> {
    let (low, high) = Bed::bounds_um(meshes, placements);
    let (min, max, sides, floor) = match &placed.domain {
        None => ([low.x, low.y], [high.x, high.y], Sides::Open, None),
        Some(given) => {
            let floor = given.floor.as_ref().and_then(|floor| {
                Some((floor.z_um, scene.material_index(&floor.material)? as u16))
            });
            (given.min_um, given.max_um, given.sides, floor)
        }
    };
    let bottom = floor.map_or(low.z, |(z, _)| low.z.min(z));
    let top = floor.map_or(high.z, |(z, _)| high.z.max(z));
    // A little room, so that nothing lies in the bounding planes themselves.
    let room = 1e-3 * (top - bottom).max(max[0] - min[0]).max(max[1] - min[1]);
    let overlaps = (0..2).all(|axis| low[axis] <= max[axis] && high[axis] >= min[axis]);
    (placements.is_empty() || overlaps).then_some(Domain {
        min_um: DVec3::new(min[0], min[1], bottom - room),
        max_um: DVec3::new(max[0], max[1], top + room),
        sides,
        patches: [1, 1],
        floor,
    })
}
