//! DIRSIG's object database and material list as a scene.
//!
//! Of a .odb file it reads objects with OBJ_FILENAME, UNITS and instances. An instance is nine
//! numbers (translation in metres, scale, rotation about x, y and z in degrees) or a 4 x 4 matrix.
//! Of a .mat file it reads emissivity file, specular fraction and fixed temperature. It names what
//! it leaves out.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3, EulerRot};

use crate::geometry::ingest::obj::ObjFile;
use crate::scene::{
    FORMAT, Instance, Material, Origin, Placed, Prototype, Scene, SceneGeometry, SceneTemperature,
    SpectrumSource, UpAxis, View,
};
use crate::spectrum::format::{self, Reading};
use crate::support::error::Failure;
use crate::support::file_error::FileError;
use crate::support::text;

/// Temperature of materials without one in the .mat file, K.
const TEMPERATURE_K: f64 = 300.0;

/// A DIRSIG file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct DirsigError(#[from] FileError);

impl Failure for DirsigError {
    fn hint(&self) -> Option<String> {
        self.0.hint_or("docs/guide/other_programs.md says what is read of DIRSIG's files")
    }
}

/// A section `NAME { ... }` of a file of tags.
#[derive(Debug)]
struct Section<'a> {
    path: &'a Path,
    name: String,
    line: u64,
    /// Keys, values and lines.
    values: Vec<(String, String, u64)>,
    sections: Vec<Section<'a>>,
}

impl<'a> Section<'a> {
    fn new(path: &'a Path, name: &str, line: u64) -> Self {
        Self { path, name: name.to_owned(), line, values: Vec::new(), sections: Vec::new() }
    }

    /// Reads a file as one nameless section.
    fn read(path: &'a Path) -> Result<Self, DirsigError> {
        let mut open = Vec::new();
        // The name of a section whose brace stands in the next line.
        let mut named: Option<(String, u64)> = None;
        let mut section = Self::new(path, "", 1);
        for (number, line) in (1..).zip(text::read(path)?.lines()) {
            let line = line.trim();
            let code = without_comment(line);
            let pair = line.split_once('=').filter(|_| !line.starts_with('#'));
            if let ("{", Some((name, at))) = (code, named.take_if(|_| !code.is_empty())) {
                open.push(std::mem::replace(&mut section, Self::new(path, &name, at)));
            } else if let Some(name) = code.strip_suffix('{').filter(|name| !name.contains('=')) {
                open.push(std::mem::replace(&mut section, Self::new(path, name.trim(), number)));
            } else if code == "}" {
                let outer =
                    open.pop().ok_or_else(|| section.wrong(number, "a } closes nothing"))?;
                let inner = std::mem::replace(&mut section, outer);
                section.sections.push(inner);
            } else if let Some((key, value)) = pair {
                section.values.push((key.trim().to_owned(), value.trim().to_owned(), number));
            } else if code.chars().all(is_of_name) && !code.is_empty() {
                named = Some((code.to_owned(), number));
            } else if !code.is_empty() {
                return Err(section.wrong(number, "this is neither NAME = VALUE nor NAME {"));
            }
        }
        if open.is_empty() {
            return Ok(section);
        }
        Err(section.wrong(section.line, format!("{} is not closed", section.name)))
    }

    fn wrong(&self, line: u64, problem: impl Into<Box<str>>) -> DirsigError {
        FileError::wrong_in_line(self.path, line, problem).into()
    }

    /// What the section lacks.
    fn lacks(&self, what: &str) -> DirsigError {
        self.wrong(self.line, what)
    }

    /// The value of a key, with its line. Names and files may have a # in them.
    fn get(&self, key: &str) -> Option<(&str, u64)> {
        let (_, value, line) = self.values.iter().find(|(name, ..)| name == key)?;
        let quoted = value.strip_prefix('"').and_then(|value| value.strip_suffix('"'));
        Some((quoted.unwrap_or(value), *line))
    }

    /// A value that has no # but that of a comment.
    fn word(&self, key: &str) -> Option<(&str, u64)> {
        self.get(key).map(|(value, line)| (without_comment(value), line))
    }

