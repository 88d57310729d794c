//! ENVI files: numbers in a data file, described by the header (.hdr) beside it.

mod read;
mod write;

use std::path::{Path, PathBuf};

pub(crate) use read::Header;
pub(crate) use write::{Contents, Image, Kind, write};

/// Data and header of a file that is named by either. `endings` are those that data may have.
pub(crate) fn pair(path: &Path, endings: &[&str]) -> [PathBuf; 2] {
    if ending(path) == "hdr" {
        let bare = path.with_extension("");
        if endings.contains(&ending(&bare).as_str()) {
            return [bare, path.to_owned()];
        }
        let candidates = endings.iter().map(|ending| path.with_extension(ending));
        let data = candidates.chain([bare]).find(|data| data.exists());
        return [data.unwrap_or_else(|| path.with_extension(endings[0])), path.to_owned()];
    }
    let mut appended = path.as_os_str().to_owned();
    appended.push(".hdr");
    let appended = PathBuf::from(appended);
    let header = if appended.exists() { appended } else { path.with_extension("hdr") };
    [path.to_owned(), header]
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}
