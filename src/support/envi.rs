//! The header that stands beside every ENVI file: what its numbers are and how they lie.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::error::Failure;

/// An ENVI file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum EnviError {
    /// The data or the header cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The header is not one, or does not fit the data.
    #[error("{}: {problem}", path.display())]
    Form {
        /// The header.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
}

impl Failure for EnviError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Read { .. } => None,
            Self::Form { .. } => Some(
                "docs/images.md says which ENVI images are read, docs/spectra.md which libraries"
                    .into(),
            ),
        }
    }
}

/// The keys of a .hdr file, in small letters, with their values; those in braces without them.
pub(crate) struct Header {
    path: PathBuf,
    values: HashMap<String, String>,
}

/// The type of the numbers in a file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Float {
    is_double: bool,
    is_big_endian: bool,
}

impl Float {
    /// A number as the file can hold it.
    pub(crate) fn rounded(self, number: f64) -> f64 {
        if self.is_double { number } else { f64::from(number as f32) }
    }

    /// Bytes of a number.
    pub(crate) fn size(self) -> usize {
        if self.is_double { 8 } else { 4 }
    }

    /// The number that so many bytes make.
    pub(crate) fn read(self, bytes: &[u8]) -> f64 {
        let mut bytes = bytes.to_vec();
        if self.is_big_endian {
            bytes.reverse();
        }
        match <[u8; 4]>::try_from(bytes.as_slice()) {
            Ok(single) => f64::from(f32::from_le_bytes(single)),
            Err(_) => f64::from_le_bytes(bytes.try_into().expect("4 or 8 bytes")),
        }
    }
}

impl Header {
    pub(crate) fn read(path: &Path) -> Result<Self, EnviError> {
        let text = text(bytes(path)?);
        let mut lines = text.lines();
        if lines.next().map(str::trim) != Some("ENVI") {
            let problem = "a header starts with the line ENVI".into();
            return Err(EnviError::Form { path: path.to_owned(), problem });
        }
        let mut values = HashMap::new();
        while let Some(line) = lines.next() {
            let Some((key, value)) = line.split_once('=') else { continue };
            let mut value = value.trim().to_owned();
            while value.starts_with('{') && !value.contains('}') {
                let Some(next) = lines.next() else { break };
                value = value + " " + next.trim();
            }
            let value = value.trim_matches(['{', '}', ' ']).to_owned();
            values.insert(key.trim().to_lowercase(), value);
        }
        Ok(Self { path: path.to_owned(), values })
    }

    pub(crate) fn wrong(&self, problem: impl Into<String>) -> EnviError {
        EnviError::Form { path: self.path.clone(), problem: problem.into() }
    }

    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    /// The items of a list, of which some may be empty, but not the last.
    pub(crate) fn list(&self, key: &str) -> Vec<String> {
        let value = self.get(key).unwrap_or_default().trim_end_matches([',', ' ']);
        let items = value.split(',').map(|item| item.trim().to_owned());
        items.filter(|_| !value.is_empty()).collect()
    }

    pub(crate) fn numbers(&self, key: &str) -> Result<Vec<f64>, EnviError> {
        let number = |item: &String| {
            item.parse().map_err(|_| self.wrong(format!("{key}: {item:?} is not a number")))
        };
        self.list(key).iter().filter(|item| !item.is_empty()).map(number).collect()
    }

    pub(crate) fn count(&self, key: &str, default: Option<usize>) -> Result<usize, EnviError> {
        let value = self.get(key).map(str::parse);
        match (value, default) {
            (Some(Ok(count)), _) => Ok(count),
            (None, Some(default)) => Ok(default),
            _ => Err(self.wrong(format!("{key} = a whole number is missing"))),
        }
    }

    /// The type of the numbers: single or double precision.
    pub(crate) fn float(&self) -> Result<Float, EnviError> {
        let is_double = match self.count("data type", None)? {
            4 => false,
            5 => true,
            other => {
                return Err(
                    self.wrong(format!("data type {other} is not 4 or 5 (single or double)"))
                );
            }
        };
        let is_big_endian = match self.count("byte order", Some(0))? {
            0 => false,
            1 => true,
            other => return Err(self.wrong(format!("byte order {other} is not 0 or 1"))),
        };
        Ok(Float { is_double, is_big_endian })
    }

    /// The numbers of the data file, which has three dimensions and no more bytes than they make.
    pub(crate) fn data(&self, path: &Path, [a, b, c]: [usize; 3]) -> Result<Vec<u8>, EnviError> {
        let size = self.float()?.size();
        let mut data = bytes(path)?;
        let offset = self.count("header offset", Some(0))?;
        let needed = [a, b, c, size].iter().try_fold(1, |n: usize, &m| n.checked_mul(m));
        if needed.and_then(|n| n.checked_add(offset)) != Some(data.len()) || a * b * c == 0 {
            return Err(self.wrong(format!(
                "{a} x {b} x {c} numbers of {size} bytes do not make the {} bytes of {}",
                data.len(),
                path.display()
            )));
        }
        data.drain(..offset);
        Ok(data)
    }
}

/// The data and the header of a file that is named by either; `endings` are those that data may have.
pub(crate) fn pair(path: &Path, endings: &[&str]) -> (PathBuf, PathBuf) {
    if ending(path) == "hdr" {
        let whole = path.with_extension("");
        if endings.contains(&ending(&whole).as_str()) {
            return (whole, path.to_owned());
        }
        let known = endings.iter().map(|ending| path.with_extension(ending));
        let data = known.chain([whole]).find(|data| data.exists());
        return (data.unwrap_or_else(|| path.with_extension(endings[0])), path.to_owned());
    }
    let mut whole_name = path.as_os_str().to_owned();
    whole_name.push(".hdr");
    let whole_name = PathBuf::from(whole_name);
    let header = if whole_name.exists() { whole_name } else { path.with_extension("hdr") };
    (path.to_owned(), header)
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

fn bytes(path: &Path) -> Result<Vec<u8>, EnviError> {
    fs::read(path).map_err(|source| EnviError::Read { path: path.to_owned(), source })
}

/// Text in UTF-8, else in Latin-1, without a byte order mark.
pub(crate) fn text(bytes: Vec<u8>) -> String {
    let text = String::from_utf8(bytes)
        .unwrap_or_else(|latin_1| latin_1.as_bytes().iter().map(|&b| b as char).collect());
    text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text)
}