    fn section(&self, name: &str) -> Option<&Self> {
        self.sections.iter().find(|section| section.name == name)
    }

    /// A file that is named here, relative to this one. A comment may follow the name.
    fn file(&self, name: &str) -> PathBuf {
        let of = |name| self.path.parent().unwrap_or(Path::new("")).join(name);
        [name, without_comment(name)]
            .map(of)
            .into_iter()
            .find(|file| file.exists())
            .unwrap_or_else(|| of(name))
    }

    /// The unit of an object's lengths, um.
    fn unit_um(&self) -> Result<f64, DirsigError> {
        let Some((unit, line)) = self.word("UNITS") else {
            return Err(self.lacks("the object has no UNITS"));
        };
        Ok(match &*unit.to_ascii_uppercase() {
            "KILOMETERS" => 1e9,
            "METERS" => 1e6,
            "CENTIMETERS" => 1e4,
            "MILLIMETERS" => 1e3,
            "INCHES" => 25_400.0,
            "FEET" => 304_800.0,
            _ => return Err(self.wrong(line, format!("UNITS = {unit} is not known"))),
        })
    }

    fn number(&self, value: Option<(&str, u64)>) -> Result<Option<f64>, DirsigError> {
        let parsed = |(value, line): (&str, u64)| {
            value.parse().map_err(|_| self.wrong(line, format!("{value:?} is not a number")))
        };
        value.map(parsed).transpose()
    }
}

fn is_of_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

fn without_comment(text: &str) -> &str {
    text.split('#').next().unwrap_or_default().trim()
}

