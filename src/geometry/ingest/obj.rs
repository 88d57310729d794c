//! Wavefront .obj files: the one reader of them.

use std::collections::BTreeSet;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use rustc_hash::FxHashMap;

use super::{IngestError, Materials, Part};
use crate::geometry::mesh::Curvature;
use crate::geometry::{Mesh, cross};
use crate::support::file_error::FileError;

/// The vertices, normals and faces of a .obj file.
pub(crate) struct ObjFile {
    path: PathBuf,
    vertices: Vec<DVec3>,
    normals: Vec<DVec3>,
    corners: Vec<Corner>,
    faces: Vec<Face>,
    objects: Vec<Object>,
    materials: Vec<String>,
}

struct Corner {
    vertex: u32,
    normal: Option<u32>,
}

struct Face {
    corners: Range<usize>,
    material: Option<usize>,
}

/// An object and its faces. In a file without objects the groups are its objects.
struct Object {
    name: String,
    faces: Range<usize>,
}

/// The name of faces before the first object.
const UNNAMED: &str = "unnamed_object";

impl ObjFile {
    /// Reads a file.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &fs::read(path).map_err(FileError::read(path))?)
    }

    /// Reads the bytes of a file. Lines and points have no surface and are left out.
    ///
    /// # Errors
    /// A vertex without three finite numbers, or a face with a corner that is not in the file.
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let text = String::from_utf8_lossy(bytes);
        let is_object = |line: &str| line.split_ascii_whitespace().next() == Some("o");
        let has_objects = text.lines().any(is_object);
        let mut file = Self {
            path: path.to_owned(),
            vertices: Vec::new(),
            normals: Vec::new(),
            corners: Vec::new(),
            faces: Vec::new(),
            objects: vec![Object { name: UNNAMED.to_owned(), faces: 0..0 }],
            materials: Vec::new(),
        };
        let mut material = None;
        // Of vertices and normals the greatest number in a face, and its line.
        let mut greatest = [(0, 0); 2];
        for (number, line) in (1..).zip(text.lines()) {
            let wrong = |problem: &str| FileError::wrong_in_line(path, number, problem);
            let mut words = line.split_ascii_whitespace();
            let key = words.next().unwrap_or_default();
            let name = || line.trim()[key.len()..].trim().to_owned();
            match key {
                "v" => {
                    let vertex = vector(words).filter(|v| v.is_finite());
                    let problem = "a vertex is not three finite numbers";
                    file.vertices.push(vertex.ok_or_else(|| wrong(problem))?);
                }
                "vn" => {
                    let problem = "a normal is not three numbers";
                    file.normals.push(vector(words).ok_or_else(|| wrong(problem))?);
                }
                "f" => {
                    let first = file.corners.len();
                    let there = [file.vertices.len(), file.normals.len()];
                    for word in words {
                        let (vertex, normal) = corner(word, there).map_err(|e| wrong(&e))?;
                        for (greatest, index) in greatest.iter_mut().zip([Some(vertex), normal]) {
                            *greatest = (*greatest).max((index.map_or(0, |i| i + 1), number));
                        }
                        file.corners.push(Corner { vertex, normal });
                    }
                    if file.corners.len() - first >= 3 {
                        file.faces.push(Face { corners: first..file.corners.len(), material });
                        file.objects.last_mut().expect("one at least").faces.end += 1;
                    }
                }
                // A group within an object is a part of it.
                "o" | "g" if key == "o" || !has_objects => {
                    let name = Some(name()).filter(|name| !name.is_empty());
                    let faces = file.faces.len()..file.faces.len();
                    file.objects.push(Object { name: name.unwrap_or(UNNAMED.into()), faces });
                }
                "usemtl" => {
                    let name = name();
                    if name.is_empty() {
                        return Err(wrong("the material has no name"));
                    }
                    let known = file.materials.iter().position(|known| *known == name);
                    material = Some(known.unwrap_or_else(|| {
                        file.materials.push(name);
                        file.materials.len() - 1
                    }));
                }
                _ => {}
            }
        }
        let there = [("vertex", file.vertices.len()), ("normal", file.normals.len())];
        for ((number, line), (kind, there)) in greatest.into_iter().zip(there) {
            if number as usize > there {
                let problem = format!("a face names {kind} {number}, but the file has {there}");
                return Err(FileError::wrong_in_line(path, line, problem));
            }
        }
        Ok(file)
    }

    /// Names of all objects.
    pub(crate) fn objects(&self) -> BTreeSet<&str> {
        let with_faces = self.objects.iter().filter(|object| !object.faces.is_empty());
        with_faces.map(|object| &*object.name).collect()
    }

    /// Names of the materials that faces have, in the order of the file.
    pub(crate) fn materials(&self) -> &[String] {
        &self.materials
    }

    /// The vertices of an object, or of the whole file, and the corners of each face among them.
    pub(crate) fn polygons(&self, object: Option<&str>) -> (Vec<DVec3>, Vec<Vec<usize>>) {
        let mut used = Used::default();
        let corners = |(_, face): (&Object, &Face)| {
            used.renumber(self, face).into_iter().map(|i| i as usize).collect()
        };
        let faces = self.faces(object).map(corners).collect();
        (used.vertices, faces)
    }

    fn faces(&self, object: Option<&str>) -> impl Iterator<Item = (&Object, &Face)> {
        let objects = self.objects.iter().filter(move |o| object.is_none_or(|name| o.name == name));
        objects.flat_map(|object| self.faces[object.faces.clone()].iter().map(move |f| (object, f)))
    }

    /// An object, or the whole file, as one mesh.
    pub(super) fn mesh(
        &self,
        name: &str,
        object: Option<&str>,
        unit_um: f64,
        turn: DMat3,
        materials: &Materials,
    ) -> Result<Part, IngestError> {
        let path = &self.path;
        if let Some(object) = object
            && !self.objects.iter().any(|o| o.name == object)
        {
            return Err(IngestError::NoObject {
                path: path.clone(),
                object: object.to_owned(),
                present: self.objects().into_iter().map(str::to_owned).collect(),
            });
        }
        let (mut used, mut faces) = (Used::default(), Vec::new());
        let mut curvature = Curvature::default();
        let mut index = FxHashMap::default();
        for (of, face) in self.faces(object) {
            let material = if let Some(material) = index.get(&face.material) {
                *material
            } else {
                let named = face.material.map(|number| &*self.materials[number]);
                let material = materials.index(&of.name, named)?;
                *index.entry(face.material).or_insert(material)
            };
            let corners = used.renumber(self, face);
            let triangles = fan(&corners, &used.vertices).ok_or_else(|| {
                let first = used.vertices[corners[0] as usize];
                let problem = format!(
                    "a face of {} corners, the first of them {first}, is not convex",
                    corners.len()
                );
                FileError::wrong_at(path, format!("object {:?}", of.name), problem)
            })?;
            let given = &self.corners[face.corners.clone()];
            if given.iter().all(|corner| corner.normal.is_some()) {
                let normals = given.iter().filter_map(|corner| corner.normal);
                let normals: Vec<DVec3> = normals.map(|i| self.normals[i as usize]).collect();
                let facet = triangles.iter().map(|&t| normal(t, &used.vertices)).sum();
                curvature.add(facet, normals.into_iter());
            }
            faces.extend(triangles.into_iter().map(|triangle| (triangle, material)));
        }
        let points: Vec<DVec3> = used.vertices.iter().map(|&p| turn * p * unit_um).collect();
        let (mut mesh, middle) = Mesh::new(name, &points, faces.into_iter());
        mesh.quality.curved = curvature.mean();
        if mesh.triangles.is_empty() {
            let place = object.map(|object| format!("object {object:?}"));
            let problem = "there are no faces".into();
            return Err(FileError::Wrong { path: path.clone(), place, problem }.into());
        }
        Ok((mesh, vec![DAffine3::from_translation(middle)]))
    }
}

