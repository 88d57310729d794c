//! Wavefront .obj files through tobj: the one reader of them.

mod plain;
pub(crate) mod polygon;

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};

use super::{IngestError, Materials};
use crate::geometry::mesh::Curvature;
use crate::geometry::{Mesh, cross};
use crate::support::file_error::FileError;
use crate::support::text;
use plain::{Part, Plain};

/// What else than a .obj file a text without faces is.
fn other_format(text: &str) -> Option<&'static str> {
    let first = text.split_whitespace().next().unwrap_or_default();
    match &*first.to_ascii_lowercase() {
        "ply" => Some("a PLY file"),
        "solid" => Some("an STL file"),
        "off" => Some("an OFF file"),
        _ if text.chars().take(1024).any(|c| c < '\t') => Some("a file of bytes"),
        _ => None,
    }
}

/// A .obj file as tobj gives it: a model for each part.
pub(crate) struct ObjFile {
    path: PathBuf,
    models: Vec<(Part, tobj::Mesh)>,
}

impl ObjFile {
    /// Reads a file.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &fs::read(path).map_err(FileError::read(path))?)
    }

    /// Reads the faces of a file as one model, whatever its objects and materials.
    pub(crate) fn read_whole(path: &Path) -> Result<Self, FileError> {
        let bytes = fs::read(path).map_err(FileError::read(path))?;
        Self::of(path, &Plain::new(path, &text::decode(&bytes), true)?)
    }

    /// Reads the bytes of a file. Lines and points have no surface and are left out.
    ///
    /// # Errors
    /// A vertex without three finite numbers, a face with a corner that is not in the file, or a
    /// surface that is not made of polygons.
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let text = text::decode(bytes);
        let file = Self::of(path, &Plain::new(path, &text, false)?)?;
        match other_format(&text) {
            Some(other) if file.models.is_empty() => {
                Err(FileError::wrong(path, format!("it is {other}, not the text of a .obj file")))
            }
            _ => Ok(file),
        }
    }

    fn of(path: &Path, plain: &Plain) -> Result<Self, FileError> {
        let fault = |problem: String| {
            fault(path, &plain.text).unwrap_or_else(|| FileError::wrong(path, problem))
        };
        let mut reader = BufReader::new(Cursor::new(&plain.text));
        let no_library = |_: &Path| Ok(Default::default());
        let (models, _) =
            tobj::load_obj_buf(&mut reader, &tobj::LoadOptions::default(), no_library)
                .map_err(|error| fault(error.to_string()))?;
        if models.iter().flat_map(|model| &model.mesh.positions).any(|x| !x.is_finite()) {
            return Err(fault("a vertex is not finite".into()));
        }
        let part = |name: &str| name.parse().ok().and_then(|number: usize| plain.parts.get(number));
        let named =
            |model: tobj::Model| (part(&model.name).cloned().unwrap_or_default(), model.mesh);
        Ok(Self { path: path.to_owned(), models: models.into_iter().map(named).collect() })
    }

    /// Names of all objects.
    pub(crate) fn objects(&self) -> BTreeSet<&str> {
        named(self.models.iter().map(|(part, _)| part.object.most_likely()))
    }

    /// Names of the materials.
    pub(crate) fn materials(&self) -> BTreeSet<&str> {
        named(self.models.iter().map(|(part, _)| part.material.most_likely()))
    }

    /// Whether some faces name no material.
    pub(crate) fn lacks_material(&self) -> bool {
        self.models.iter().any(|(part, _)| part.material.most_likely().is_empty())
    }

    /// The vertices of an object, or of the whole file, and the corners of each face among them.
    pub(crate) fn polygons(&self, object: Option<&str>) -> (Vec<DVec3>, Vec<Vec<usize>>) {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for (_, mesh) in self.models(object) {
            let first = vertices.len();
            vertices.extend(points(mesh));
            let corners = |of: &[u32]| of.iter().map(|&i| i as usize + first).collect();
            faces.extend(polygons(&mesh.indices, mesh).map(corners));
        }
        (vertices, faces)
    }

    fn models(&self, object: Option<&str>) -> impl Iterator<Item = &(Part, tobj::Mesh)> {
        let is_wanted = |part: &Part, object: &str| {
            part.object.known(|name| (name == object).then_some(())).is_some()
        };
        self.models
            .iter()
            .filter(move |(part, _)| object.is_none_or(|object| is_wanted(part, object)))
    }

    /// An object, or the whole file, as one mesh, and the position of its middle, um.
    pub(super) fn mesh(
        &self,
        name: &str,
        object: Option<&str>,
        unit_um: f64,
        turn: DMat3,
        materials: &Materials,
    ) -> Result<super::Part, IngestError> {
        if let Some(object) = object
            && self.models(Some(object)).next().is_none()
        {
            return Err(IngestError::NoObject {
                path: self.path.clone(),
                object: object.to_owned(),
                present: self.objects().into_iter().map(str::to_owned).collect(),
            });
        }
        let wrong = |object: &str, problem: String| match object {
            "" => FileError::wrong(&self.path, problem),
            object => FileError::wrong_at(&self.path, format!("object {object:?}"), problem),
        };
        let (mut all, mut faces) = (Vec::new(), Vec::new());
        let mut curvature = Curvature::default();
        for (part, mesh) in self.models(object).filter(|(_, mesh)| !mesh.indices.is_empty()) {
            let own_name = part.object.most_likely();
            let known = part.material.known(|name| materials.known(Some(name)));
            let material = if let Some(material) = known {
                material
            } else {
                let named = Some(part.material.most_likely()).filter(|name| !name.is_empty());
                materials.index(if own_name.is_empty() { name } else { own_name }, named)?
            };
            let first = all.len() as u32;
            all.extend(points(mesh).map(|point| turn * point * unit_um));
            let mut normals = polygons(&mesh.normal_indices, mesh);
            for polygon in polygons(&mesh.indices, mesh) {
                let corners: Vec<u32> = polygon.iter().map(|i| i + first).collect();
                let triangles = polygon::triangles(&corners, &all).ok_or_else(|| {
                    let first = all[corners[0] as usize] / unit_um;
                    let problem = format!(
                        "a face of {} corners, the first of them {first}, crosses itself",
                        corners.len()
                    );
                    wrong(own_name, problem)
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
            return Err(wrong(object.unwrap_or_default(), "there are no faces".into()).into());
        }
        Ok((mesh, vec![DAffine3::from_translation(middle)]))
    }
}

fn named<'a>(names: impl Iterator<Item = &'a str>) -> BTreeSet<&'a str> {
    names.filter(|name| !name.is_empty()).collect()
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

/// The first line of plain text that tobj cannot read: its own errors name no line.
fn fault(path: &Path, text: &str) -> Option<FileError> {
    let vertices = text.lines().filter(|line| line.starts_with("v ")).count();
    let mut so_far = 0;
    for (number, line) in (1..).zip(text.lines().skip(Plain::ADDED_LINES)) {
        let mut words = line.split_whitespace();
        let problem = match words.next() {
            Some("v") => {
                so_far += 1;
                let values: Vec<_> = words.map(str::parse::<f64>).collect();
                let good = values.iter().all(|v| v.as_ref().is_ok_and(|v| v.is_finite()));
                let said = if line.contains(',') { ": it has commas for points" } else { "" };
                let problem = format!("a vertex is not three finite numbers{said}");
                (values.len() < 3 || !good).then_some(problem)
            }
            Some("f") => words.find_map(|word| {
                let index = word.split('/').next().unwrap_or("");
                match index.parse::<i64>() {
                    Err(_) => Some(format!("{word:?} is not a vertex of a face")),
                    Ok(i) if (1..=vertices as i64).contains(&i) || (i < 0 && -i <= so_far) => None,
                    Ok(i) => Some(format!("a face names vertex {i}, but the file has {vertices}")),
                }
            }),
            _ => None,
        };
        if let Some(problem) = problem {
            return Some(FileError::wrong_in_line(path, number, problem));
        }
    }
    None
}
