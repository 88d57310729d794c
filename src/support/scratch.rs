//! Temporary files and folders. They are locked while they are in use, so that those of a run that
//! was killed can be told, and are removed by the next run.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg, OFlag};
use tempfile::{NamedTempFile, TempDir};

use crate::support::error::{Failure, Status};
use crate::support::output::OutputError;

/// Begin of the names of temporary files and folders beside results.
pub(super) const BESIDE: &str = ".soilsig-";
/// Begin of the names of folders among the system's temporary ones.
const TEMPORARY: &str = "soilsig-run-";
/// Length of the random end of a name.
const RANDOM: usize = 12;

/// How often a file is made anew that another run cleared up before it was locked.
const TRIES: usize = 100;

/// Those of this process, to be removed if it ends at once.
static IN_USE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// There is no folder for temporary files.
#[derive(Debug, thiserror::Error)]
#[error("the folder for temporary files: {0}")]
pub struct ScratchError(pub OutputError);

impl Failure for ScratchError {
    fn status(&self) -> Status {
        Status::Files
    }

    fn hint(&self) -> Option<String> {
        let folder = std::env::temp_dir();
        Some(match self.0.source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => format!(
                "the disk of {} is full: free some space, or name another folder in TMPDIR",
                folder.display()
            ),
            _ => format!(
                "TMPDIR names the folder, now {}: make it, or name one that is yours",
                folder.display()
            ),
        })
    }
}

/// Whether a lock could be taken.
pub(super) enum Taken {
    /// Nobody else has it. It ends with this value or the process.
    Now(Flock<File>),
    /// Another process has it.
    ByAnother,
    /// This file system has no locks.
    NoLocks,
}

/// Takes the lock of a file or folder without waiting.
pub(super) fn take(file: File) -> Taken {
    match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
        Ok(lock) => Taken::Now(lock),
        Err((_, Errno::EWOULDBLOCK)) => Taken::ByAnother,
        Err(_) => Taken::NoLocks,
    }
}

/// Opens a file or folder to lock it; no link, and without waiting for the other end of a pipe.
pub(super) fn opened(path: &Path) -> io::Result<File> {
    let flags = OFlag::O_NOFOLLOW | OFlag::O_NONBLOCK;
    OpenOptions::new().read(true).custom_flags(flags.bits()).open(path)
}

fn in_use<T>(change: impl FnOnce(&mut BTreeSet<PathBuf>) -> T) -> T {
    change(&mut IN_USE.lock().unwrap_or_else(PoisonError::into_inner))
}

/// What the system said, without the random name that the library adds.
fn plain(error: io::Error) -> io::Error {
    let inner = error.get_ref().and_then(|named| named.source());
    let system = inner.and_then(|inner| inner.downcast_ref::<io::Error>());
    match system.and_then(io::Error::raw_os_error) {
        Some(code) => io::Error::from_raw_os_error(code),
        None => error,
    }
}

/// A path among those in use, until it is dropped.
struct Noted(PathBuf);

impl Noted {
    fn new(path: &Path) -> Self {
        in_use(|all| all.insert(path.to_owned()));
        Self(path.to_owned())
    }
}

impl Drop for Noted {
    fn drop(&mut self) {
        in_use(|all| all.remove(&self.0));
    }
}

/// Held while the files of a result are put into their places.
static WHOLE: Mutex<()> = Mutex::new(());

/// Until this value is dropped the program does not end at once.
pub(crate) fn whole() -> MutexGuard<'static, ()> {
    WHOLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what this process has in use: it is about to end at once.
pub fn remove_all_in_use() {
    let _whole = whole();
    for path in in_use(std::mem::take) {
        remove(&path);
    }
}

/// Removes a file, or a folder with all that is in it. No link is followed.
fn remove(path: &Path) {
    let is_folder = fs::symlink_metadata(path).is_ok_and(|now| now.is_dir());
    let _ = if is_folder { fs::remove_dir_all(path) } else { fs::remove_file(path) };
}

/// Whether it is still the file that its path names: another process may have removed it before it
/// was locked.
fn is_still(file: &File, path: &Path) -> bool {
    let of = |now: io::Result<fs::Metadata>| now.map(|now| (now.dev(), now.ino())).ok();
    let (by_file, by_path) = (of(file.metadata()), of(fs::symlink_metadata(path)));
    by_file.is_some() && by_file == by_path
}

/// Removes what killed processes left in a folder under such names: it is the user's own, and
/// nobody has its lock.
pub(super) fn clear(folder: &Path, prefix: &str) {
    let me = nix::unistd::geteuid().as_raw();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let random = name.to_str().and_then(|name| name.strip_prefix(prefix));
        let is_ours = |random: &str| {
            random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
        };
        let path = entry.path();
        if !random.is_some_and(is_ours)
            || !fs::symlink_metadata(&path).is_ok_and(|now| now.uid() == me)
        {
            continue;
        }
        if let Ok(Taken::Now(lock)) = opened(&path).map(take)
            && is_still(&lock, &path)
        {
            remove(&path);
        }
    }
}

