//! Scans of grains: meshes of .stl, .ply and .obj files, thinned to what a grain needs.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufReader, Cursor};
use std::path::Path;

use glam::DVec3;
use meshopt::SimplifyOptions;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use serde_json::json;

use super::own_grains::{FORMAT, Grain, OwnGrainsError};
use super::solid::Solid;
use crate::geometry::ingest::obj::{ObjFile, polygon};
use crate::scene::Shape;
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::{math, output, text};

/// What a scan is to become.
pub struct Wanted<'a> {
    /// Name of the grain.
    pub name: &'a str,
    /// The shape that it stands for.
    pub shape: Shape,
    /// Length of the scan's unit, um.
    pub unit_um: f64,
    /// How far the thinned surface may lie from the scan, as a share of the diameter.
    pub deviation: f64,
}

/// What became of a scan.
#[derive(Debug)]
pub struct Brought {
    /// Diameter of the sphere of its volume, um.
    pub diameter_um: f64,
    /// Triangles of the scan.
    pub scanned: usize,
    /// Triangles of the grain.
    pub kept: usize,
    /// Corners that were joined with another one within rounding, because that closed the mesh.
    pub joined: usize,
    /// How far the surface was moved, by the decimator's estimate, um.
    pub deviation_um: f64,
    /// Relative change of the volume by the thinning, before it was scaled back.
    pub volume_change: f64,
}

/// Thinning that makes a body cross itself is tried again with half the deviation, so often.
const HALVINGS: u32 = 4;

/// How far corners may lie apart that rounding has parted, as a share of the greatest length.
const ROUNDING: f64 = 1e-6;

/// Reads a scan and writes it as a grain into a folder of own grains: thinned, in micrometres, about
/// its centre of mass, with the volume of the scan.
///
/// # Errors
/// A file that cannot be read or written, or a mesh that is no sound body.
pub fn bring(scan: &Path, folder: &Path, wanted: &Wanted) -> Result<Brought, Error> {
    let mut solid = read(scan, wanted.unit_um).map_err(OwnGrainsError::Scan)?;
    let mut joined = 0;
    if let Some(fault) = solid.fault() {
        let (closed, count) = joined_within_rounding(&solid);
        if count == 0 || closed.fault().is_some() {
            return Err(OwnGrainsError::Scan(FileError::wrong(scan, fault)).into());
        }
        (solid, joined) = (closed, count);
    }
    let volume = solid.volume_um3();
    let diameter_um = math::cbrt(6.0 * volume / std::f64::consts::PI);
    let thin = |halving: u32| {
        let deviation_um = wanted.deviation * diameter_um / f64::from(1 << halving);
        Some(thinned(&solid, deviation_um)).filter(|(thin, _)| thin.fault().is_none())
    };
    let (mut thin, deviation_um) = (0..=HALVINGS).find_map(thin).ok_or_else(|| {
        let problem = "thinned it crosses itself: ask for a smaller --deviation";
        OwnGrainsError::Scan(FileError::wrong(scan, problem))
    })?;
    let volume_change = thin.volume_um3() / volume - 1.0;
    let scale = math::cbrt(volume / thin.volume_um3());
    let centre = thin.centroid();
    for vertex in &mut thin.vertices {
        *vertex = (*vertex - centre) * scale;
    }
    output::folder(folder)?;
    let file = |ending: &str| folder.join(format!("{}.{ending}", wanted.name));
    output::keeps([scan], &[file("obj")])?;
    output::bytes(&file("obj"), obj_text(&thin).as_bytes())?;
    let about = json!({
        "soilsig_grain": FORMAT,
        "shape": wanted.shape,
        "diameter_um": diameter_um,
        "made_from": {
            "scan": scan.file_name().unwrap_or_default().to_string_lossy(),
            "sha256": output::sha256_hex(scan)?,
            "unit_um": wanted.unit_um,
            "triangles": solid.faces.len(),
            "deviation_um": deviation_um,
            "corners_joined": joined,
        },
    });
    let text = serde_json::to_string_pretty(&about).expect("plain data") + "\n";
    output::bytes(&file("json"), text.as_bytes())?;
    let grain = Grain::read(folder, wanted.name).map_err(OwnGrainsError::from)?;
    Ok(Brought {
        diameter_um,
        scanned: solid.faces.len(),
        kept: grain.faces,
        joined,
        deviation_um,
        volume_change,
    })
}

