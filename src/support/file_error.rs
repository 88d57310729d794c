//! A file that cannot be used: the shape that most failures have.

use std::io;
use std::path::{Path, PathBuf};

use super::error::Failure;

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
    #[error("{}{}: {problem}", path.display(), after_comma(place.as_deref()))]
    Wrong {
        /// The file.
        path: PathBuf,
        /// The line, key or object in the file, if there is one.
        place: Option<Box<str>>,
        /// What is wrong.
        problem: Box<str>,
        /// What the user can do about it, where this differs from other errors of such a file.
        hint: Option<&'static str>,
    },
}

impl FileError {
    /// What the system said of a file that was to be read.
    pub fn read(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Read { path, source }
    }

    /// What is wrong with the file as a whole.
    pub fn wrong(path: &Path, problem: impl Into<Box<str>>) -> Self {
        let (path, problem) = (path.to_owned(), problem.into());
        Self::Wrong { path, place: None, problem, hint: None }
    }

    /// What is wrong at a place of the file: a key, an object, `line 3`.
    pub fn wrong_at(path: &Path, place: impl Into<Box<str>>, problem: impl Into<Box<str>>) -> Self {
        let (path, problem) = (path.to_owned(), problem.into());
        Self::Wrong { path, place: Some(place.into()), problem, hint: None }
    }

    /// What is wrong in a line of the file, counted from 1.
    pub fn wrong_in_line(path: &Path, line: u64, problem: impl Into<Box<str>>) -> Self {
        Self::wrong_at(path, format!("line {line}"), problem)
    }

    /// The same error with its own hint.
    #[must_use]
    pub fn with_hint(mut self, text: &'static str) -> Self {
        if let Self::Wrong { hint, .. } = &mut self {
            *hint = Some(text);
        }
        self
    }

    /// Its own hint, else the one given; none for a file that cannot be read.
    pub fn hint_or(&self, usual: &str) -> Option<String> {
        match self {
            Self::Read { .. } => None,
            Self::Wrong { hint, .. } => Some(hint.unwrap_or(usual).to_owned()),
        }
    }
}

impl Failure for FileError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Wrong { hint, .. } => hint.map(str::to_owned),
            Self::Read { .. } => None,
        }
    }
}

fn after_comma(place: Option<&str>) -> String {
    place.map_or_else(String::new, |place| format!(", {place}"))
}
