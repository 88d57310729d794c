//! Text files of other programs.

use std::fs;
use std::path::Path;

use super::file_error::FileError;

/// The text of a file in UTF-8 or else Latin-1, without a byte order mark.
pub fn read(path: &Path) -> Result<String, FileError> {
    let bytes = fs::read(path).map_err(FileError::read(path))?;
    let text = String::from_utf8(bytes)
        .unwrap_or_else(|latin_1| latin_1.as_bytes().iter().map(|&b| b as char).collect());
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}