/// The mesh of a file as triangles, um; corners in one place are one.
fn read(path: &Path, unit_um: f64) -> Result<Solid, FileError> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let bytes = || fs::read(path).map_err(FileError::read(path));
    let (vertices, faces) = match &*ending {
        "stl" => stl(path, &bytes()?)?,
        "ply" => ply(path, &bytes()?)?,
        "obj" => ObjFile::read_whole(path)?.polygons(None),
        _ => {
            let problem = format!("a scan is a .stl, .ply or .obj file, not {ending:?}");
            return Err(FileError::wrong(path, problem));
        }
    };
    if vertices.iter().any(|vertex| !vertex.is_finite()) {
        return Err(FileError::wrong(path, "a vertex is not finite"));
    }
    if faces.iter().flatten().any(|&corner| corner >= vertices.len()) {
        return Err(FileError::wrong(path, "a face has a corner that is not in the file"));
    }
    let cut = |face: &Vec<usize>| {
        let corners: Vec<u32> = face.iter().map(|&corner| corner as u32).collect();
        polygon::triangles(&corners, &vertices)
    };
    let crosses = || FileError::wrong(path, "a face crosses itself");
    let triangles: Vec<_> = faces
        .iter()
        .filter(|face| face.len() > 2)
        .map(cut)
        .collect::<Option<_>>()
        .ok_or_else(crosses)?;
    let faces = triangles.concat();
    let vertices: Vec<DVec3> = vertices.into_iter().map(|vertex| vertex * unit_um).collect();
    Ok(welded(&vertices, &faces))
}

type Polygons = (Vec<DVec3>, Vec<Vec<usize>>);

/// Bytes of the head of a binary .stl file with its count, and of each triangle.
const STL_HEAD: usize = 84;
const STL_TRIANGLE: usize = 50;

/// A .stl file as the crate reads it: text in lower case with a name, and no normals. They may be no
/// numbers, and nothing needs them.
fn plain_stl(path: &Path, bytes: &[u8]) -> Result<Vec<u8>, FileError> {
    let count = bytes.get(80..STL_HEAD).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
    let length = count.map(|count| STL_HEAD as u64 + STL_TRIANGLE as u64 * u64::from(count));
    if length != Some(bytes.len() as u64) {
        // The head of a binary file may begin with the same word.
        let text = text::decode(bytes).to_lowercase();
        if text.trim_start().starts_with("solid") && text.contains("facet") {
            let line = |line: &str| match line.trim() {
                first if first.starts_with("solid") => "solid scan\n".to_owned(),
                facet if facet.starts_with("facet") => "facet normal 0 0 0\n".to_owned(),
                other => format!("{other}\n"),
            };
            return Ok(text.lines().map(line).collect::<String>().into_bytes());
        }
    }
    let Some((count, length)) = count.zip(length) else {
        return Err(FileError::wrong(path, "it is no .stl file, neither text nor binary"));
    };
    if length > bytes.len() as u64 {
        let problem = format!("it is cut short: {} bytes for {count} triangles", bytes.len());
        return Err(FileError::wrong(path, problem));
    }
    let mut plain = bytes.to_vec();
    for triangle in plain[STL_HEAD..].chunks_exact_mut(STL_TRIANGLE) {
        triangle[..12].fill(0);
    }
    Ok(plain)
}

fn stl(path: &Path, bytes: &[u8]) -> Result<Polygons, FileError> {
    let plain = plain_stl(path, bytes)?;
    let mesh = stl_io::read_stl(&mut Cursor::new(plain))
        .map_err(|error| FileError::wrong(path, error.to_string()))?;
    let vertex = |of: &stl_io::Vertex| DVec3::from(of.0.map(f64::from));
    let vertices = mesh.vertices.iter().map(vertex).collect();
    Ok((vertices, mesh.faces.iter().map(|face| face.vertices.to_vec()).collect()))
}

fn ply(path: &Path, bytes: &[u8]) -> Result<Polygons, FileError> {
    if !bytes.starts_with(b"ply") {
        return Err(FileError::wrong(path, "it is no .ply file"));
    }
    let wrong = |what: &str, error: &dyn std::fmt::Display| {
        let error = error.to_string();
        // The parser appends what led to it.
        let first = error.split(['\n', '\\']).next().unwrap_or_default();
        FileError::wrong(path, format!("{what} cannot be read: {first}"))
    };
    let mut reader = Reader::new(BufReader::new(bytes));
    let header =
        Parser::<Element>::new().read_header(&mut reader).map_err(|e| wrong("its header", &e))?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        let read = Parser::<Element>::new()
            .read_payload_for_element(&mut reader, element, &header)
            .map_err(|error| wrong(&format!("its element {name}"), &error))?;
        match name.as_str() {
            "vertex" => vertices = read.into_iter().map(|of| DVec3::from(of.at)).collect(),
            "face" => faces = read.into_iter().map(|of| of.corners).collect(),
            _ => {}
        }
    }
    Ok((vertices, faces))
}

