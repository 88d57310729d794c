//! Copies of the files that a run read: with them a result can be made again anywhere.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use crate::support::output;

/// Folder of the copies below that of a result.
pub const INPUTS: &str = "inputs";

/// A path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

/// The folder that all files have in common.
fn common(files: &[PathBuf]) -> PathBuf {
    let mut folders = files.iter().filter_map(|file| file.parent());
    let Some(first) = folders.next() else { return PathBuf::new() };
    let in_common = |a: PathBuf, b: &Path| {
        let parts = a.components().zip(b.components()).take_while(|(a, b)| a == b);
        parts.map(|(part, _)| part).collect()
    };
    folders.fold(first.to_owned(), in_common)
}

/// The path of each file's copy below the folder of the result. They lie to each other as the files
/// do, so that a scene names them as before.
pub fn places<'a>(files: impl Iterator<Item = &'a String>) -> BTreeMap<&'a str, String> {
    let files: Vec<&String> = files.collect();
    let plain: Vec<PathBuf> = files.iter().map(|file| plain(Path::new(file))).collect();
    let common = common(&plain);
    let place = |path: &PathBuf| {
        let below = path.strip_prefix(&common).unwrap_or(path);
        format!("{INPUTS}/{}", below.display())
    };
    files.into_iter().map(String::as_str).zip(plain.iter().map(place)).collect()
}

/// Where a file or folder that a run was told of lies among the copies.
pub fn copied(path: &Path, inputs: &BTreeMap<String, String>, folder: &Path) -> PathBuf {
    let all: Vec<PathBuf> = inputs.keys().map(|file| plain(Path::new(file))).collect();
    let path = plain(path);
    let below = path.strip_prefix(common(&all)).map(Path::to_owned);
    folder.join(INPUTS).join(below.unwrap_or(path))
}

/// Whether all inputs of a record have copies that are as recorded.
pub fn are_whole(inputs: &BTreeMap<String, String>, folder: &Path) -> bool {
    let is_whole = |(file, place): (&str, String)| {
        output::within(folder, &place)
            .and_then(|path| output::sha256_hex(&path))
            .is_ok_and(|sum| Some(&sum) == inputs.get(file))
    };
    !inputs.is_empty() && places(inputs.keys()).into_iter().all(is_whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_lie_to_each_other_as_the_files_do() {
        let files = ["/a/scenes/s.json", "/a/scenes/../spectra/x.csv", "/a/scenes/b/y.csv"];
        let files: Vec<String> = files.map(str::to_owned).into();
        let of = places(files.iter());
        let found: Vec<&str> = files.iter().map(|file| &*of[&**file]).collect();
        assert_eq!(
            found,
            ["inputs/scenes/s.json", "inputs/spectra/x.csv", "inputs/scenes/b/y.csv"]
        );
        let inputs = files.iter().map(|file| (file.clone(), String::new())).collect();
        let grains = copied(Path::new("/a/scenes/b"), &inputs, Path::new("/out"));
        assert_eq!(grains, Path::new("/out/inputs/scenes/b"));
        let one = ["/a/s.json".to_owned()];
        assert_eq!(places(one.iter())["/a/s.json"], "inputs/s.json");
    }
}
