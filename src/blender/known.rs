//! Remembers Blenders between runs: to ask one for its versions takes a second.
//!
//! The list says what a Blender is, never which program to start: that is the one that was found.

use std::collections::BTreeMap;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{fs, io};

use serde::{Deserialize, Serialize};

use super::Blender;
use crate::support::{output, trust};

/// For each path where a Blender was found: the files that it depends on, and its versions.
type Known = BTreeMap<PathBuf, (Vec<Stamp>, Blender)>;

/// The state of a file, to tell whether it has changed.
#[derive(PartialEq, Serialize, Deserialize)]
struct Stamp {
    path: PathBuf,
    /// The file that the path leads to, through links.
    file: PathBuf,
    size: u64,
    modified: SystemTime,
}

impl Stamp {
    fn of(path: &Path) -> io::Result<Self> {
        let file = path.canonicalize()?;
        let metadata = fs::metadata(&file)?;
        let (size, modified) = (metadata.len(), metadata.modified()?);
        Ok(Self { path: path.to_owned(), file, size, modified })
    }

    fn holds(&self) -> bool {
        Self::of(&self.path).is_ok_and(|now| now == *self)
    }
}

fn list(cache: &Path) -> PathBuf {
    cache.join("blenders.json")
}

/// A list that is missing or damaged counts as empty.
fn read(cache: &Path) -> Known {
    let text = fs::read(list(cache)).unwrap_or_default();
    serde_json::from_slice(&text).unwrap_or_default()
}

/// The Blender that was found at a path, if none of its files has changed. A folder that others may
/// write to is not asked.
pub(super) fn recall(cache: &Path, found_at: &Path) -> Option<Blender> {
    if !trust::doubt(cache).is_ok_and(|doubt| doubt.is_none()) {
        return None;
    }
    let (stamps, blender) = read(cache).remove(found_at)?;
    let is_its_own =
        blender.path == found_at && stamps.first().is_some_and(|stamp| stamp.path == found_at);
    (is_its_own && stamps.iter().all(Stamp::holds)).then_some(blender)
}

/// Remembers a Blender by the path where it was found and the further files that it depends on.
/// Without an entry the next run asks again, so a failure is harmless. A script
/// in the place of a Python is asked each time which Python it starts.
pub(super) fn remember(cache: &Path, found_at: &Path, files: &[PathBuf], blender: &Blender) {
    if blender.path != found_at {
        return;
    }
    let all = std::iter::once(found_at).chain(files.iter().map(PathBuf::as_path));
    let Ok(stamps) = all.map(Stamp::of).collect() else { return };
    let mut known = read(cache);
    known.insert(found_at.to_owned(), (stamps, blender.clone()));
    let is_ours = || {
        let mut builder = fs::DirBuilder::new();
        builder.recursive(true).mode(0o700).create(cache).is_ok()
            && trust::doubt(cache).is_ok_and(|doubt| doubt.is_none())
    };
    if let (Ok(text), true) = (serde_json::to_vec_pretty(&known), is_ours()) {
        let _ = output::bytes(&list(cache), &text);
    }
}
