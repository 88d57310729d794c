//! One run at a time writes into a folder.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use nix::fcntl::{Flock, OFlag};

use crate::support::error::{Failure, Status};
use crate::support::output::{self, OutputError};
use crate::support::scratch::{Taken, take};

/// The file that is locked; it holds the process id.
const NAME: &str = ".soilsig-lock";

/// A folder cannot be had for this run alone.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another run writes into it.
    #[error("{}: another run writes into this folder (process {process})", folder.display())]
    InUse {
        /// The folder.
        folder: PathBuf,
        /// The process id of the other run.
        process: String,
    },
    /// It cannot be written to.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl Failure for LockError {
    fn status(&self) -> Status {
        Status::Files
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::InUse { .. } => Some("wait until it has ended, or name another --out".into()),
            Self::Output(error) => error.hint(),
        }
    }
}

/// A folder that this run alone writes into, until this value is dropped or the process ends.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    /// `None` where the file system has no locks.
    held: Option<Flock<File>>,
}

impl Lock {
    /// Makes a folder and takes it.
    ///
    /// # Errors
    /// Another run has it, or it cannot be written to.
    pub fn of(folder: &Path) -> Result<Self, LockError> {
        output::folder(folder)?;
        let path = folder.join(NAME);
        let at = |source| OutputError { path: folder.to_owned(), source };
        loop {
            let flags = OFlag::O_NOFOLLOW | OFlag::O_NONBLOCK;
            let file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .mode(0o644)
                .custom_flags(flags.bits())
                .open(&path)
                .map_err(at)?;
            match take(file) {
                Taken::ByAnother => {
                    let process = owner(&path);
                    return Err(LockError::InUse { folder: folder.to_owned(), process });
                }
                Taken::NoLocks => return Ok(Self { path, held: None }),
                Taken::Now(held) => {
                    // The run before may have removed it after it was opened here.
                    if !is_there(&held, &path) {
                        continue;
                    }
                    // If the id cannot be written, the file goes with this value.
                    let mut lock = Self { path, held: Some(held) };
                    lock.held.as_mut().map_or(Ok(()), |file| write_id(file)).map_err(at)?;
                    return Ok(lock);
                }
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if self.held.is_some() {
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn is_there(file: &File, path: &Path) -> bool {
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(file), Ok(there)) => (file.dev(), file.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}

fn write_id(file: &mut File) -> io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    writeln!(file, "{}", std::process::id())
}

/// The process that has the lock; it writes its id just after it took it.
fn owner(path: &Path) -> String {
    for _ in 0..20 {
        let mut text = String::new();
        let read = File::open(path).and_then(|file| file.take(20).read_to_string(&mut text));
        if read.is_ok() && text.trim().parse::<u32>().is_ok() {
            return text.trim().to_owned();
        }
        thread::sleep(Duration::from_millis(5));
    }
    "unknown".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_locked_once_and_free_again_after() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let folder = all.path().join("out");
        let lock = Lock::of(&folder).expect("free");
        std::os::unix::fs::symlink(&folder, all.path().join("link")).expect("a link");
        for name in ["out", "link", "out/../out"] {
            let error = Lock::of(&all.path().join(name)).expect_err("it is taken");
            let id = std::process::id().to_string();
            assert!(error.to_string().contains(&id), "{error}");
        }
        drop(lock);
        assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 0);
        // What a killed run left does not block.
        fs::write(folder.join(NAME), "1\n").expect("written");
        Lock::of(&folder).expect("nobody holds it");
    }

    #[test]
    fn a_link_in_the_place_of_the_lock_is_not_written_through() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let mine = all.path().join("mine");
        fs::write(&mine, "keep").expect("written");
        std::os::unix::fs::symlink(&mine, all.path().join(NAME)).expect("a link");
        Lock::of(all.path()).expect_err("a link");
        assert_eq!(fs::read(&mine).expect("there"), b"keep");
    }
}
