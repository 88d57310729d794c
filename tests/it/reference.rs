//! The pages of docs/reference are made from the schemas and the lists of columns in the code.
//!
//! `SOILSIG_WRITE_REFERENCE=1 cargo test --test it reference` writes them anew; else they must be
//! as they are written.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::{Map, Value};
use soilsig::cli::schema::{self, Format};
use soilsig::support::error::Status;

/// Compares a page with its file, or writes it.
fn keep(name: &str, page: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference").join(name);
    if std::env::var_os("SOILSIG_WRITE_REFERENCE").is_some() {
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(&path, page).expect("written");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page,
        "{} is not what the code says: SOILSIG_WRITE_REFERENCE=1 cargo test --test it reference",
        path.display()
    );
}

/// A text of several lines as one paragraph of at most 100 columns, indented.
fn wrapped(text: &str, first: &str, indent: &str) -> String {
    let mut lines = vec![first.to_owned()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is one");
        let is_empty = line.trim().is_empty() || line.ends_with("- ");
        if line.len() + word.len() < 100 || is_empty {
            if !is_empty {
                line.push(' ');
            }
            line.push_str(word);
        } else {
            lines.push(format!("{indent}{word}"));
        }
    }
    lines.join("\n") + "\n"
}

struct Schema<'a>(&'a Value);

impl Schema<'_> {
    fn text(&self, key: &str) -> &str {
        self.0.get(key).and_then(Value::as_str).unwrap_or_default()
    }

    fn has(&self, key: &str) -> bool {
        self.0.get(key).is_some()
    }

    fn list(&self, key: &str) -> &[Value] {
        self.0.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
    }

    /// What a value is, in words, with links to the definitions on the page.
    fn kind(&self) -> String {
        if let Some(name) = self.text("$ref").strip_prefix("#/$defs/") {
            return format!("[{name}](#{})", name.to_lowercase());
        }
        if self.has("const") {
            return format!("`{}`", self.0["const"]);
        }
        let others = ["anyOf", "oneOf"].iter().flat_map(|key| self.list(key));
        let kinds: Vec<String> =
            others.map(|other| Schema(other).kind()).filter(|kind| !kind.is_empty()).collect();
        if !kinds.is_empty() {
            return kinds.join(" or ");
        }
        let types: Vec<&str> = match &self.0["type"] {
            Value::String(one) => vec![one],
            Value::Array(all) => all.iter().filter_map(Value::as_str).collect(),
            _ => vec!["any value"],
        };
        let named = types.into_iter().filter(|of| *of != "null").map(|of| self.named(of));
        named.collect::<Vec<_>>().join(" or ")
    }

    fn named(&self, of: &str) -> String {
        let number = |key: &str| {
            let text = self.0.get(key)?.to_string();
            Some(text.strip_suffix(".0").unwrap_or(&text).to_owned())
        };
        match of {
            "array" => {
                let items = self.0.get("items").map_or("values".into(), |of| Schema(of).kind());
                match (number("minItems"), number("maxItems")) {
                    (Some(least), Some(most)) if least == most => format!("{least} of: {items}"),
                    (Some(least), _) if least != "0" => format!("list of {least} or more: {items}"),
                    _ => format!("list of: {items}"),
                }
            }
            "object" => match self.0.get("additionalProperties") {
                Some(of @ Value::Object(_)) => format!("by name: {}", Schema(of).kind()),
                _ if self.has("properties") => {
                    let keys = self.0["properties"].as_object().expect("keys").keys();
                    format!(
                        "object with {}",
                        keys.map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ")
                    )
                }
                _ => "object".into(),
            },
            "number" | "integer" => {
                let above = number("exclusiveMinimum").map(|x| format!("above {x}"));
                let least = number("minimum").map(|x| format!("{x} or more"));
                let most = number("maximum").map(|x| format!("at most {x}"));
                let below = number("exclusiveMaximum").map(|x| format!("below {x}"));
                let range: Vec<String> =
                    [above, least, most, below].into_iter().flatten().collect();
                if range.is_empty() { of.into() } else { format!("{of}, {}", range.join(", ")) }
            }
            other => other.into(),
        }
    }

    /// A list item for each key.
    fn keys(&self, page: &mut String, indent: &str) {
        let Some(properties) = self.0.get("properties").and_then(Value::as_object) else { return };
        let required: Vec<&str> = self.list("required").iter().filter_map(Value::as_str).collect();
        for (key, value) in properties {
            let schema = Schema(value);
            let default = value.get("default").filter(|value| !value.is_null());
            let needed = if required.contains(&key.as_str()) {
                ", required".into()
            } else {
                default.map_or(String::new(), |value| format!(", default `{value}`"))
            };
            let text =
                format!("`{key}` ({}{needed}): {}", schema.kind(), schema.text("description"));
            *page += &wrapped(&text, &format!("{indent}- "), &format!("{indent}  "));
            if schema.text("type") == "object" && schema.has("properties") {
                schema.keys(page, &format!("{indent}  "));
            }
        }
    }

    /// Sentences, keys and alternatives.
    fn body(&self, page: &mut String) {
        let description = self.text("description");
        if !description.is_empty() {
            *page += "\n";
            for paragraph in description.split("\n\n") {
                *page += &wrapped(paragraph, "", "");
                *page += "\n";
            }
        }
        self.keys(page, "");
        for other in ["anyOf", "oneOf"].iter().flat_map(|key| self.list(key)) {
            let schema = Schema(other);
            let text = match schema.kind() {
                kind if schema.has("properties") => {
                    let keys = other["properties"].as_object().expect("keys");
                    let of: Vec<String> = keys
                        .iter()
                        .map(|(key, value)| {
                            format!("`{{\"{key}\": ...}}` with {}", Schema(value).kind())
                        })
                        .collect();
                    drop(kind);
                    format!("{}: {}", of.join(", "), schema.text("description"))
                }
                kind => format!("{kind}: {}", schema.text("description")),
            };
            *page += &wrapped(&text, "- ", "  ");
            for value in
                other.get("properties").and_then(Value::as_object).into_iter().flat_map(Map::values)
            {
                Schema(value).keys(page, "  ");
            }
        }
    }
}

