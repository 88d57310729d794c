//! DIRSIG's object database and material list as a scene.
//!
//! What is read: of a .odb objects with OBJ_FILENAME, UNITS and instances as nine numbers (translation in metres, scale,
//! rotation about x, y and z in degrees, in that order) or as a 4 x 4 matrix; of a .mat the emissivity file, the share that is
//! specular and a fixed temperature. Everything else is named and left out.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3, EulerRot};

use crate::geometry::ingest::obj::ObjFile;
use crate::scene::{
    FORMAT, Instance, Material, Placed, Prototype, Scene, SceneGeometry, SpectrumSource, UpAxis,
    View,
};
use crate::support::error::Failure;
use crate::support::file_error::FileError;

/// Temperature of what has none in the .mat file, kelvin.
const TEMPERATURE_K: f64 = 300.0;

/// A DIRSIG file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DirsigError {
    /// A mesh cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not of its form, or has what has no equal here.
    #[error("{}, line {line}: {problem}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
}

impl Failure for DirsigError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::File(_) | Self::Read { .. } => None,
            Self::Form { .. } => Some("docs/images.md says what is read of DIRSIG's files".into()),
        }
    }
}

/// A section of a file of tags: values and sections, each with its line.
#[derive(Debug, Default)]
struct Section {
    line: usize,
    values: Vec<(String, String, usize)>,
    sections: Vec<(String, Section)>,
}

impl Section {
    fn read(path: &Path) -> Result<Self, DirsigError> {
        let text =
            fs::read(path).map_err(|source| DirsigError::Read { path: path.to_owned(), source })?;
        let text = crate::support::envi::text(text);
        let mut open = vec![(String::new(), Self::default())];
        for (i, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or_default().trim();
            let place = |problem: &str| DirsigError::Form {
                path: path.to_owned(),
                line: i + 1,
                problem: problem.into(),
            };
            if let Some(name) = line.strip_suffix('{') {
                let section = Self { line: i + 1, ..Self::default() };
                open.push((name.trim().to_owned(), section));
            } else if line == "}" {
                let (name, section) = open.pop().expect("the outermost is never closed");
                let (_, outer) = open.last_mut().ok_or_else(|| place("a } closes nothing"))?;
                outer.sections.push((name, section));
            } else if let Some((key, value)) = line.split_once('=') {
                let (_, section) = open.last_mut().expect("the outermost is never closed");
                section.values.push((key.trim().to_owned(), value.trim().to_owned(), i + 1));
            } else if !line.is_empty() {
                return Err(place("neither NAME = VALUE nor NAME {"));
            }
        }
        let (name, outermost) = open.pop().expect("the outermost is never closed");
        if open.is_empty() {
            return Ok(outermost);
        }
        let problem = format!("{name} is not closed");
        Err(DirsigError::Form { path: path.to_owned(), line: outermost.line, problem })
    }

    fn get(&self, key: &str) -> Option<(&str, usize)> {
        let found = self.values.iter().find(|(name, ..)| name == key)?;
        Some((&found.1, found.2))
    }

    fn section(&self, name: &str) -> Option<&Self> {
        self.sections.iter().find(|(n, _)| n == name).map(|(_, section)| section)
    }
}

