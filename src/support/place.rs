//! Where a file is written: links of the user are followed, those inside a result's folder are not.

use std::fs::{self, Metadata};
use std::io;
use std::os::unix::fs::FileTypeExt;
use std::path::{Component, Path, PathBuf};

use crate::support::output::OutputError;

/// Most links on the way to a file, as in the kernel.
const MOST_LINKS: usize = 40;

/// Where bytes for a path go.
#[derive(Debug)]
pub(super) enum Place {
    /// A file that is replaced when the new one is complete, and what it is now.
    File(PathBuf, Option<Metadata>),
    /// A device, pipe or open descriptor: it is written to.
    Stream(PathBuf),
}

impl Place {
    /// The place that a path of the user leads to.
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        let mut at = path.to_owned();
        for _ in 0..MOST_LINKS {
            let now = match fs::symlink_metadata(&at) {
                Ok(now) => now,
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    return Ok(Self::File(at, None));
                }
                Err(error) => return Err(error),
            };
            let kind = now.file_type();
            if kind.is_symlink() && is_descriptor(&at) {
                return Ok(Self::Stream(at));
            } else if kind.is_symlink() {
                at = parent(&at).join(fs::read_link(&at)?);
            } else if kind.is_file() {
                return Ok(Self::File(at, Some(now)));
            } else if kind.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            } else if kind.is_block_device() {
                return Err(io::Error::other("it is a disk, and would be overwritten"));
            } else {
                return Ok(Self::Stream(at));
            }
        }
        Err(io::Error::other("too many links"))
    }
}

/// Whether a link stands for an open descriptor of a process, as `/dev/stdout` does.
fn is_descriptor(link: &Path) -> bool {
    let folder = parent(link).canonicalize().unwrap_or_default();
    folder.starts_with("/proc") && folder.ends_with("fd")
}

/// Whether a link stands for one of this process's.
pub(super) fn is_own_descriptor(link: &Path) -> bool {
    let own = Path::new("/proc/self/fd").canonicalize().unwrap_or_default();
    is_descriptor(link) && parent(link).canonicalize().is_ok_and(|folder| folder == own)
}

/// The folder of a file.
pub(super) fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Whether a name is that of a file in its folder and no other place.
pub fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    let is_one = matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None));
    is_one && !name.starts_with('.') && !name.ends_with('/')
}

/// The path of a file inside a result's folder, which others may have filled: a link there is not
/// followed, and what is no file is not replaced.
///
/// # Errors
/// A link or anything but a folder on the way, or anything but a file in its place.
pub fn within(folder: &Path, name: &str) -> Result<PathBuf, OutputError> {
    let mut at = folder.to_owned();
    let mut parts = Path::new(name).components().peekable();
    while let Some(part) = parts.next() {
        at.push(part);
        let wrong = |problem: &str| OutputError {
            path: at.clone(),
            source: io::Error::other(problem.to_owned()),
        };
        if !matches!(part, Component::Normal(_)) {
            return Err(wrong("it is not inside the result's folder"));
        }
        let Ok(now) = fs::symlink_metadata(&at) else { continue };
        let is_last = parts.peek().is_none();
        if now.is_symlink() {
            return Err(wrong("it is a link inside the result's folder, which is not followed"));
        } else if is_last && !now.is_file() {
            return Err(wrong("it is not a file, and is not replaced"));
        } else if !is_last && !now.is_dir() {
            return Err(wrong("it is not a folder"));
        }
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn only_a_name_in_its_own_folder_is_plain() {
        for name in ["a", "bed.obj", "a b"] {
            assert!(is_plain(name), "{name}");
        }
        for name in ["", ".", "..", "a/b", "a/", "/a", "../a", ".profile"] {
            assert!(!is_plain(name), "{name}");
        }
    }

    #[test]
    fn no_link_inside_a_folder_is_followed() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let folder = all.path().join("out");
        fs::create_dir_all(folder.join("packings")).expect("made");
        fs::write(all.path().join("mine"), "").expect("written");
        symlink(all.path(), folder.join("elsewhere")).expect("a link");
        symlink(all.path().join("mine"), folder.join("table.json")).expect("a link");
        for name in ["elsewhere/mine", "table.json", "../mine", "packings", "/etc/hosts"] {
            within(&folder, name).expect_err(name);
        }
        for name in ["signature.csv", "packings/1/table.json", "new/a"] {
            assert_eq!(within(&folder, name).expect(name), folder.join(name));
        }
    }

    #[test]
    fn links_of_the_user_are_followed_to_the_file_they_name() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let at = |name: &str| all.path().join(name);
        fs::create_dir(at("there")).expect("made");
        symlink("there/file", at("one")).expect("a link");
        symlink(at("one"), at("two")).expect("a link");
        symlink("round", at("round")).expect("a link");
        for link in ["one", "two"] {
            let Ok(Place::File(path, None)) = Place::of(&at(link)) else { panic!("{link}") };
            assert_eq!(path, at("there/file"));
        }
        assert!(matches!(Place::of(Path::new("/dev/null")), Ok(Place::Stream(_))));
        assert!(Place::of(&at("round")).is_err() && Place::of(all.path()).is_err());
    }
}
