//! Blenders met before, so that a second run need not start one to learn what it is.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};

use super::Blender;
use crate::support::output::{self, OutputError};

/// What is remembered of a Blender, good as long as its files are unchanged.
#[derive(Serialize, Deserialize)]
struct Entry {
    /// Where it was found.
    found_at: PathBuf,
    /// The files that make it what it is; the one at `found_at` first.
    stamps: Vec<Stamp>,
    blender: Blender,
}

/// What tells that a file is still the same, at the price of one `stat`.
#[derive(PartialEq, Eq, Serialize, Deserialize)]
struct Stamp {
    path: PathBuf,
    size: u64,
    modified_ns: u64,
}

impl Stamp {
    /// The stamp of the file that a path leads to now.
    fn of(path: &Path) -> Option<Self> {
        let path = path.canonicalize().ok()?;
        let file = fs::metadata(&path).ok()?;
        let modified = file.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        let modified_ns = u64::try_from(modified.as_nanos()).ok()?;
        Some(Self { path, size: file.len(), modified_ns })
    }
}

impl Entry {
    fn holds(&self) -> bool {
        let holds = |stamp: &Stamp| Stamp::of(&stamp.path).as_ref() == Some(stamp);
        // A link at `found_at` may lead elsewhere by now.
        self.stamps.first() == Stamp::of(&self.found_at).as_ref() && self.stamps.iter().all(holds)
    }
}

fn list(cache: &Path) -> PathBuf {
    cache.join("blenders.json")
}

/// A list that is absent, damaged or of another format is an empty one.
fn read(cache: &Path) -> Vec<Entry> {
    let text = fs::read(list(cache)).unwrap_or_default();
    serde_json::from_slice(&text).unwrap_or_default()
}

/// The Blender at `found_at`, if it is known and unchanged.
pub(super) fn recall(cache: &Path, found_at: &Path) -> Option<Blender> {
    let entry = read(cache).into_iter().find(|entry| entry.found_at == found_at)?;
    entry.holds().then_some(entry.blender)
}

/// Remembers a Blender by the place where it was found and the other files that it is made of.
pub(super) fn remember(
    cache: &Path,
    found_at: &Path,
    files: &[&Path],
    blender: &Blender,
) -> Result<(), OutputError> {
    let all = [found_at].into_iter().chain(files.iter().copied());
    // A file without a time of change cannot be told from its successor.
    let Some(stamps) = all.map(Stamp::of).collect() else { return Ok(()) };
    let mut entries = read(cache);
    entries.retain(|entry| entry.found_at != found_at);
    entries.push(Entry { found_at: found_at.to_owned(), stamps, blender: blender.clone() });
    output::file(&list(cache), |writer| Ok(serde_json::to_writer_pretty(writer, &entries)?))
}