/// A page of a JSON Schema: the whole, then its parts by name.
fn page_of(title: &str, intro: &str, schema: &Value) -> String {
    let mut page = format!("# {title}\n\n{}", wrapped(intro, "", ""));
    Schema(schema).body(&mut page);
    let parts = schema.get("$defs").and_then(Value::as_object);
    for (name, part) in parts.into_iter().flatten() {
        let _ = write!(page, "\n## {name}\n");
        Schema(part).body(&mut page);
    }
    page
}

#[test]
fn scene_files_are_documented_by_their_schema() {
    let intro = "A scene file says what is looked at, what it is made of, from where, and at which temperature. It is \
                 JSON; keys that are not known are refused. This page is made from the schema that `soilsig schema \
                 scene` prints. [Own scenes](../guide/own_scenes.md) shows how to write one.";
    keep("scene.md", &page_of("Scene files", intro, &schema::of(Format::Scene)));
}

#[test]
fn results_are_documented_by_their_schemas_and_columns() {
    let intro = "Every run writes `run.json`: what was done, with what, and what came out, enough to do it again. \
                 This page is made from the schema that `soilsig schema run` prints. [Reading \
                 results](../guide/reading_results.md) explains the numbers, and [files of numbers](columns.md) the \
                 columns.";
    keep("results.md", &page_of("The record of a run", intro, &schema::of(Format::Run)));
    let mut page = "# Files of numbers\n\n".to_owned();
    page += &wrapped(
        "Columns of the CSV files, from the lists that the program writes them by. What is not known, and bands that \
         are masked, have empty fields.",
        "",
        "",
    );
    for (file, columns) in schema::column_lists() {
        let _ = write!(page, "\n## {file}\n\n");
        for (name, meaning) in columns {
            page += &wrapped(&format!("`{name}`: {meaning}"), "- ", "  ");
        }
    }
    keep("columns.md", &page);
}

#[test]
fn every_exit_status_is_documented() {
    let mut page = "# Exit statuses\n\n".to_owned();
    page += &wrapped("Scripts can tell failures apart by the exit status of the program.", "", "");
    page += "\n| status | name | meaning |\n|---|---|---|\n| 0 | Success | all that was asked for is done |\n";
    for (status, meaning) in Status::ALL {
        let _ = writeln!(page, "| {} | {status:?} | {meaning} |", status as u8);
    }
    keep("exit_statuses.md", &page);
}
