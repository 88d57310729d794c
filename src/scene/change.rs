//! Changes of a scene's values, as the command line asks for them.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::{Facets, Packing, Scene, SceneError, SceneGeometry};
use crate::support::file_error::FileError;

/// A value that replaces one of the scene's: `view.zenith_deg=35`. Its text form is that of the
/// command line and of the record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Change {
    /// Keys from the scene down, divided by dots. In a list the key is a name or a number from 0.
    key: String,
    /// JSON. `null` takes the key away.
    value: Value,
}

impl FromStr for Change {
    type Err = String;

    /// Reads `KEY=VALUE`. A value that is not JSON is text.
    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) =
            text.split_once('=').ok_or("write KEY=VALUE, as in view.zenith_deg=35")?;
        Self::to(key, serde_json::from_str(value).unwrap_or_else(|_| Value::String(value.into())))
    }
}

impl TryFrom<String> for Change {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Change> for String {
    fn from(change: Change) -> Self {
        change.to_string()
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.key, self.value)
    }
}

impl Change {
    /// A change of a key to a JSON value.
    ///
    /// # Errors
    /// The key has an empty part.
    pub fn to(key: &str, value: Value) -> Result<Self, String> {
        if key.split('.').any(|part| part.trim() != part || part.is_empty()) {
            return Err(format!("{key:?} is not a key: write it as in view.zenith_deg"));
        }
        Ok(Self { key: key.into(), value })
    }

    /// The key.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// That of all powders' facets.
    pub(super) fn of_facets(facets: Facets) -> Self {
        Self { key: "facets".into(), value: serde_json::to_value(facets).expect("plain data") }
    }

    /// Puts the value in its place.
    fn make(&self, scene: &mut Value) -> Result<(), String> {
        let (above, last) = match self.key.rsplit_once('.') {
            Some((above, last)) => (above.split('.').collect(), last),
            None => (Vec::new(), &*self.key),
        };
        let mut place = scene;
        for key in above {
            place = below(place, key)?;
            if place.is_null() {
                *place = Value::Object(Map::new());
            }
        }
        if self.value.is_null()
            && let Value::Object(keys) = place
        {
            keys.remove(last);
            return Ok(());
        }
        *below(place, last)? = self.value.clone();
        Ok(())
    }
}

/// What a key names; of an object a new key, too.
fn below<'a>(place: &'a mut Value, key: &str) -> Result<&'a mut Value, String> {
    match place {
        Value::Object(keys) => Ok(keys.entry(key).or_insert(Value::Null)),
        Value::Array(list) => {
            let name = |entry: &Value| entry.get("name").and_then(Value::as_str).map(str::to_owned);
            let names: Vec<String> = list.iter().filter_map(name).collect();
            let number = names.iter().position(|name| name == key).or_else(|| key.parse().ok());
            let entries = list.len();
            number.and_then(|number| list.get_mut(number)).ok_or_else(|| {
                if names.is_empty() {
                    format!("{key:?} is not an entry of a list of {entries}")
                } else {
                    format!("{key:?} is not an entry of the list: {}", names.join(", "))
                }
            })
        }
        value => Err(format!("{value} has no key {key:?}")),
    }
}

impl Scene {
    /// The scene as its file states it: with its soil, if it has one, in place of the packing.
    pub fn stated(&self) -> Value {
        let mut value = serde_json::to_value(self).expect("plain data");
        if let SceneGeometry::Packing(Packing { soil: Some(soil), .. }) = &self.geometry {
            value["geometry"] = json!({ "soil": soil });
        }
        value
    }

    /// The scene with other values, checked as its file was.
    ///
    /// # Errors
    /// An unknown key, or a value that does not fit.
    pub fn changed(self, changes: &[Change]) -> Result<Self, SceneError> {
        if changes.is_empty() {
            return Ok(self);
        }
        let words: Vec<String> = changes.iter().map(|change| format!("--set {change}")).collect();
        let at = format!("{} with {}", self.file.display(), words.join(" "));
        let mut value = self.stated();
        for change in changes {
            change
                .make(&mut value)
                .map_err(|problem| FileError::wrong(Path::new(&at), problem).with_hint(FORMAT))?;
        }
        let mut scene = Self::of(serde_json::from_value(value), Path::new(&at))?;
        scene.file = self.file;
        scene.changes = [self.changes, changes.to_vec()].concat();
        Ok(scene)
    }
}

/// Where the keys are listed.
pub(super) const FORMAT: &str =
    "`soilsig schema scene` prints the format; docs/guide/own_scenes.md explains it";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Sky, SpectrumSource, shipped};

    fn sparse() -> Scene {
        Scene::parse(shipped::text("sparse").expect("shipped"), Path::new("sparse.json"))
            .expect("sound")
    }

    fn changed(texts: &[&str]) -> Result<Scene, String> {
        let changes: Result<Vec<Change>, String> = texts.iter().map(|text| text.parse()).collect();
        sparse().changed(&changes?).map_err(|error| error.to_string())
    }

    #[test]
    fn values_are_typed_by_json_and_checked_as_in_the_file() {
        let scene = changed(&[
            "view.zenith_deg=35",
            "temperature_k=310",
            "sky_temperature_k=290",
            "name=tilted",
            "materials.fine.spectrum={\"constant\": 0.9}",
            "sensor.pixels=[8, 4]",
        ])
        .expect("sound");
        assert_eq!((scene.view.zenith_deg, scene.temperature_k.kelvin()), (35.0, 310.0));
        assert_eq!(scene.sky_temperature_k, Some(Sky::Isotropic(290.0)));
        assert_eq!(scene.name, "tilted");
        let fine = scene.material_index("fine").expect("a material");
        assert_eq!(scene.materials[fine].spectrum, SpectrumSource::Constant(0.9));
        assert_eq!(scene.sensor.expect("a sensor").pixels, [8, 4]);
        assert_eq!(scene.file, sparse().file);
        assert_eq!(changed(&["sky_temperature_k=null"]).expect("sound").sky_temperature_k, None);
        assert_eq!(changed(&[]).expect("sound"), sparse());
    }

    #[test]
    fn a_change_is_recorded_as_it_is_written() {
        for text in ["view.zenith_deg=35.5", "name=\"a=b\"", "sensor.pixels=[8,4]"] {
            let change: Change = text.parse().expect("a change");
            let json = serde_json::to_string(&change).expect("plain data");
            assert_eq!(serde_json::from_str::<Change>(&json).expect("the same"), change);
            assert_eq!(change.to_string(), text);
        }
    }
}
