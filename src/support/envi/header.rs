//! The header of an ENVI file, read as SPy reads it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::{headers, pair};
use crate::support::file_error::FileError;
use crate::support::text;

/// Keys that say what the numbers of the data are.
const NUMBERS: [&str; 13] = [
    "samples",
    "lines",
    "bands",
    "header offset",
    "file type",
    "data type",
    "byte order",
    "interleave",
    "wavelength",
    "wavelength units",
    "bbl",
    "data ignore value",
    "reflectance scale factor",
];

/// A header: its keys in lower case, its values without braces.
pub(crate) struct Header {
    /// The header's file.
    pub path: PathBuf,
    /// The data's file.
    pub data: PathBuf,
    values: HashMap<String, String>,
}

impl Header {
    /// Reads the header of a file that is named by its data or its header.
    pub(crate) fn read(path: &Path, endings: &[&str]) -> Result<Self, FileError> {
        let is_named = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("hdr"));
        let [data, path] = pair(path, endings);
        let text = text::read(&path)?;
        let others = if is_named { Vec::new() } else { headers(&data) };
        for other in others.iter().filter(|other| **other != path) {
            if text::read(other)? != text {
                let problem = format!("{} is another header of the same data", other.display());
                let hint = "name the header that is right instead of the data";
                return Err(FileError::wrong(&path, problem).with_hint(hint));
            }
        }
        let (values, twice) = values(&text)
            .ok_or_else(|| FileError::wrong(&path, "the first line of a header must be ENVI"))?;
        if let Some(key) = twice.iter().find(|key| NUMBERS.contains(&key.as_str())) {
            let problem =
                format!("{key} stands twice, with different values: leave out one of them");
            return Err(FileError::wrong(&path, problem));
        }
        Ok(Self { path, data, values })
    }

    pub(crate) fn wrong(&self, problem: impl Into<Box<str>>) -> FileError {
        FileError::wrong(&self.path, problem)
    }

    /// A value that is not blank.
    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str).filter(|value| !value.is_empty())
    }

    /// The items of a list. Some may be empty, but not the last.
    pub(crate) fn list(&self, key: &str) -> Vec<String> {
        let value = self.get(key).unwrap_or_default().trim_end_matches([',', ' ']);
        let items = value.split(',').map(|item| item.trim().to_owned());
        items.filter(|_| !value.is_empty()).collect()
    }

    /// Refuses gains and offsets that change the numbers, and data that are packed.
    pub(crate) fn refuse_changed_data(&self) -> Result<(), FileError> {
        // Programs have keys of their own for them. Those of reflectance say how to make it.
        let is_change = |key: &&String| {
            ["scale factor", "gain values", "offset values"].iter().any(|end| key.ends_with(end))
                && *key != "reflectance scale factor"
                && !key.starts_with("data reflectance")
                || ["scale", "gain", "offset", "add offset"].contains(&key.as_str())
        };
        let mut keys: Vec<&String> = self.values.keys().filter(is_change).collect();
        keys.sort_unstable();
        for key in keys {
            let neutral = if key.contains("offset") { 0.0 } else { 1.0 };
            if self.numbers(key)?.iter().any(|value| *value != neutral) {
                return Err(self.wrong(format!("{key} are not supported: apply them before")));
            }
        }
        if self.number("file compression")?.is_some_and(|packed| packed != 0.0) {
            return Err(self.wrong("its data are compressed: write them without compression"));
        }
        let key = "major frame offsets";
        if self.numbers(key)?.iter().any(|bytes| *bytes != 0.0) {
            return Err(self.wrong(format!("{key} are not supported: write the data without them")));
        }
        Ok(())
    }

    fn numbers(&self, key: &str) -> Result<Vec<f64>, FileError> {
        let number = |item: &String| {
            item.parse().map_err(|_| self.wrong(format!("{key}: {item:?} is not a number")))
        };
        self.list(key).iter().filter(|item| !item.is_empty()).map(number).collect()
    }

    pub(crate) fn number(&self, key: &str) -> Result<Option<f64>, FileError> {
        Ok(self.numbers(key)?.first().copied())
    }

    pub(crate) fn count(&self, key: &str, default: Option<usize>) -> Result<usize, FileError> {
        match self.get(key) {
            None => default.ok_or_else(|| self.wrong(format!("{key} is missing"))),
            // 15.0, "15" and 15 ; lines are written as well.
            Some(text) => first_word(text).parse::<f64>().ok().and_then(whole).ok_or_else(|| {
                self.wrong(format!(
                    "{key} = {text} is not a valid count: it must be a whole number"
                ))
            }),
        }
    }

    /// Wavelengths of the bands, in the header's unit, and whether each band is good.
    pub(crate) fn bands(&self, count: usize) -> Result<Vec<(f64, bool)>, FileError> {
        let wavelengths = self.numbers("wavelength")?;
        let listed = self.list("bbl");
        let good: Result<Vec<bool>, _> = listed.iter().map(|item| self.is_good(item)).collect();
        let good = if listed.is_empty() { vec![true; count] } else { good? };
        if wavelengths.len() != count || good.len() != count {
            return Err(self.wrong(format!(
                "the header must have {count} wavelengths (and as many numbers in bbl, if it is \
                 there)"
            )));
        }
        Ok(wavelengths.into_iter().zip(good).collect())
    }

    fn is_good(&self, item: &str) -> Result<bool, FileError> {
        match item.to_lowercase().as_str() {
            "true" => Ok(true),
            "false" => Ok(false),
            _ => item
                .parse::<f64>()
                .map(|good| good != 0.0 && !good.is_nan())
                .map_err(|_| self.wrong(format!("bbl: {item:?} is not a number"))),
        }
    }
}