/// A scene of a .odb file and a .mat file, for a scene file in `folder`; and what was left out, a sentence each. The sensor
/// looks straight down at all of it.
///
/// # Errors
/// A file that cannot be read, or an object, unit or material that has no equal here.
pub fn import(odb: &Path, mat: &Path, folder: &Path) -> Result<(Scene, Vec<String>), DirsigError> {
    let mut left_out = vec![
        "platform, sensor, sky and atmosphere are not read: the sensor looks straight down at all of the scene, \
         under a cold black sky"
            .to_owned(),
    ];
    let objects = Section::read(odb)?;
    let wrong = |line, problem: String| DirsigError::Form { path: odb.to_owned(), line, problem };
    if objects.get("DIRSIG_ODB").is_none() {
        return Err(wrong(1, "DIRSIG_ODB = 1.0 is missing".into()));
    }
    let (mut prototypes, mut instances, mut names) = (Vec::new(), Vec::new(), BTreeSet::new());
    for (kind, object) in &objects.sections {
        if kind != "OBJECT" {
            left_out.push(format!("{kind} in line {} of the .odb", object.line));
            continue;
        }
        let Some((file, _)) = object.get("OBJ_FILENAME") else {
            return Err(wrong(object.line, "an object without OBJ_FILENAME".into()));
        };
        let unit_um = match object.get("UNITS") {
            None => return Err(wrong(object.line, "an object without UNITS".into())),
            Some(("METERS", _)) => 1e6,
            Some(("CENTIMETERS", _)) => 1e4,
            Some(("MILLIMETERS", _)) => 1e3,
            Some(("INCHES", _)) => 25_400.0,
            Some(("FEET", _)) => 304_800.0,
            Some((other, line)) => {
                return Err(wrong(line, format!("UNITS = {other} is not known")));
            }
        };
        let file = odb.parent().unwrap_or(Path::new("")).join(file);
        names.extend(ObjFile::read(&file)?.materials().iter().cloned());
        let name = format!("object_{}", prototypes.len());
        let places = object.section("INSTANCES").map_or(&[][..], |section| &section.values);
        if places.is_empty() {
            left_out.push(format!(
                "the object in line {} of the .odb, which has no INSTANCES",
                object.line
            ));
        }
        for (key, value, line) in places {
            if key != "INFO" {
                left_out.push(format!("{key} in line {line} of the .odb"));
                continue;
            }
            let transform = place(value).ok_or_else(|| {
                wrong(*line, "an instance is 9 numbers or the 16 of a 4 x 4 matrix".into())
            })?;
            instances.push(Instance { prototype: name.clone(), transform });
        }
        prototypes.push(Prototype {
            name,
            file: seen_from(&file, folder),
            object: None,
            unit_um: Some(unit_um),
            up: Some(UpAxis::Z),
            material: None,
        });
    }
    if instances.is_empty() {
        return Err(wrong(1, "no object has INSTANCES".into()));
    }
    let materials = materials(mat, &names, folder, &mut left_out)?;
    let scene = Scene {
        file: PathBuf::new(),
        soilsig_scene: FORMAT,
        name: odb.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        description: Some("imported from DIRSIG's files".into()),
        seed: 1,
        temperature_k: TEMPERATURE_K,
        sky_temperature_k: None,
        sky_radiance: None,
        atmosphere_file: None,
        view: View { zenith_deg: 0.0, azimuth_deg: 0.0 },
        sensor: None,
        materials,
        geometry: SceneGeometry::Placed(Placed {
            prototypes,
            instances: Some(instances),
            domain: None,
        }),
    };
    Ok((scene, left_out))
}

