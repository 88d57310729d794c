//! `ro-crate-metadata.json`: the files of a result and the run that made them, by the Process Run
//! Crate profile of Workflow Run RO-Crate.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

/// The file's name.
pub const FILE: &str = "ro-crate-metadata.json";

const CONTEXT: &str = "https://w3id.org/ro/crate/1.1/context";
const PROFILE: &str = "https://w3id.org/ro/wfrun/process/0.5";

/// A run, and its files by their paths below the result's folder, with their SHA-256 if it is known.
pub struct Run<'a> {
    /// Name of the result.
    pub name: &'a str,
    /// What it is, in a sentence.
    pub description: String,
    /// The command line.
    pub command: &'a [String],
    /// Begin of the run.
    pub started: SystemTime,
    /// Programs, by name.
    pub versions: &'a BTreeMap<String, String>,
    /// Files read.
    pub inputs: Vec<(String, Option<String>)>,
    /// Files written.
    pub outputs: Vec<(String, Option<String>)>,
    /// Folders written, with their meanings.
    pub folders: Vec<(&'a str, &'a str)>,
}

/// Programs among the versions of a record, with their homes.
const PROGRAMS: [(&str, &str, &str); 4] = [
    ("soilsig", "soilsig", "https://crates.io/crates/soilsig"),
    ("blender", "Blender", "https://www.blender.org"),
    ("python", "Python", "https://www.python.org"),
    ("numpy", "NumPy", "https://numpy.org"),
];

/// Kinds of files by their endings.
const KINDS: [(&str, &str); 12] = [
    ("blend", "application/x-blender"),
    ("csv", "text/csv"),
    ("glb", "model/gltf-binary"),
    ("html", "text/html"),
    ("json", "application/json"),
    ("log", "text/plain"),
    ("mtl", "model/mtl"),
    ("nc", "application/netcdf"),
    ("obj", "model/obj"),
    ("png", "image/png"),
    ("svg", "image/svg+xml"),
    ("txt", "text/plain"),
];

impl Run<'_> {
    /// The text of the file.
    pub fn text(&self) -> String {
        let ended = SystemTime::now();
        let id = |id: &str| json!({ "@id": id });
        let reference = |(path, _): &(String, Option<String>)| id(&escaped(path));
        let folders: Vec<Value> = self.folders.iter().map(|(path, _)| id(path)).collect();
        let [inputs, outputs] = [&self.inputs, &self.outputs]
            .map(|files| files.iter().map(reference).collect::<Vec<_>>());
        let parts = [&inputs[..], &outputs, &folders].concat();
        let results = [&outputs[..], &folders].concat();
        let is_known = |(key, ..): &&(&str, &str, &str)| self.versions.contains_key(*key);
        let programs = || PROGRAMS.iter().filter(is_known);
        let needed: Vec<Value> =
            programs().skip(1).map(|(key, ..)| id(&format!("#{key}"))).collect();
        let mut graph = vec![
            json!({
                "@id": FILE,
                "@type": "CreativeWork",
                "conformsTo": id("https://w3id.org/ro/crate/1.1"),
                "about": id("./"),
            }),
            json!({
                "@id": "./",
                "@type": "Dataset",
                "conformsTo": id(PROFILE),
                "name": self.name,
                "description": self.description,
                "datePublished": iso_8601(ended),
                "license": "Not stated: ask those who made this result.",
                "hasPart": parts,
                "mentions": id("#run"),
            }),
            json!({
                "@id": PROFILE,
                "@type": "CreativeWork",
                "name": "Process Run Crate",
                "version": "0.5",
            }),
            json!({
                "@id": "#run",
                "@type": "CreateAction",
                "name": format!("Run of soilsig: {}", self.name),
                "description": self.command.join(" "),
                "instrument": id("#soilsig"),
                "startTime": iso_8601(self.started),
                "endTime": iso_8601(ended),
                "actionStatus": id("http://schema.org/CompletedActionStatus"),
                "object": inputs,
                "result": results,
            }),
        ];
        for (key, name, url) in programs() {
            let mut program = json!({
                "@id": format!("#{key}"),
                "@type": "SoftwareApplication",
                "name": name,
                "url": url,
                "softwareVersion": self.versions[*key],
            });
            if *key == "soilsig" && !needed.is_empty() {
                program["softwareRequirements"] = needed.clone().into();
            }
            graph.push(program);
        }
        for (path, sha256) in self.inputs.iter().chain(&self.outputs) {
            let name = path.rsplit('/').next().unwrap_or(path);
            let mut file = json!({ "@id": escaped(path), "@type": "File", "name": name });
            let ending = Path::new(path).extension().unwrap_or_default().to_string_lossy();
            if let Some((_, kind)) = KINDS.iter().find(|(known, _)| *known == ending) {
                file["encodingFormat"] = (*kind).into();
            }
            if let Some(sum) = sha256 {
                file["sha256"] = sum.as_str().into();
            }
            graph.push(file);
        }
        for (path, meaning) in &self.folders {
            let name = path.trim_end_matches('/');
            let folder = json!({
                "@id": path, "@type": "Dataset", "name": name, "description": meaning,
            });
            graph.push(folder);
        }
        // That version of the context has no SHA-256.
        let context = json!([CONTEXT, { "sha256": "http://schema.org/sha256" }]);
        let all = json!({ "@context": context, "@graph": graph });
        serde_json::to_string_pretty(&all).expect("plain data") + "\n"
    }
}

/// A path as a relative URI.
fn escaped(path: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-._~/".contains(&b);
    path.bytes()
        .map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") })
        .collect()
}

/// A moment in UTC, to the second.
fn iso_8601(at: SystemTime) -> String {
    let seconds = at.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (days, of_day) = (seconds / 86_400, seconds % 86_400);
    // Days are counted from the 1st of March of year 0, in cycles of 400 years.
    let shifted = days + 719_468;
    let (cycle, of_cycle) = (shifted / 146_097, shifted % 146_097);
    let year = (of_cycle - of_cycle / 1460 + of_cycle / 36_524 - of_cycle / 146_096) / 365;
    let of_year = of_cycle - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = 400 * cycle + year + u64::from(month <= 2);
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn moments_are_those_of_the_calendar() {
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_200, "2024-03-01T00:00:00Z"),
            (4_102_444_799, "2099-12-31T23:59:59Z"),
        ] {
            assert_eq!(iso_8601(UNIX_EPOCH + Duration::from_secs(seconds)), text);
        }
    }

    #[test]
    fn paths_are_uris() {
        assert_eq!(escaped("inputs/Böden/a b.csv"), "inputs/B%C3%B6den/a%20b.csv");
    }
}