/// Removes what killed runs left among the system's temporary folders.
pub fn clear_temporary() {
    clear(&std::env::temp_dir(), TEMPORARY);
}

/// A hidden folder inside that of a result.
pub fn beside(folder: &Path) -> Result<Scratch, OutputError> {
    Scratch::within(folder, BESIDE)
        .map_err(|source| OutputError { path: folder.to_owned(), source })
}

/// A folder of this user alone, which is removed with this value.
pub struct Scratch {
    folder: TempDir,
    _noted: Noted,
    _lock: Option<Flock<File>>,
}

impl Scratch {
    /// A folder among the system's temporary ones.
    pub fn temporary() -> Result<Self, ScratchError> {
        let place = std::env::temp_dir();
        let place = std::path::absolute(&place).unwrap_or(place);
        Self::within(&place, TEMPORARY)
            .map_err(|source| ScratchError(OutputError { path: place, source }))
    }

    /// A folder inside another, whose name begins so.
    pub(crate) fn within(place: &Path, prefix: &str) -> io::Result<Self> {
        clear(place, prefix);
        for _ in 0..TRIES {
            let folder = tempfile::Builder::new()
                .prefix(prefix)
                .rand_bytes(RANDOM)
                .permissions(Permissions::from_mode(0o700))
                .tempdir_in(place)
                .map_err(plain)?;
            let noted = Noted::new(folder.path());
            let lock = opened(folder.path()).map(take);
            match lock {
                Ok(Taken::Now(lock)) if is_still(&lock, folder.path()) => {
                    return Ok(Self { folder, _noted: noted, _lock: Some(lock) });
                }
                Ok(Taken::NoLocks) => return Ok(Self { folder, _noted: noted, _lock: None }),
                // Another run is clearing up: it had the lock first.
                Ok(Taken::Now(_) | Taken::ByAnother) => {}
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::other("another run removes temporary folders as they are made"))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// A file beside its place.
pub(super) struct ScratchFile {
    pub(super) file: NamedTempFile,
    _noted: Noted,
    _lock: Option<Flock<File>>,
}

impl ScratchFile {
    /// An empty file, which its owner alone may read and write unless `mode` says otherwise.
    pub(super) fn within(folder: &Path, mode: u32) -> io::Result<Self> {
        clear(folder, BESIDE);
        for _ in 0..TRIES {
            let file = tempfile::Builder::new()
                .prefix(BESIDE)
                .rand_bytes(RANDOM)
                .permissions(Permissions::from_mode(mode))
                .tempfile_in(folder)
                .map_err(plain)?;
            let noted = Noted::new(file.path());
            match take(file.as_file().try_clone()?) {
                Taken::Now(lock) if is_still(&lock, file.path()) => {
                    return Ok(Self { file, _noted: noted, _lock: Some(lock) });
                }
                Taken::NoLocks => return Ok(Self { file, _noted: noted, _lock: None }),
                Taken::Now(_) | Taken::ByAnother => {}
            }
        }
        Err(io::Error::other("another run removes temporary files as they are made"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder").flatten();
        let mut all: Vec<String> =
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn what_a_killed_run_left_is_cleared_and_nothing_else() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let at = |name: &str| all.path().join(name);
        fs::create_dir(at(".soilsig-abcdefABCDEF")).expect("made");
        fs::write(at(".soilsig-abcdefABCDEF/part"), "").expect("written");
        fs::write(at(".soilsig-012345678901"), "").expect("written");
        // Names that are no such, a link, and one in use.
        fs::write(at(".soilsig-mine"), "").expect("written");
        fs::write(at("mine"), "").expect("written");
        std::os::unix::fs::symlink(at("mine"), at(".soilsig-linklinklink")).expect("a link");
        let used = ScratchFile::within(all.path(), 0o600).expect("made");
        let used_folder = Scratch::within(all.path(), BESIDE).expect("made");
        clear(all.path(), BESIDE);
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let mut kept = vec![
            name(used.file.path()),
            name(used_folder.path()),
            ".soilsig-linklinklink".into(),
            ".soilsig-mine".into(),
            "mine".into(),
        ];
        kept.sort_unstable();
        assert_eq!(names(all.path()), kept);
        drop((used, used_folder));
        assert_eq!(names(all.path()).len(), 3);
    }

    #[test]
    fn temporary_folders_are_of_their_owner_alone() {
        let scratch = Scratch::temporary().expect("made");
        let mode = fs::metadata(scratch.path()).expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o700);
    }
}