/// Makes a scene of a .odb and a .mat file, for a scene file in `folder`. The sensor looks straight
/// down at all of it. Also returns what was left out, as sentences.
///
/// # Errors
/// A file cannot be read, or an object, unit or material has no equivalent here.
#[allow(clippy::too_many_lines, reason = "one walk through the file")]
pub fn import(odb: &Path, mat: &Path, folder: &Path) -> Result<(Scene, Vec<String>), DirsigError> {
    let mut left_out = vec![
        "platform, sensor, sky and atmosphere are not read: the sensor looks straight down at all \
         of the scene, under a cold black sky"
            .to_owned(),
    ];
    let objects = Section::read(odb)?;
    if objects.get("DIRSIG_ODB").is_none() {
        return Err(objects.lacks("DIRSIG_ODB = 1.0 is missing"));
    }
    let (mut prototypes, mut instances, mut names) = (Vec::new(), Vec::new(), BTreeSet::new());
    for object in &objects.sections {
        if object.name != "OBJECT" {
            left_out.push(format!("{} in line {} of the .odb", object.name, object.line));
            continue;
        }
        let Some((file, _)) = object.get("OBJ_FILENAME") else {
            let of = object.values.iter().find(|(key, ..)| key.ends_with("_FILENAME"));
            let of = of.map_or(String::new(), |(key, value, _)| format!(" ({key} = {value})"));
            left_out.push(format!(
                "the object in line {} of the .odb{of}: only objects with OBJ_FILENAME are read",
                object.line
            ));
            continue;
        };
        let unit_um = object.unit_um()?;
        let file = object.file(file);
        let obj = ObjFile::read(&file)?;
        let of_faces = obj.materials();
        if obj.lacks_material() {
            let problem = if of_faces.is_empty() {
                "its faces name no material"
            } else {
                "some of its faces name no material"
            };
            return Err(FileError::wrong(&file, problem)
                .with_hint(
                    "name the ID of a material of the .mat file above the faces: `usemtl ID`",
                )
                .into());
        }
        names.extend(of_faces.into_iter().map(str::to_owned));
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
            let Some(transform) = place(without_comment(value)) else {
                left_out.push(format!(
                    "INFO = {value} in line {line} of the .odb: an instance is 9 numbers or the 16 \
                     of a 4 x 4 matrix"
                ));
                continue;
            };
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
        return Err(objects.lacks(&format!(
            "no object with an instance can be read: {}",
            left_out[1..].join("; ")
        )));
    }
    let materials = materials(mat, &names, folder, &mut left_out)?;
    let scene = Scene {
        file: PathBuf::new(),
        changes: Vec::new(),
        soilsig_scene: FORMAT,
        name: odb.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        description: Some("imported from DIRSIG's files".into()),
        seed: 1,
        temperature_k: SceneTemperature::Same(TEMPERATURE_K),
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
            origin: Origin::Given,
            drop: None,
        }),
    };
    // A number may be right there and not here.
    let text = serde_json::to_string(&scene).expect("plain data");
    if let Err(error) = Scene::parse(&text, mat) {
        return Err(FileError::wrong(odb, format!("no valid scene follows: {error}")).into());
    }
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
    let mut materials = Vec::new();
    for name in names {
        // Faces name the ID. Only if no ID matches, it may be a NAME.
        let called = |keys: [&str; 2]| {
            list.sections.iter().find(|entry| {
                let is = |value: &str| value == name || without_comment(value) == name;
                keys.iter().any(|key| entry.get(key).is_some_and(|(value, _)| is(value)))
            })
        };
        let entry = called(["ID", "MATERIAL_ID"])
            .or_else(|| called(["NAME", "MATERIAL_NAME"]))
            .ok_or_else(|| {
                list.lacks(&format!("there is no material {name:?}, which faces name"))
            })?;
        let same = |other: &&Section| {
            ["ID", "MATERIAL_ID"].iter().any(|key| {
                entry.get(key).is_some()
                    && other.get(key).map(|(id, _)| id) == entry.get(key).map(|(id, _)| id)
            })
        };
        if list.sections.iter().filter(same).count() > 1 {
            left_out.push(format!(
                "entries of the .mat with the ID of material {name:?} but the first"
            ));
        }
        let property =
            entry.section("SURFACE_PROPERTIES").and_then(|s| s.section("EMISSIVITY_PROP"));
        let of_property = |key| property.and_then(|property| property.get(key));
        let (file, _) = of_property("FILENAME")
            .or_else(|| entry.get("EMISSIVITY_FILE"))
            .ok_or_else(|| entry.lacks(&format!("material {name:?} has no emissivity file")))?;
        let file = list.file(file);
        let spectrum = format::read_one(&file, &Reading::default()).map_err(|error| {
            let problem = format!("material {name:?}: {error}");
            FileError::wrong_in_line(list.path, entry.line, problem)
        })?;
        for warning in &spectrum.warnings {
            left_out.push(format!("material {name:?}: {warning}"));
        }
        let solver = entry.section("TEMP_SOLVER");
        let temperature_k = entry.number(solver.and_then(|solver| solver.word("TEMPERATURE")))?;
        if temperature_k.is_none() {
            left_out.push(format!(
                "material {name:?} has no fixed temperature: it has {TEMPERATURE_K} K here"
            ));
        }
        let specular = property
            .and_then(|property| property.word("SPECULAR_FRACTION"))
            .or_else(|| entry.word("SPECULARITY"));
        materials.push(Material {
            name: name.clone(),
            spectrum: SpectrumSource::File(seen_from(&file, folder)),
            temperature_k,
            specular: entry.number(specular)?,
        });
    }
    Ok(materials)
}

/// A file's path in a scene file that lies in `folder`.
fn seen_from(file: &Path, folder: &Path) -> PathBuf {
    let [file, folder] =
        [file, folder].map(|path| std::path::absolute(path).unwrap_or(path.to_owned()));
    file.strip_prefix(&folder).map(Path::to_owned).unwrap_or(file)
}

/// The matrix of an instance without its last row; the last column is in um.
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
        // A quarter turn about z takes x to y, after the scale.
        let turned = of("0 0 0 2 1 1 0 0 90");
        assert!((turned[4] - 2.0).abs() < 1e-15 && turned[0].abs() < 1e-15);
        let matrix = of("0 -1 0 1 2 0 0 0 0 0 1 0 0 0 0 1");
        assert_eq!(matrix, [0.0, -1.0, 0.0, 1e6, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert!(place("1 2 3").is_none() && place("path.mov").is_none());
    }
}
