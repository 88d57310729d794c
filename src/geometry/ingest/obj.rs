//! Wavefront .obj files through tobj: the one reader of them.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufReader, Read as _};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};

use super::{IngestError, Materials, Part};
use crate::geometry::mesh::Curvature;
use crate::geometry::{Mesh, cross};
use crate::support::file_error::FileError;

/// The material library that stands for the names in the file itself.
const NAMES: &str = "names-of-this-file";

/// A .obj file as tobj gives it: a model for each object and material.
pub(crate) struct ObjFile {
    path: PathBuf,
    models: Vec<tobj::Model>,
    materials: Vec<String>,
}

impl ObjFile {
    /// Reads a file.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &fs::read(path).map_err(FileError::read(path))?)
    }

    /// Reads the vertices and faces of a file as one model, whatever its objects and materials.
    pub(crate) fn read_whole(path: &Path) -> Result<Self, FileError> {
        let bytes = fs::read(path).map_err(FileError::read(path))?;
        let is_kept = |line: &&str| line.trim_start().starts_with(['v', 'f']);
        let text = String::from_utf8_lossy(&bytes);
        let text: String = text.lines().filter(is_kept).flat_map(|line| [line, "\n"]).collect();
        Self::parse(path, text.as_bytes())
    }

    /// Reads the bytes of a file. Lines and points have no surface and are left out.
    ///
    /// # Errors
    /// A vertex without three finite numbers, or a face with a corner that is not in the file.
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let text = String::from_utf8_lossy(bytes);
        // A group within an object is a part of it, and tobj would end the object there.
        let has_objects = text.lines().any(|line| line.trim_start().starts_with("o "));
        let is_group = |line: &str| line.split_whitespace().next() == Some("g");
        let kept = |line: &str| !(has_objects && is_group(line));
        // tobj knows a name after a single space only, in a line that is not indented.
        let text: String = text
            .lines()
            .flat_map(|line| [if kept(line) { line.trim_start() } else { "" }, "\n"])
            .collect::<String>()
            .replace('\t', " ");
        // tobj keeps the names of materials only where it finds them in a .mtl file: it is told of
        // them, so that no .mtl file need be there.
        let named = text.lines().filter_map(|line| line.strip_prefix("usemtl "));
        let materials: BTreeSet<String> = named.map(|name| name.trim().to_owned()).collect();
        let materials: Vec<String> = materials.into_iter().collect();
        let known = |library: &Path| {
            if library != Path::new(NAMES) {
                return Ok(Default::default());
            }
            let named = |name: &String| tobj::Material { name: name.clone(), ..Default::default() };
            let places = materials.iter().enumerate().map(|(i, name)| (name.clone(), i));
            Ok((materials.iter().map(named).collect(), places.collect()))
        };
        let options = tobj::LoadOptions {
            ignore_points: true,
            ignore_lines: true,
            ..tobj::LoadOptions::default()
        };
        let first_line = format!("mtllib {NAMES}\n");
        let mut reader = BufReader::new(first_line.as_bytes().chain(text.as_bytes()));
        let fault =
            |problem: String| fault(path, &text).unwrap_or_else(|| FileError::wrong(path, problem));
        let (models, _) = tobj::load_obj_buf(&mut reader, &options, known)
            .map_err(|error| fault(error.to_string()))?;
        if models.iter().flat_map(|model| &model.mesh.positions).any(|x| !x.is_finite()) {
            return Err(fault("a vertex is not finite".into()));
        }
        Ok(Self { path: path.to_owned(), models, materials })
    }

    /// Names of all objects.
    pub(crate) fn objects(&self) -> BTreeSet<&str> {
        self.models.iter().map(|model| &*model.name).collect()
    }

    /// Names of the materials.
    pub(crate) fn materials(&self) -> &[String] {
        &self.materials
    }

    /// The vertices of an object, or of the whole file, and the corners of each face among them.
    pub(crate) fn polygons(&self, object: Option<&str>) -> (Vec<DVec3>, Vec<Vec<usize>>) {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for model in self.models(object) {
            let first = vertices.len();
            vertices.extend(points(&model.mesh));
            let corners = |of: &[u32]| of.iter().map(|&i| i as usize + first).collect();
            faces.extend(polygons(&model.mesh.indices, &model.mesh).map(corners));
        }
        (vertices, faces)
    }

    fn models(&self, object: Option<&str>) -> impl Iterator<Item = &tobj::Model> {
        self.models.iter().filter(move |model| object.is_none_or(|object| model.name == object))
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
        if let Some(object) = object
            && self.models(Some(object)).next().is_none()
        {
            return Err(IngestError::NoObject {
                path: self.path.clone(),
                object: object.to_owned(),
                present: self.objects().into_iter().map(str::to_owned).collect(),
            });
        }
        let wrong = |object: Option<&str>, problem: String| match object {
            Some(object) => FileError::wrong_at(&self.path, format!("object {object:?}"), problem),
            None => FileError::wrong(&self.path, problem),
        };
        let (mut all, mut faces) = (Vec::new(), Vec::new());
        let mut curvature = Curvature::default();
        for model in self.models(object).filter(|model| !model.mesh.indices.is_empty()) {
            let mesh = &model.mesh;
            let named = mesh.material_id.map(|id| &*self.materials[id]);
            let material = materials.index(&model.name, named)?;
            let first = all.len() as u32;
            all.extend(points(mesh).map(|point| turn * point * unit_um));
            let mut normals = polygons(&mesh.normal_indices, mesh);
            for polygon in polygons(&mesh.indices, mesh) {
                let corners: Vec<u32> = polygon.iter().map(|i| i + first).collect();
                let triangles = fan(&corners, &all).ok_or_else(|| {
                    let problem = format!(
                        "a face of {} corners, the first of them {}, is not convex",
                        corners.len(),
                        all[corners[0] as usize] / unit_um
                    );
                    wrong(Some(&model.name), problem)
                })?;
                if let Some(corners) = normals.next() {
                    let normal =
                        |&i: &u32| turn * DVec3::from_slice(&mesh.normals[3 * i as usize..]);
                    let facet = triangles.iter().map(|&triangle| area(triangle, &all)).sum();
                    curvature.add(facet, corners.iter().map(normal));
                }
                faces.extend(triangles.into_iter().map(|triangle| (triangle, material)));
            }
        }
        let (mut mesh, middle) = Mesh::new(name, &all, faces.into_iter());
        mesh.quality.curved = curvature.mean();
        if mesh.triangles.is_empty() {
            return Err(wrong(object, "there are no faces".into()).into());
        }
        Ok((mesh, vec![DAffine3::from_translation(middle)]))
    }
}

