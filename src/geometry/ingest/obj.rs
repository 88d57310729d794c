//! Wavefront .obj through tobj.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufReader, Read};
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::{IngestError, Materials, Part};
use crate::geometry::{Mesh, turned_away};

/// The material library that stands for the names in the file itself.
const NAMES: &str = "names-of-this-file";

/// A .obj file as tobj gives it: one model for each object and material.
pub(super) struct ObjFile {
    models: Vec<tobj::Model>,
    materials: Vec<String>,
}

impl ObjFile {
    pub(super) fn read(path: &Path) -> Result<Self, IngestError> {
        let text =
            fs::read(path).map_err(|source| IngestError::Read { path: path.to_owned(), source })?;
        let text = String::from_utf8_lossy(&text);
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
        let broken =
            |(place, problem)| IngestError::Broken { path: path.to_owned(), place, problem };
        // Only the names of the materials matter here, and tobj keeps them only where it finds
        // them in a .mtl file: it is told of them, so that no .mtl need be there.
        let materials: Vec<String> = text
            .lines()
            .filter_map(|line| line.strip_prefix("usemtl "))
            .map(|name| name.trim().to_owned())
            .collect::<BTreeSet<_>>()
            .into_iter()
            .collect();
        let known = |library: &Path| {
            if library != Path::new(NAMES) {
                return Ok(Default::default());
            }
            let named = |name: &String| tobj::Material { name: name.clone(), ..Default::default() };
            let places = materials.iter().enumerate().map(|(i, name)| (name.clone(), i));
            Ok((materials.iter().map(named).collect(), places.collect()))
        };
        let options = tobj::LoadOptions {
            triangulate: false,
            ignore_points: true,
            ignore_lines: true,
            ..Default::default()
        };
        let first_line = format!("mtllib {NAMES}\n");
        let mut reader = BufReader::new(first_line.as_bytes().chain(text.as_bytes()));
        let (models, _) = tobj::load_obj_buf(&mut reader, &options, known).map_err(|error| {
            broken(fault(&text).unwrap_or_else(|| ("the file".into(), error.to_string())))
        })?;
        if models.iter().any(|m| m.mesh.positions.iter().any(|x| !x.is_finite())) {
            return Err(broken(
                fault(&text)
                    .unwrap_or_else(|| ("the file".into(), "a vertex is not finite".into())),
            ));
        }
        Ok(Self { models, materials })
    }

    /// The named object, or all of the file, as one mesh.
    pub(super) fn mesh(
        &self,
        path: &Path,
        name: &str,
        object: Option<&str>,
        unit_um: f64,
        turn: DMat3,
        materials: &Materials,
    ) -> Result<Part, IngestError> {
        let models: Vec<_> =
            self.models.iter().filter(|m| object.is_none_or(|object| m.name == object)).collect();
        if let (Some(object), true) = (object, models.is_empty()) {
            let present: BTreeSet<String> = self.models.iter().map(|m| m.name.clone()).collect();
            return Err(IngestError::NoObject {
                path: path.to_owned(),
                object: object.to_owned(),
                present: present.into_iter().collect(),
            });
        }
        let (mut points, mut faces) = (Vec::new(), Vec::new());
        let mut away = (0.0, 0.0);
        for model in models {
            let mesh = &model.mesh;
            if mesh.indices.is_empty() {
                continue;
            }
            let named = mesh.material_id.map(|id| self.materials[id].as_str());
            let material = materials.index(path, &model.name, named)?;
            let first = points.len() as u32;
            points.extend(
                mesh.positions
                    .chunks_exact(3)
                    .map(|p| turn * DVec3::new(p[0], p[1], p[2]) * unit_um),
            );
            let mut normals = polygons(&mesh.normal_indices, mesh);
            for polygon in polygons(&mesh.indices, mesh) {
                let corners: Vec<u32> = polygon.iter().map(|i| i + first).collect();
                let triangles = fan(&corners, &points).ok_or_else(|| IngestError::Broken {
                    path: path.to_owned(),
                    place: format!("object {:?}", model.name),
                    problem: format!(
                        "a face of {} corners, the first of them {}, is not convex",
                        corners.len(),
                        points[corners[0] as usize] / unit_um
                    ),
                })?;
                if let Some(corners) = normals.next() {
                    let normal = |&i: &u32| {
                        let i = 3 * i as usize;
                        turn * DVec3::from_slice(&mesh.normals[i..i + 3])
                    };
                    let facet = triangles.iter().map(|&triangle| area(triangle, &points)).sum();
                    let corners: Vec<DVec3> = corners.iter().map(normal).collect();
                    let (off, weight) = turned_away(facet, &corners);
                    away = (away.0 + off, away.1 + weight);
                }
                faces.extend(triangles.into_iter().map(|triangle| (triangle, material)));
            }
        }
        let (mut mesh, middle) = Mesh::new(name, &points, faces.into_iter());
        mesh.doubts.curved = if away.1 > 0.0 { away.0 / away.1 } else { 0.0 };
        if mesh.triangles.is_empty() {
            return Err(IngestError::Broken {
                path: path.to_owned(),
                place: object.map_or_else(|| "the file".into(), |o| format!("object {o:?}")),
                problem: "there are no faces".into(),
            });
        }
        Ok((mesh, DAffine3::from_translation(middle)))
    }
}

/// The corners of each face as they stand in one of the mesh's lists of indices; none if it is empty.
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
    let [a, b, c] = triangle.map(|i| points[i as usize]);
    (b - a).cross(c - a)
}

/// A convex face as triangles about its first corner; `None` if it is concave, where such triangles would
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

/// The first line that tobj could have stumbled over: its own errors name no line.
fn fault(text: &str) -> Option<(String, String)> {
    let vertices = text.lines().filter(|line| line.trim_start().starts_with("v ")).count();
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
                    Ok(i) => Some(format!("a face wants vertex {i}, and there are {vertices}")),
                }
            }),
            Some("usemtl") if words.next().is_none() => Some("the material has no name".into()),
            _ => None,
        };
        if let Some(problem) = problem {
            return Some((format!("line {number}"), problem));
        }
    }
    None
}
