//! A file that cannot be used: the shape that most failures have.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A file that cannot be used, with the place in it and what is wrong there.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Its content is wrong.
    #[error("{}{}: {problem}", path.display(), Place(place.as_deref()))]
    Wrong {
        /// The file.
        path: PathBuf,
        /// The line, key or object in the file, if there is one.
        place: Option<String>,
        /// What is wrong.
        problem: String,
    },
}

impl FileError {
    /// What the system said of a file that was to be read.
    pub fn read(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Read { path, source }
    }

    /// What is wrong with the file as a whole.
    pub fn wrong(path: &Path, problem: impl Into<String>) -> Self {
        Self::Wrong { path: path.to_owned(), place: None, problem: problem.into() }
    }

    /// What is wrong at a place of the file: a key, an object, `line 3`.
    pub fn wrong_at(path: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        let place = Some(place.into());
        Self::Wrong { path: path.to_owned(), place, problem: problem.into() }
    }

    /// What is wrong in a line of the file, counted from 1.
    pub fn wrong_in_line(path: &Path, line: u64, problem: impl Into<String>) -> Self {
        Self::wrong_at(path, format!("line {line}"), problem)
    }
}

struct Place<'a>(Option<&'a str>);

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |place| write!(f, ", {place}"))
    }
}