/// The vertices that faces use, in the order of their first use.
#[derive(Default)]
struct Used {
    vertices: Vec<DVec3>,
    numbers: FxHashMap<u32, u32>,
}

impl Used {
    /// The corners of a face as indices into these vertices.
    fn renumber(&mut self, file: &ObjFile, face: &Face) -> Vec<u32> {
        let Self { vertices, numbers } = self;
        let number = |corner: &Corner| {
            *numbers.entry(corner.vertex).or_insert_with(|| {
                vertices.push(file.vertices[corner.vertex as usize]);
                vertices.len() as u32 - 1
            })
        };
        file.corners[face.corners.clone()].iter().map(number).collect()
    }
}

/// The first three numbers of a line.
fn vector<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<DVec3> {
    let mut number = || words.next()?.parse().ok();
    Some(DVec3::new(number()?, number()?, number()?))
}

/// The indices, from 0, of a corner's vertex and normal. The file counts them from 1, or back from
/// the last one `there` is so far.
fn corner(word: &str, there: [usize; 2]) -> Result<(u32, Option<u32>), String> {
    let index = |text: &str, kind: &str, there: usize| {
        let number: i64 =
            text.parse().map_err(|_| format!("{word:?} is not a vertex of a face"))?;
        let index = if number < 0 { there as i64 + number } else { number - 1 };
        u32::try_from(index)
            .map_err(|_| format!("a face names {kind} {number}, but the file has {there}"))
    };
    let mut parts = word.split('/');
    let vertex = index(parts.next().unwrap_or_default(), "vertex", there[0])?;
    let normal = parts.nth(1).map(|text| index(text, "normal", there[1])).transpose()?;
    Ok((vertex, normal))
}

/// A triangle's normal, as long as twice its area.
fn normal(triangle: [u32; 3], points: &[DVec3]) -> DVec3 {
    cross(triangle.map(|i| points[i as usize]))
}

/// A convex face as triangles about its first corner. `None` if it is concave: such triangles would
/// cover other ground than the face.
fn fan(corners: &[u32], points: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    let triangles: Vec<[u32; 3]> =
        corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]).collect();
    let normal = |triangle| normal(triangle, points);
    let whole: DVec3 = triangles.iter().map(|&triangle| normal(triangle)).sum();
    let same_way = |&triangle: &[u32; 3]| normal(triangle).dot(whole) >= 0.0;
    // Every corner must turn the same way, not only those of the fan.
    let turns = (0..corners.len()).all(|i| {
        let at = |k: usize| corners[(i + k) % corners.len()];
        normal([at(0), at(1), at(2)]).dot(whole) >= -1e-9 * whole.length_squared()
    });
    let flat = corners.len() > 3 && whole == DVec3::ZERO;
    (triangles.iter().all(same_way) && turns && !flat).then_some(triangles)
}
