//! From a scene's files to a [`Bed`].

mod error;
#[cfg(feature = "gltf")]
mod gltf;
pub(crate) mod obj;

use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use sha2::{Digest, Sha256};

use crate::geometry::{self, Bed, Domain, MOST_PLACEMENTS, MOST_TRIANGLES, Mesh, Placement};
use crate::scene::{FARTHEST_UM, Placed, Prototype, Scene, Sides, UpAxis};
use crate::support::file_error::FileError;
use crate::support::output::{self, OutputError};
use crate::support::resources;
use obj::ObjFile;

pub use error::IngestError;

/// Memory that tracing takes for each placement and for each triangle of a mesh, measured.
const PLACEMENT_BYTES: usize = 600;
const TRIANGLE_BYTES: usize = 250;

/// A mesh of a file, and where the file places it.
type Part = (Mesh, Vec<DAffine3>);

/// A placed scene and the bytes of its mesh files, read once: the same bytes are hashed and parsed.
#[derive(Debug, Clone)]
pub struct Sources {
    scene: Scene,
    files: BTreeMap<PathBuf, Vec<u8>>,
}

impl Sources {
    /// Reads all mesh files of a placed scene, and the buffers that glTF files refer to.
    ///
    /// # Errors
    /// The scene is a recipe, or a file cannot be read or has another format.
    pub fn read(scene: &Scene) -> Result<Self, IngestError> {
        let mut files = BTreeMap::new();
        for prototype in &scene.placed()?.prototypes {
            let path = scene.path_of(&prototype.file);
            if files.contains_key(&path) {
                continue;
            }
            // Its format is known before the file is read.
            let is_gltf = Format::of(&path)? == Format::Gltf;
            debug_assert!(!is_gltf || cfg!(feature = "gltf"));
            let read = |path: &Path| fs::read(path).map_err(FileError::read(path));
            let bytes = read(&path)?;
            #[cfg(feature = "gltf")]
            if is_gltf {
                for buffer in gltf::buffer_files(&path, &bytes)? {
                    // A device may never end.
                    if buffer.exists() && !buffer.is_file() {
                        return Err(
                            FileError::wrong(&buffer, "a buffer must be a plain file").into()
                        );
                    }
                    let bytes = read(&buffer)?;
                    files.insert(buffer, bytes);
                }
            }
            files.insert(path, bytes);
        }
        Ok(Self { scene: scene.clone(), files })
    }

    /// The files and their bytes.
    pub fn files(&self) -> &BTreeMap<PathBuf, Vec<u8>> {
        &self.files
    }

    /// SHA-256 of the scene file, of changes of its values and of its meshes, in hexadecimal. A
    /// table belongs to it.
    pub fn sha256(&self) -> Result<String, OutputError> {
        let mut sum = Sha256::new();
        sum.update(output::sha256(&self.scene.file)?);
        for change in &self.scene.changes {
            sum.update(Sha256::digest(change.to_string()));
        }
        for bytes in self.files.values() {
            sum.update(Sha256::digest(bytes));
        }
        Ok(output::hex(&sum.finalize()))
    }

    /// Parses the meshes and places them.
    ///
    /// # Errors
    /// A mesh is broken or has an unknown material, or the bed does not fit its domain.
    pub fn bed(&self) -> Result<Bed, IngestError> {
        let scene = &self.scene;
        let placed = scene.placed()?;
        let path = &scene.file;
        let mut obj_files = BTreeMap::new();
        let mut meshes = Vec::new();
        let mut parts: BTreeMap<&str, Vec<Placement>> = BTreeMap::new();
        for prototype in &placed.prototypes {
            let placements = parts.entry(&prototype.name).or_default();
            for (mesh, places) in self.prototype(prototype, &mut obj_files)? {
                let mesh_number = meshes.len();
                let placement = |to_scene| Placement { mesh: mesh_number, to_scene };
                placements.extend(places.into_iter().map(placement));
                meshes.push(mesh);
            }
        }
        let mut placements = Vec::with_capacity(self.room(placed, &meshes, &parts)?);
        match &placed.instances {
            None => placements.extend(parts.into_values().flatten()),
            Some(instances) => {
                for instance in instances {
                    let place = affine(&instance.transform);
                    let placed = |part: &Placement| Placement {
                        mesh: part.mesh,
                        to_scene: place * part.to_scene,
                    };
                    placements.extend(parts[instance.prototype.as_str()].iter().map(placed));
                }
            }
        }
        let all = placements.len();
        leave_out_repeated(&mut placements);
        let repeated = all - placements.len();
        let not_far = |farthest_um: f64| {
            if farthest_um < FARTHEST_UM {
                return Ok(());
            }
            Err(IngestError::Far { path: path.clone(), farthest_um })
        };
        let (low, high) = Bed::bounds_um(&meshes, &placements);
        if !placements.is_empty() {
            not_far(low.abs().max(high.abs()).max_element())?;
        }
        let domain = domain(scene, placed, (low, high), placements.is_empty())
            .ok_or_else(|| IngestError::Empty { path: path.clone() })?;
        let floor_um = domain.floor.map_or(0.0, |(z_um, _)| z_um.abs());
        not_far(domain.min_um.abs().max(domain.max_um.abs()).max_element().max(floor_um))?;
        let mut bed = Bed {
            meshes,
            placements,
            repeated,
            domain,
            to_sensor: geometry::to_sensor(scene.view),
            materials: scene.materials.len(),
        };
        if let Sides::Field { particles, .. } = bed.domain.sides {
            let patches = geometry::patches(&bed, particles);
            bed.domain.patches =
                patches.ok_or_else(|| IngestError::Field { path: path.clone(), particles })?;
        }
        Ok(bed)
    }

