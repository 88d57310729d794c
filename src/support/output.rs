//! Writes files. A file is written under a temporary name, then renamed, so that an existing file
//! is always complete.

use std::collections::HashSet;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::support::error::{Failure, Status};

/// A file or folder could not be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct OutputError {
    /// The file or folder.
    pub path: PathBuf,
    /// What the system said.
    #[source]
    pub source: io::Error,
}

impl Failure for OutputError {
    fn status(&self) -> Status {
        Status::Files
    }

    fn hint(&self) -> Option<String> {
        Some(match self.source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                "the disk is full: free some space, or write elsewhere with --out".into()
            }
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                "write to a folder that is yours, with --out".into()
            }
            _ => return None,
        })
    }
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.to_owned();
    move |source| OutputError { path, source }
}

/// Checks before the work that a file can be written: makes its folder, refuses a path that is a
/// folder.
pub fn may_write(path: &Path) -> Result<(), OutputError> {
    if path.is_dir() {
        return Err(at(path)(io::ErrorKind::IsADirectory.into()));
    }
    path.parent().map_or(Ok(()), folder)
}

/// Refuses to overwrite what the same work reads, and to write two results to one file.
pub fn keeps(
    read: impl IntoIterator<Item = impl AsRef<Path>>,
    written: impl IntoIterator<Item = impl AsRef<Path>>,
) -> Result<(), OutputError> {
    // Follows links; the folder may not exist yet.
    let place = |path: &Path| {
        let in_folder = || Some(parent(path).canonicalize().ok()?.join(path.file_name()?));
        path.canonicalize().ok().or_else(in_folder).or_else(|| std::path::absolute(path).ok())
    };
    let mut taken: HashSet<PathBuf> =
        read.into_iter().filter_map(|path| place(path.as_ref())).collect();
    for path in written {
        if place(path.as_ref()).is_some_and(|place| !taken.insert(place)) {
            let problem = "it is an input, or another result has this name: give another name";
            return Err(at(path.as_ref())(io::Error::other(problem)));
        }
    }
    Ok(())
}

/// Makes a temporary folder, which is removed when it is dropped.
pub fn temporary() -> Result<tempfile::TempDir, OutputError> {
    tempfile::Builder::new().prefix("soilsig-").tempdir().map_err(at(&std::env::temp_dir()))
}

/// Makes a folder and its parents.
pub fn folder(path: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(path).map_err(at(path))
}

fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Writes one file through `fill`. It replaces an earlier file only when it is complete.
pub fn file(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let mut partial = Beside::new(path)?;
    let mut writer = BufWriter::new(partial.file.as_file_mut());
    fill(&mut writer).and_then(|()| writer.flush()).map_err(at(path))?;
    drop(writer);
    partial.done()
}

/// A file that is written in parts under a temporary name. [`Beside::done`] gives it its own name;
/// dropped before that, it leaves nothing.
pub struct Beside {
    path: PathBuf,
    file: tempfile::NamedTempFile,
}

impl Beside {
    /// Begins a file.
    pub fn new(path: &Path) -> Result<Self, OutputError> {
        use std::os::unix::fs::PermissionsExt;
        let parent = parent(path);
        folder(parent)?;
        // Results are `rw` for all, less the umask; temporary files would be private.
        let permissions = fs::Permissions::from_mode(0o666);
        let file = tempfile::Builder::new()
            .prefix(".soilsig-")
            .permissions(permissions)
            .tempfile_in(parent)
            .map_err(at(path))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Writes bytes at an offset.
    pub fn write_at(&self, bytes: &[u8], place: u64) -> Result<(), OutputError> {
        use std::os::unix::fs::FileExt;
        self.file.as_file().write_all_at(bytes, place).map_err(at(&self.path))
    }

    /// Another handle of the file, for a library that writes by itself.
    pub fn handle(&self) -> Result<fs::File, OutputError> {
        self.file.reopen().map_err(at(&self.path))
    }

    /// An error that names the file's final path.
    pub fn error(&self, source: io::Error) -> OutputError {
        at(&self.path)(source)
    }

    /// Gives the file its own name.
    pub fn done(self) -> Result<(), OutputError> {
        self.file.persist(&self.path).map(|_| ()).map_err(|e| at(&self.path)(e.error))
    }
}

/// Writes bytes as one file.
pub fn bytes(path: &Path, content: &[u8]) -> Result<(), OutputError> {
    file(path, |writer| writer.write_all(content))
}

/// Copies a file, completely or not at all.
pub fn copy(from: &Path, to: &Path) -> Result<(), OutputError> {
    file(to, |writer| io::copy(&mut fs::File::open(from)?, writer).map(|_| ()))
}

/// SHA-256 of a file's content.
pub fn sha256(path: &Path) -> Result<[u8; 32], OutputError> {
    Ok(Sha256::digest(fs::read(path).map_err(at(path))?).into())
}

/// The same in hexadecimal.
pub fn sha256_hex(path: &Path) -> Result<String, OutputError> {
    sha256(path).map(|sum| hex(&sum))
}

/// Names of the files in a folder, sorted.
pub fn list(folder: &Path) -> Result<Vec<String>, OutputError> {
    let names: io::Result<Vec<String>> = fs::read_dir(folder)
        .and_then(|entries| entries.map(|e| Ok(e?.file_name().to_string_lossy().into())).collect());
    let mut names = names.map_err(at(folder))?;
    names.sort_unstable();
    Ok(names)
}

/// Removes a file if it exists.
pub fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(at(path)(error)),
        _ => Ok(()),
    }
}

/// Bytes in hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_earlier_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("result.csv");
        bytes(&path, b"whole").expect("written");
        let full = file(&path, |writer| {
            writer.write_all(b"hal")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        let error = full.expect_err("the disk is full");
        assert!(error.to_string().contains("result.csv"));
        assert!(error.hint().expect("a hint").contains("--out"));
        assert_eq!(fs::read(&path).expect("still there"), b"whole");
        assert_eq!(list(folder.path()).expect("a folder"), ["result.csv"]);
    }

    #[test]
    fn inputs_are_not_overwritten_under_any_name() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let at = |name: &str| folder.path().join(name);
        bytes(&at("table.json"), b"").expect("written");
        std::os::unix::fs::symlink(at("table.json"), at("link")).expect("a link");
        let detour = folder.path().join(".").join("table.json");
        for written in [at("table.json"), at("link"), detour] {
            let error = keeps([at("table.json")], [written]).expect_err("it is read");
            assert!(error.to_string().contains("another name"), "{error}");
        }
        keeps([at("table.json")], [at("a.csv"), at("b.csv")]).expect("all differ");
        for twice in ["a.csv", "not/yet/there.csv"] {
            assert!(keeps([""; 0], [at(twice), at(twice)]).is_err());
        }
        keeps(["quartz_fine"], ["out.csv"]).expect("a name is no file");
    }

    #[test]
    fn results_have_the_permissions_of_the_umask() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        bytes(&ours, b"").expect("written");
        fs::write(&plain, b"").expect("written");
        let mode = |path| fs::metadata(path).expect("a file").permissions().mode();
        assert_eq!(mode(ours), mode(plain));
    }
}