/// The materials that faces name, by their NAME or their ID.
fn materials(
    mat: &Path,
    names: &BTreeSet<String>,
    folder: &Path,
    left_out: &mut Vec<String>,
) -> Result<Vec<Material>, DirsigError> {
    let list = Section::read(mat)?;
    let wrong = |line, problem: String| DirsigError::Form { path: mat.to_owned(), line, problem };
    let mut materials = Vec::new();
    for name in names {
        // Faces name the ID. Only where none is so called it may be a NAME.
        let called = |keys: [&str; 2]| {
            let is_called = |entry: &&Section| {
                keys.iter().any(|key| entry.get(key).is_some_and(|(value, _)| value == name))
            };
            list.sections.iter().map(|(_, entry)| entry).find(is_called)
        };
        let entry = called(["ID", "MATERIAL_ID"]).or_else(|| called(["NAME", "MATERIAL_NAME"]));
        let entry = entry
            .ok_or_else(|| wrong(1, format!("there is no material {name:?}, which faces name")))?;
        let property =
            entry.section("SURFACE_PROPERTIES").and_then(|s| s.section("EMISSIVITY_PROP"));
        let file = property
            .and_then(|property| property.get("FILENAME"))
            .or_else(|| entry.get("EMISSIVITY_FILE"));
        let Some((file, _)) = file else {
            let problem = format!("material {name:?} has no emissivity file");
            return Err(wrong(entry.line, problem));
        };
        let number = |value: Option<(&str, usize)>| {
            let parsed = |(value, line): (&str, usize)| {
                let error = || wrong(line, format!("{value:?} is not a number"));
                value.parse::<f64>().map_err(|_| error())
            };
            value.map(parsed).transpose()
        };
        let solver = entry.section("TEMP_SOLVER");
        let temperature_k = number(solver.and_then(|solver| solver.get("TEMPERATURE")))?;
        if temperature_k.is_none() {
            left_out.push(format!(
                "material {name:?} has no fixed temperature: it has {TEMPERATURE_K} K here"
            ));
        }
        let share = property.and_then(|property| property.get("SPECULAR_FRACTION"));
        let file = mat.parent().unwrap_or(Path::new("")).join(file);
        materials.push(Material {
            name: name.clone(),
            spectrum: SpectrumSource::File(seen_from(&file, folder)),
            temperature_k,
            specular: number(share.or_else(|| entry.get("SPECULARITY")))?,
        });
    }
    Ok(materials)
}

/// A file's path as the scene file in `folder` names it.
fn seen_from(file: &Path, folder: &Path) -> PathBuf {
    let [file, folder] =
        [file, folder].map(|path| std::path::absolute(path).unwrap_or(path.to_owned()));
    file.strip_prefix(&folder).map(Path::to_owned).unwrap_or(file)
}

/// The upper three rows of the matrix of an instance, its last column in um.
fn place(text: &str) -> Option<[f64; 12]> {
    let numbers: Vec<f64> = text
        .split([',', ' ', '\t'])
        .filter(|word| !word.is_empty())
        .map(str::parse)
        .collect::<Result<_, _>>()
        .ok()?;
    let (matrix, move_m) = match numbers[..] {
        [x, y, z, sx, sy, sz, rx, ry, rz] => {
            let [rx, ry, rz] = [rx, ry, rz].map(f64::to_radians);
            let turn = DMat3::from_euler(EulerRot::ZYX, rz, ry, rx);
            (turn * DMat3::from_diagonal(DVec3::new(sx, sy, sz)), DVec3::new(x, y, z))
        }
        [a, b, c, x, d, e, f, y, g, h, i, z, 0.0, 0.0, 0.0, 1.0] => {
            let columns = [[a, d, g], [b, e, h], [c, f, i]];
            (DMat3::from_cols_array_2d(&columns), DVec3::new(x, y, z))
        }
        _ => return None,
    };
    let place = DAffine3 { matrix3: matrix, translation: move_m };
    super::matrix(&place, 1e-6)[..12].try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instances_are_read_as_nine_numbers_and_as_matrices() {
        let of = |text| place(text).expect("an instance");
        let moved = of("1, 2, 3, 1, 1, 1, 0, 0, 0");
        assert_eq!(moved, [1.0, 0.0, 0.0, 1e6, 0.0, 1.0, 0.0, 2e6, 0.0, 0.0, 1.0, 3e6]);
        // A quarter turn about z brings x to y; the scale comes first.
        let turned = of("0 0 0 2 1 1 0 0 90");
        assert!((turned[4] - 2.0).abs() < 1e-15 && turned[0].abs() < 1e-15);
        let matrix = of("0 -1 0 1 2 0 0 0 0 0 1 0 0 0 0 1");
        assert_eq!(matrix, [0.0, -1.0, 0.0, 1e6, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert!(place("1 2 3").is_none() && place("path.mov").is_none());
    }
}