    /// The number of placements, if they can be traced and there is memory for that.
    fn room(
        &self,
        placed: &Placed,
        meshes: &[Mesh],
        parts: &BTreeMap<&str, Vec<Placement>>,
    ) -> Result<usize, IngestError> {
        let path = || self.scene.file.clone();
        let of = |name: &str| parts[name].len();
        let placements: usize = match &placed.instances {
            None => parts.values().map(Vec::len).sum(),
            Some(instances) => instances.iter().map(|instance| of(&instance.prototype)).sum(),
        };
        let most = meshes.iter().map(|mesh| mesh.triangles.len()).max().unwrap_or(0);
        if placements > MOST_PLACEMENTS || most > MOST_TRIANGLES {
            return Err(IngestError::Many { path: path(), placements, triangles: most });
        }
        let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        let needed = (placements * PLACEMENT_BYTES + triangles * TRIANGLE_BYTES) as u64;
        let task = format!("tracing {placements} placed meshes");
        resources::need_memory(&task, needed)
            .map_err(|source| IngestError::Memory { path: path(), source })?;
        Ok(placements)
    }

    /// The meshes of one prototype.
    fn prototype(
        &self,
        prototype: &Prototype,
        obj_files: &mut BTreeMap<PathBuf, ObjFile>,
    ) -> Result<Vec<Part>, IngestError> {
        let path = self.scene.path_of(&prototype.file);
        let bytes = &self.files[&path];
        let materials =
            Materials { scene: &self.scene, instead: prototype.material.as_deref(), path: &path };
        let is_gltf = Format::of(&path)? == Format::Gltf;
        let unit_um = prototype.unit_um.unwrap_or(if is_gltf { 1e6 } else { 1.0 });
        let up = prototype.up.unwrap_or(if is_gltf { UpAxis::Y } else { UpAxis::Z });
        let turn = match up {
            UpAxis::Z => DMat3::IDENTITY,
            UpAxis::Y => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
        };
        let object = prototype.object.as_deref();
        #[cfg(feature = "gltf")]
        if is_gltf {
            return gltf::read(bytes, &self.files, object, unit_um, turn, &materials);
        }
        if !obj_files.contains_key(&path) {
            obj_files.insert(path.clone(), ObjFile::parse(&path, bytes)?);
        }
        Ok(vec![obj_files[&path].mesh(&prototype.name, object, unit_um, turn, &materials)?])
    }
}

/// Reads all meshes of a placed scene.
pub fn load(scene: &Scene) -> Result<Bed, IngestError> {
    Sources::read(scene)?.bed()
}

/// Keeps the first of those that stand in the same place: rays meet the others nowhere, but would be
/// compared with each of them.
fn leave_out_repeated(placements: &mut Vec<Placement>) {
    let mut seen = HashSet::with_capacity(placements.len());
    placements.retain(|Placement { mesh, to_scene }| {
        seen.insert((*mesh, to_scene.to_cols_array().map(f64::to_bits)))
    });
}

/// The scene's materials by name, or the one that stands for all, for the faces of a file.
struct Materials<'a> {
    scene: &'a Scene,
    instead: Option<&'a str>,
    path: &'a Path,
}

impl Materials<'_> {
    /// The index of a material, if the scene has it.
    fn known(&self, name: Option<&str>) -> Option<u16> {
        let index = self.instead.or(name).and_then(|name| self.scene.material_index(name));
        index.map(|index| index as u16)
    }

    fn index(&self, object: &str, name: Option<&str>) -> Result<u16, IngestError> {
        self.known(name).ok_or_else(|| IngestError::NoMaterial {
            path: self.path.to_owned(),
            object: object.to_owned(),
            material: self.instead.or(name).map(str::to_owned),
            known: self.scene.materials.iter().map(|m| m.name.clone()).collect(),
        })
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
            "gltf" | "glb" if cfg!(feature = "gltf") => Ok(Self::Gltf),
            _ => Err(IngestError::Format { path: file.to_owned() }),
        }
    }
}

/// A transform of a scene file.
pub(crate) fn affine(m: &[f64; 12]) -> DAffine3 {
    DAffine3::from_cols(
        DVec3::new(m[0], m[4], m[8]),
        DVec3::new(m[1], m[5], m[9]),
        DVec3::new(m[2], m[6], m[10]),
        DVec3::new(m[3], m[7], m[11]),
    )
}

/// The domain of a bed with these bounds; `None` if nothing stands in it.
fn domain(
    scene: &Scene,
    placed: &Placed,
    (low, high): (DVec3, DVec3),
    is_empty: bool,
) -> Option<Domain> {
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
    let min_um = DVec3::new(min[0], min[1], bottom - room);
    let max_um = DVec3::new(max[0], max[1], top + room);
    (is_empty || overlaps).then(|| Domain { floor, ..Domain::new(min_um, max_um, sides) })
}
