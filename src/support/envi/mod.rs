//! ENVI files: numbers in a data file, described by the header (.hdr) beside it.

mod header;
mod read;
mod write;

use std::fs;
use std::path::{Path, PathBuf};

pub(crate) use header::Header;
pub(crate) use write::{Contents, Image, Kind, band_names, write};

/// Endings of files that may lie beside a header and are no data.
const NO_DATA: [&str; 9] = ["hdr", "txt", "png", "jpg", "csv", "json", "xml", "enp", "sta"];

/// Data and header of a file that is named by either. `endings` are those that data may have; they
/// may be in any case. A header without such data belongs to the one file of its name that there
/// is.
pub(crate) fn pair(path: &Path, endings: &[&str]) -> [PathBuf; 2] {
    if ending(path) == "hdr" {
        let bare = path.with_extension("");
        if endings.contains(&ending(&bare).as_str()) {
            return [there(&bare).unwrap_or(bare), path.to_owned()];
        }
        let candidates = endings.iter().map(|ending| path.with_extension(ending));
        let data = candidates.chain([bare.clone()]).find_map(|data| there(&data));
        let data = data.or_else(|| only_one(&bare));
        return [data.unwrap_or_else(|| path.with_extension(endings[0])), path.to_owned()];
    }
    let header = headers(path).into_iter().next();
    [path.to_owned(), header.unwrap_or_else(|| path.with_extension("hdr"))]
}

/// The headers that there are of a data file.
fn headers(data: &Path) -> Vec<PathBuf> {
    let mut appended = data.as_os_str().to_owned();
    appended.push(".hdr");
    let names = [PathBuf::from(appended), data.with_extension("hdr")];
    let mut found: Vec<PathBuf> = names.iter().filter_map(|header| there(header)).collect();
    found.dedup();
    found
}

/// The file of that path, in this case or another.
fn there(path: &Path) -> Option<PathBuf> {
    if path.is_file() {
        return Some(path.to_owned());
    }
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    siblings(path).into_iter().find(|other| {
        other.file_name().is_some_and(|of| of.to_string_lossy().to_lowercase() == name)
            && other.is_file()
    })
}

/// The one data file of that name, whatever its ending.
fn only_one(bare: &Path) -> Option<PathBuf> {
    let stem = bare.file_name()?;
    let is_data = |path: &PathBuf| {
        path.file_stem() == Some(stem) && path.is_file() && !NO_DATA.contains(&&*ending(path))
    };
    let mut found = siblings(bare).into_iter().filter(is_data);
    found.next().filter(|_| found.next().is_none())
}

/// The files of a path's folder, in order of their names.
fn siblings(path: &Path) -> Vec<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let entries = fs::read_dir(folder.unwrap_or(Path::new("."))).into_iter().flatten().flatten();
    let named = |entry: fs::DirEntry| match folder {
        Some(_) => entry.path(),
        None => PathBuf::from(entry.file_name()),
    };
    let mut paths: Vec<PathBuf> = entries.map(named).collect();
    paths.sort_unstable();
    paths
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}