/// An element of a .ply file: of a vertex its place, of a face its corners.
struct Element {
    at: [f64; 3],
    corners: Vec<usize>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self { at: [f64::NAN; 3], corners: Vec::new() }
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        if let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == key) {
            self.at[axis] = match (&property, property.to_f32_lossy()) {
                (Property::Double(x), _) => *x,
                (_, Some(x)) => x.into(),
                (_, None) => return PropertyAccessResult::UnsupportedType,
            };
        } else if ["vertex_indices", "vertex_index"].contains(&key) {
            let Some(list) = property.to_u32_list() else {
                return PropertyAccessResult::UnsupportedType;
            };
            self.corners = list.into_iter().map(|corner| corner as usize).collect();
        } else {
            return PropertyAccessResult::Ignored;
        }
        PropertyAccessResult::Set
    }
}

/// A body of these triangles with one corner in each place, and without those that have a corner
/// twice.
fn welded(points: &[DVec3], triangles: &[[u32; 3]]) -> Solid {
    let mut known = HashMap::new();
    let mut vertices = Vec::new();
    let number: Vec<usize> = points
        .iter()
        .map(|vertex| {
            // Adding 0 makes one zero of both.
            *known.entry(vertex.to_array().map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                vertices.push(*vertex);
                vertices.len() - 1
            })
        })
        .collect();
    let faces = triangles
        .iter()
        .map(|triangle| triangle.map(|corner| number[corner as usize]))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .map(Vec::from)
        .collect();
    Solid { vertices, faces }
}

/// The body with corners at open edges joined where they differ by rounding, and how many were
/// joined with another one. Triangles that this leaves with two corners are left out.
fn joined_within_rounding(solid: &Solid) -> (Solid, usize) {
    let farthest = solid.vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    let within = ROUNDING * farthest.max(solid.size());
    let cell = |vertex: DVec3| (vertex / within).floor().to_array().map(|x| x as i64);
    let mut known: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut number: Vec<usize> = (0..solid.vertices.len()).collect();
    let mut joined = 0;
    for corner in solid.open_corners() {
        let (at, own) = (solid.vertices[corner], cell(solid.vertices[corner]));
        let around =
            (0..27).map(|i| [own[0] + i % 3 - 1, own[1] + i / 3 % 3 - 1, own[2] + i / 9 - 1]);
        let same = around
            .filter_map(|cell| known.get(&cell))
            .flatten()
            .find(|other| solid.vertices[**other].distance(at) <= within)
            .copied();
        if let Some(other) = same {
            number[corner] = other;
            joined += 1;
        } else {
            known.entry(own).or_default().push(corner);
        }
    }
    let mut faces: Vec<Vec<usize>> = solid.faces.clone();
    for corner in faces.iter_mut().flatten() {
        *corner = number[*corner];
    }
    faces.retain(|face| face[0] != face[1] && face[1] != face[2] && face[2] != face[0]);
    (used(&solid.vertices, faces), joined)
}

/// The body with as few triangles as keep its surface within a distance, and the decimator's
/// estimate of that distance, um.
fn thinned(solid: &Solid, deviation_um: f64) -> (Solid, f64) {
    if deviation_um == 0.0 {
        return (solid.clone(), 0.0);
    }
    let middle = solid.centroid();
    let points: Vec<[f32; 3]> =
        solid.vertices.iter().map(|vertex| (*vertex - middle).as_vec3().to_array()).collect();
    let indices: Vec<u32> = solid.faces.iter().flatten().map(|&corner| corner as u32).collect();
    let mut moved = 0.0;
    let kept = meshopt::simplify_decoder(
        &indices,
        &points,
        0,
        deviation_um as f32,
        SimplifyOptions::ErrorAbsolute,
        Some(&mut moved),
    );
    let faces = kept.chunks_exact(3).map(|t| t.iter().map(|&i| i as usize).collect()).collect();
    (used(&solid.vertices, faces), f64::from(moved))
}

/// The body of some faces, with the corners that they use.
fn used(vertices: &[DVec3], mut faces: Vec<Vec<usize>>) -> Solid {
    let mut number = vec![usize::MAX; vertices.len()];
    let mut kept = Vec::new();
    for corner in faces.iter_mut().flatten() {
        if number[*corner] == usize::MAX {
            number[*corner] = kept.len();
            kept.push(vertices[*corner]);
        }
        *corner = number[*corner];
    }
    Solid { vertices: kept, faces }
}

fn obj_text(solid: &Solid) -> String {
    let mut text = String::new();
    for DVec3 { x, y, z } in &solid.vertices {
        let _ = writeln!(text, "v {x:.9} {y:.9} {z:.9}");
    }
    for face in &solid.faces {
        let corners: Vec<String> = face.iter().map(|corner| (corner + 1).to_string()).collect();
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text
}