/// The first word of a value, without quotes and without a comment after it.
fn first_word(text: &str) -> &str {
    text.split(';').next().unwrap_or_default().trim().trim_matches(['"', '\''])
}

/// The count that a number is.
fn whole(number: f64) -> Option<usize> {
    // Up to here all whole numbers are exact.
    let is_count = number.fract() == 0.0 && (0.0..=9e15).contains(&number);
    is_count.then_some(number as usize)
}

/// The values of a header's text by their keys, and the keys that stand there twice with different
/// values; `None` if it is not one.
///
/// A value in braces may begin in the next line and may have braces and comments within. If its
/// braces are not balanced, it goes on to the first line that ends with one, as in SPy.
fn values(text: &str) -> Option<(HashMap<String, String>, Vec<String>)> {
    let lines: Vec<&str> =
        text.lines().map(str::trim).filter(|line| !line.starts_with(';')).collect();
    let (first, lines) = lines.split_first()?;
    if !first.starts_with("ENVI") {
        return None;
    }
    let (mut values, mut twice) = (HashMap::new(), Vec::new());
    let mut at = 0;
    while at < lines.len() {
        let line = lines[at];
        at += 1;
        let Some((key, value)) = line.split_once('=') else { continue };
        let mut value = value.trim().to_owned();
        if value.is_empty() {
            let next = lines[at..].iter().position(|line| !line.is_empty());
            if let Some(next) = next.filter(|next| lines[at + next].starts_with('{')) {
                lines[at + next].clone_into(&mut value);
                at += next + 1;
            }
        }
        if value.starts_with('{') {
            let rest = &lines[at..];
            let (inner, taken) = balanced(&value, rest).unwrap_or_else(|| to_brace(&value, rest));
            (value, at) = (inner, at + taken);
        }
        let key = key.trim().to_lowercase();
        let bare = |value: &str| value.trim_matches(['"', '\'']).to_lowercase();
        let before = values.insert(key.clone(), value.clone());
        if before.is_some_and(|before| bare(&before) != bare(&value)) {
            twice.push(key);
        }
    }
    Some((values, twice))
}

/// A value up to the brace that closes its first, and how many further lines it takes.
fn balanced(value: &str, further: &[&str]) -> Option<(String, usize)> {
    let mut inner = String::new();
    let mut depth = 0;
    for (taken, line) in [value].iter().chain(further).enumerate() {
        for c in line.chars() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return Some((inner.trim_start_matches('{').trim().to_owned(), taken));
            }
            inner.push(c);
        }
        inner.push(' ');
    }
    None
}

/// A value up to the first line that ends with a brace, and how many further lines it takes.
fn to_brace(value: &str, further: &[&str]) -> (String, usize) {
    let last = [value].iter().chain(further).position(|line| line.ends_with('}'));
    let taken = last.unwrap_or(further.len());
    let inner = [&[value], &further[..taken]].concat().join(" ");
    (inner.trim_matches(['{', '}', ' ']).to_owned(), taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_read_however_they_are_laid_out() {
        let read = |text: &str| values(text).expect("a header").0;
        for text in [
            "ENVI\nsamples = 3\nwavelength = {8, 9}\nbbl = \nlines = 2\n",
            "ENVI\r\nsamples=3\nwavelength =\n\n{8,\n 9}\nbbl =\nlines = 2\n",
            "ENVI header\n; a comment = 7\nSamples = 3\nwavelength = {\n; centres, 7\n8,\n9\n}\n\
             lines = 2",
            "ENVI\ndescription = {by {tool},\n samples = 9}\nsamples = 3\nwavelength = {8, 9}\n\
             lines = 2\n",
            "ENVI\nsamples = 3\nlines = 2\nwavelength = {8, 9}\ndescription = {\n by {tool}\n\
             samples = 9 }\n",
            "ENVI\ndescription = { a { smile }\nsamples = 3\nwavelength = {8, 9} ; um\nlines = 2\n",
        ] {
            let values = read(text);
            assert_eq!(values.get("samples").map(String::as_str), Some("3"), "{text}");
            assert_eq!(values.get("lines").map(String::as_str), Some("2"), "{text}");
            let wavelength: Vec<&str> = values["wavelength"].split(',').map(str::trim).collect();
            assert_eq!(wavelength, ["8", "9"], "{text}");
        }
        assert!(values("ENV\nsamples = 3\n").is_none() && values("").is_none());
    }
}
