//! ENVI files as they are read.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::pair;
use crate::support::file_error::FileError;
use crate::support::text;

/// A header: its keys in lower case, its values without braces.
pub(crate) struct Header {
    /// The header's file.
    pub path: PathBuf,
    /// The data's file.
    pub data: PathBuf,
    values: HashMap<String, String>,
}

/// The numbers of a data file, in single or double precision.
pub(crate) struct Numbers {
    /// Values are divided by it.
    pub scale: f64,
    /// Little-endian.
    bytes: Vec<u8>,
    is_double: bool,
    ignored: Option<f64>,
}

impl Numbers {
    /// A number by its place in the file; `None` where the header says to ignore it.
    pub(crate) fn get(&self, place: usize) -> Option<f64> {
        let size = if self.is_double { 8 } else { 4 };
        let bytes = &self.bytes[place * size..][..size];
        let number = match <[u8; 4]>::try_from(bytes) {
            Ok(single) => f64::from(f32::from_le_bytes(single)),
            Err(_) => f64::from_le_bytes(bytes.try_into().expect("4 or 8 bytes")),
        };
        let is = |ignored: f64| ignored == number || (ignored.is_nan() && number.is_nan());
        (!self.ignored.is_some_and(is)).then_some(number)
    }
}

impl Header {
    /// Reads the header of a file that is named by its data or its header.
    pub(crate) fn read(path: &Path, endings: &[&str]) -> Result<Self, FileError> {
        let [data, path] = pair(path, endings);
        let text = text::read(&path)?;
        let mut lines = text.lines();
        if lines.next().map(str::trim) != Some("ENVI") {
            return Err(FileError::wrong(&path, "the first line of a header must be ENVI"));
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
        Ok(Self { path, data, values })
    }

    pub(crate) fn wrong(&self, problem: impl Into<Box<str>>) -> FileError {
        FileError::wrong(&self.path, problem)
    }

    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    /// The items of a list. Some may be empty, but not the last.
    pub(crate) fn list(&self, key: &str) -> Vec<String> {
        let value = self.get(key).unwrap_or_default().trim_end_matches([',', ' ']);
        let items = value.split(',').map(|item| item.trim().to_owned());
        items.filter(|_| !value.is_empty()).collect()
    }

    fn numbers(&self, key: &str) -> Result<Vec<f64>, FileError> {
        let number = |item: &String| {
            item.parse().map_err(|_| self.wrong(format!("{key}: {item:?} is not a number")))
        };
        self.list(key).iter().filter(|item| !item.is_empty()).map(number).collect()
    }

    fn number(&self, key: &str) -> Result<Option<f64>, FileError> {
        Ok(self.numbers(key)?.first().copied())
    }

    pub(crate) fn count(&self, key: &str, default: Option<usize>) -> Result<usize, FileError> {
        match self.get(key) {
            None => default.ok_or_else(|| self.wrong(format!("{key} is missing"))),
            Some(text) => text.parse().map_err(|_| {
                self.wrong(format!(
                    "{key} = {text} is not a valid count: it must be a whole number"
                ))
            }),
        }
    }

    /// Wavelengths of the bands, in the header's unit, and whether each band is good.
    pub(crate) fn bands(&self, count: usize) -> Result<Vec<(f64, bool)>, FileError> {
        let wavelengths = self.numbers("wavelength")?;
        let good = match self.get("bbl") {
            None => vec![1.0; count],
            Some(_) => self.numbers("bbl")?,
        };
        if wavelengths.len() != count || good.len() != count {
            return Err(self.wrong(format!(
                "the header must have {count} wavelengths (and as many numbers in bbl, if it is \
                 there)"
            )));
        }
        Ok(wavelengths.into_iter().zip(good.into_iter().map(|good| good != 0.0)).collect())
    }

    /// The numbers of the data file, which must hold exactly as many as the shape has.
    pub(crate) fn data(&self, [a, b, c]: [usize; 3]) -> Result<Numbers, FileError> {
        let is_double = match self.count("data type", None)? {
            4 => false,
            5 => true,
            other => {
                let problem = format!("data type {other} is not 4 or 5 (single or double)");
                return Err(self.wrong(problem));
            }
        };
        let size = if is_double { 8 } else { 4 };
        let mut bytes = fs::read(&self.data).map_err(FileError::read(&self.data))?;
        let offset = self.count("header offset", Some(0))?;
        let needed = [a, b, c, size].iter().try_fold(1, |n: usize, &m| n.checked_mul(m));
        if needed.and_then(|n| n.checked_add(offset)) != Some(bytes.len()) || a * b * c == 0 {
            return Err(self.wrong(format!(
                "{a} x {b} x {c} numbers of {size} bytes do not make the {} bytes of {}",
                bytes.len(),
                self.data.display()
            )));
        }
        bytes.drain(..offset);
        match self.count("byte order", Some(0))? {
            0 => {}
            1 => bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse),
            other => return Err(self.wrong(format!("byte order {other} is not 0 or 1"))),
        }
        let as_held = |n: f64| if is_double { n } else { f64::from(n as f32) };
        let ignored = self.number("data ignore value")?.map(as_held);
        let scale = self.number("reflectance scale factor")?.unwrap_or(1.0);
        Ok(Numbers { scale, bytes, is_double, ignored })
    }
}