fn points(mesh: &tobj::Mesh) -> impl Iterator<Item = DVec3> {
    mesh.positions.chunks_exact(3).map(DVec3::from_slice)
}

/// The corners of each face as they stand in a list of indices of the mesh; none if it is empty.
fn polygons<'a>(indices: &'a [u32], mesh: &'a tobj::Mesh) -> impl Iterator<Item = &'a [u32]> {
    let mut rest = indices;
    let faces = if indices.is_empty() { 0 } else { usize::MAX };
    // No arities at all stand for triangles throughout.
    let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
    let arities = mesh.face_arities.iter().copied().chain(std::iter::repeat_n(3, triangles));
    arities.take(faces).map(move |arity| {
        let (polygon, others) = rest.split_at(arity as usize);
        rest = others;
        polygon
    })
}

/// A triangle's normal, as long as twice its area.
fn area(triangle: [u32; 3], points: &[DVec3]) -> DVec3 {
    cross(triangle.map(|i| points[i as usize]))
}

/// A convex face as triangles about its first corner. `None` if it is concave: such triangles would
/// cover other ground than the face.
fn fan(corners: &[u32], points: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    let triangles: Vec<[u32; 3]> =
        corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]).collect();
    let area = |triangle| area(triangle, points);
    let whole: DVec3 = triangles.iter().map(|&triangle| area(triangle)).sum();
    let same_way = |&triangle: &[u32; 3]| area(triangle).dot(whole) >= 0.0;
    // Every corner must turn the same way, not only those of the fan.
    let turns = (0..corners.len()).all(|i| {
        let at = |k: usize| corners[(i + k) % corners.len()];
        area([at(0), at(1), at(2)]).dot(whole) >= -1e-9 * whole.length_squared()
    });
    let flat = corners.len() > 3 && whole == DVec3::ZERO;
    (triangles.iter().all(same_way) && turns && !flat).then_some(triangles)
}

/// The first line that tobj cannot read: its own errors name no line.
fn fault(path: &Path, text: &str) -> Option<FileError> {
    let vertices = text.lines().filter(|line| line.starts_with("v ")).count();
    let mut so_far = 0;
    for (number, line) in (1..).zip(text.lines()) {
        let mut words = line.split_whitespace();
        let problem = match words.next() {
            Some("v") => {
                so_far += 1;
                let values: Vec<_> = words.map(str::parse::<f64>).collect();
                let good = values.iter().all(|v| v.as_ref().is_ok_and(|v| v.is_finite()));
                (values.len() < 3 || !good).then(|| "a vertex is not three finite numbers".into())
            }
            Some("f") => words.find_map(|word| {
                let index = word.split('/').next().unwrap_or("");
                match index.parse::<i64>() {
                    Err(_) => Some(format!("{word:?} is not a vertex of a face")),
                    Ok(i) if (1..=vertices as i64).contains(&i) || (i < 0 && -i <= so_far) => None,
                    Ok(i) => Some(format!("a face names vertex {i}, but the file has {vertices}")),
                }
            }),
            Some("usemtl") if words.next().is_none() => Some("the material has no name".into()),
            _ => None,
        };
        if let Some(problem) = problem {
            return Some(FileError::wrong_in_line(path, number, problem));
        }
    }
    None
}
