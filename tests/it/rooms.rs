//! The rooms of the source import only from lower floors; docs/architecture.md lists the floors.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The floor of each room, by the table in the document.
fn floors() -> BTreeMap<String, u32> {
    let text = fs::read_to_string(root().join("docs/architecture.md")).expect("the document");
    text.lines()
        .filter_map(|line| {
            let mut cells = line.strip_prefix("| ")?.split(" | ");
            let floor = cells.next()?.parse().ok()?;
            let room = cells.next()?.strip_prefix('`')?.strip_suffix('`')?;
            Some((room.to_owned(), floor))
        })
        .collect()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// Rooms that a line of source names after `crate::`, in comments aside.
fn named(line: &str) -> Vec<String> {
    let code = line.split("//").next().unwrap_or_default();
    let of = |part: &str| {
        let end = part.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(part.len());
        part[..end].to_owned()
    };
    code.split("crate::").skip(1).map(of).collect()
}

/// What of a file's imports does not run downward.
fn upward(file: &str, text: &str, floors: &BTreeMap<String, u32>) -> Vec<String> {
    let room = file.split('/').next().expect("a room");
    let of = |name: &str| floors.get(name).copied();
    let own = of(room).unwrap_or_else(|| panic!("docs/architecture.md names no floor of {room}"));
    let wrong = |name: &String| name != room && of(name).is_some_and(|floor| floor >= own);
    let lines = text.lines().enumerate();
    lines
        .flat_map(|(i, line)| {
            let names = named(line).into_iter().filter(wrong);
            names.map(move |name| format!("src/{file}:{}: {room} imports {name}", i + 1))
        })
        .collect()
}

#[test]
fn no_room_imports_from_a_higher_floor() {
    let floors = floors();
    let source = root().join("src");
    let mut files = Vec::new();
    sources(&source, &mut files);
    let mut wrong = Vec::new();
    for path in files.iter().filter(|path| path.parent() != Some(&source)) {
        let text = fs::read_to_string(path).expect("source");
        assert!(!text.contains("use crate::{"), "{}: one `use` a room", path.display());
        let file = path.strip_prefix(&source).expect("below it").to_string_lossy().into_owned();
        wrong.extend(upward(&file, &text, &floors));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let rooms = fs::read_dir(&source)
        .expect("a folder")
        .filter(|entry| entry.as_ref().expect("an entry").path().is_dir());
    assert_eq!(rooms.count(), floors.len(), "each room has a floor, and no other");
}

#[test]
fn an_import_that_runs_upward_is_found() {
    let floors = floors();
    let text = "use crate::support::error;\n// crate::cli\nfn f() { crate::tracer::g() }\n";
    let found = upward("table/mod.rs", text, &floors);
    assert_eq!(found, ["src/table/mod.rs:3: table imports tracer"]);
}

/// Messages and comments send their readers to documents.
#[test]
fn every_document_that_the_source_names_is_there() {
    let mut files = Vec::new();
    for folder in ["src", "tests/it", "benches", "examples"] {
        sources(&root().join(folder), &mut files);
    }
    let mut missing = Vec::new();
    for path in files {
        let text = fs::read_to_string(&path).expect("source");
        for part in text.split("docs/").skip(1) {
            let end = part.find(|c: char| !(c.is_alphanumeric() || "_/.".contains(c)));
            let name = part[..end.unwrap_or(part.len())].trim_end_matches('.');
            let is_page = Path::new(name).extension().is_some_and(|ending| ending == "md");
            if is_page && !root().join("docs").join(name).is_file() {
                missing.push(format!("{}: docs/{name}", path.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}
