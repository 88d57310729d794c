//! Writes files. A file is written under a temporary name, then renamed, so that an existing file
//! is always complete.

use std::collections::HashSet;
use std::fs;
use std::io::{self, BufWriter, Read, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::support::error::{Failure, Status};
use crate::support::place::{Place, is_own_descriptor, parent};
use crate::support::scratch::ScratchFile;

pub use crate::support::place::{is_plain, within};

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
            io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory => {
                "what stands there is no folder: name another with --out".into()
            }
            io::ErrorKind::IsADirectory => "name a file in this folder with --out".into(),
            _ => return None,
        })
    }
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.to_owned();
    move |source| OutputError { path, source }
}

/// Checks before the work that a file can be written: makes its folder, and tries to write there.
pub fn may_write(path: &Path) -> Result<(), OutputError> {
    match Place::of(path).map_err(at(path))? {
        Place::File(..) => Beside::new(path).map(|_| ()),
        Place::Stream(_) => Ok(()),
    }
}

/// The path of another file in the folder of one that the user names. A link there is not followed:
/// the user did not name it.
pub fn sibling(path: &Path, name: &str) -> Result<PathBuf, OutputError> {
    within(parent(path), name)
}

/// Whether a path is that of a file, or of none yet, and not of a device or pipe.
pub fn is_file(path: &Path) -> bool {
    matches!(Place::of(path), Ok(Place::File(..)))
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

/// Makes a folder and its parents.
pub fn folder(path: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(path).map_err(at(path))
}

/// Writes one file through `fill`. It replaces an earlier file only when it is complete.
pub fn file(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let mut partial = Beside::new(path)?;
    let mut writer = BufWriter::new(partial.scratch.file.as_file_mut());
    fill(&mut writer).and_then(|()| writer.flush()).map_err(at(path))?;
    drop(writer);
    partial.done()
}

/// A file that is written in parts under a temporary name. [`Beside::done`] gives it its own name;
/// dropped before that, it leaves nothing. What is no file, such as a pipe, is written to then.
pub struct Beside {
    path: PathBuf,
    place: Place,
    scratch: ScratchFile,
}

impl Beside {
    /// Begins a file. Links to it are followed.
    pub fn new(path: &Path) -> Result<Self, OutputError> {
        let place = Place::of(path).map_err(at(path))?;
        let made = match &place {
            Place::File(file, _) => {
                folder(parent(file))?;
                // Results are `rw` for all, less the umask; temporary files would be private.
                ScratchFile::within(parent(file), 0o666)
            }
            Place::Stream(_) => ScratchFile::within(&std::env::temp_dir(), 0o600),
        };
        Ok(Self { path: path.to_owned(), place, scratch: made.map_err(at(path))? })
    }

    /// Writes bytes at an offset.
    pub fn write_at(&self, bytes: &[u8], place: u64) -> Result<(), OutputError> {
        use std::os::unix::fs::FileExt;
        self.scratch.file.as_file().write_all_at(bytes, place).map_err(at(&self.path))
    }

    /// Another handle of the file, for a library that writes by itself.
    pub fn handle(&self) -> Result<fs::File, OutputError> {
        self.scratch.file.reopen().map_err(at(&self.path))
    }

    /// An error that names the file's final path.
    pub fn error(&self, source: io::Error) -> OutputError {
        at(&self.path)(source)
    }

    /// Gives the file its own name, and the mode of the one that it replaces.
    pub fn done(self) -> Result<(), OutputError> {
        let Self { path, place, scratch } = self;
        let done = match place {
            Place::Stream(to) => copy_into(scratch.file.path(), &to),
            Place::File(to, earlier) => (|| {
                if let Some(earlier) = earlier {
                    keep_mode(scratch.file.as_file(), &earlier)?;
                }
                scratch.file.as_file().sync_all()?;
                scratch.file.persist(&to)?;
                sync_folder(parent(&to))
            })(),
        };
        done.map_err(at(&path))
    }
}

/// Writes a file into a device, a pipe or an open descriptor.
fn copy_into(from: &Path, to: &Path) -> io::Result<()> {
    let mut from = fs::File::open(from)?;
    // The program's own streams go on where they are.
    let fd =
        if is_own_descriptor(to) { to.file_name().and_then(|name| name.to_str()) } else { None };
    let own = match fd {
        Some("1") => Some(io::stdout().as_fd().try_clone_to_owned()?),
        Some("2") => Some(io::stderr().as_fd().try_clone_to_owned()?),
        _ => None,
    };
    let mut into = match own {
        Some(own) => fs::File::from(own),
        None => fs::File::options().write(true).open(to)?,
    };
    io::copy(&mut from, &mut into)?;
    into.flush()
}

/// Gives a new file the mode and, where this is allowed, the owner of the one that it replaces.
pub(crate) fn keep_mode(file: &fs::File, earlier: &fs::Metadata) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let now = file.metadata()?;
    if (now.uid(), now.gid()) != (earlier.uid(), earlier.gid()) {
        let _ = std::os::unix::fs::fchown(file, Some(earlier.uid()), Some(earlier.gid()));
    }
    file.set_permissions(earlier.permissions())
}

/// Makes the names in a folder last. Not every file system can do this for folders.
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    match fs::File::open(folder)?.sync_all() {
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
        done => done,
    }
}

/// Makes the files in a folder and their names last.
pub(crate) fn sync_all_in(folder: &Path) -> Result<(), OutputError> {
    for name in list(folder)? {
        let path = folder.join(name);
        let sync = || if path.is_dir() { Ok(()) } else { fs::File::open(&path)?.sync_all() };
        sync().map_err(at(&path))?;
    }
    sync_folder(folder).map_err(at(folder))
}

/// Writes a file into a temporary folder: it need not outlive the run.
pub fn scratch(path: &Path, content: impl AsRef<[u8]>) -> Result<(), OutputError> {
    folder(parent(path))?;
    fs::write(path, content).map_err(at(path))
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
    let mut sum = Sha256::new();
    let mut read = || {
        let mut file = fs::File::open(path)?;
        let mut part = vec![0; 1 << 16];
        loop {
            match file.read(&mut part)? {
                0 => return Ok(()),
                count => sum.update(&part[..count]),
            }
        }
    };
    read().map_err(at(path))?;
    Ok(sum.finalize().into())
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
