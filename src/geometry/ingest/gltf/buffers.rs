//! The bytes of a glTF file's buffers: in the file itself, in its text, or in files beside it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::file::{self, Buffer, Gltf};
use crate::support::file_error::FileError;

/// Files beside a glTF file that hold its buffers.
pub(in super::super) fn buffer_files(path: &Path, bytes: &[u8]) -> Result<Vec<PathBuf>, FileError> {
    let (file, _) = file::parse(path, bytes)?;
    let mut files = Vec::new();
    for (number, buffer) in file.buffers.iter().enumerate() {
        let Some(uri) = buffer.uri.as_deref().filter(|uri| !is_data(uri)) else { continue };
        let [decoded, raw] = beside(path, uri);
        if uri.contains("://") || [&*name(uri), uri].iter().any(|name| name.starts_with('/')) {
            let problem = format!("{uri:?} does not name a file beside it");
            return Err(wrong(path, number, problem));
        }
        files.push(if !decoded.exists() && raw.exists() { raw } else { decoded });
    }
    Ok(files)
}

/// The file that a URI names, and the one whose name it is, where a program encoded nothing.
fn beside(path: &Path, uri: &str) -> [PathBuf; 2] {
    let folder = path.parent().unwrap_or(Path::new(""));
    [folder.join(&*name(uri)), folder.join(uri)]
}

fn name(uri: &str) -> Cow<'_, str> {
    percent_decode_str(uri).decode_utf8_lossy()
}

fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// The buffers that stand in the text of the file.
pub(super) fn in_text(path: &Path, file: &Gltf) -> Result<Vec<Option<Vec<u8>>>, FileError> {
    let bytes = |(number, buffer): (usize, &Buffer)| {
        let Some(uri) = buffer.uri.as_deref().filter(|uri| is_data(uri)) else { return Ok(None) };
        let bytes = decoded(uri).ok_or_else(|| wrong(path, number, "it is not base64"))?;
        Ok(Some(bytes))
    };
    file.buffers.iter().enumerate().map(bytes).collect()
}

/// The bytes of a `data:` URI.
fn decoded(uri: &str) -> Option<Vec<u8>> {
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let (head, text) = uri.split_once(',')?;
    let mut text: Vec<u8> = percent_decode_str(text).collect();
    if !head.to_ascii_lowercase().ends_with(";base64") {
        return Some(text);
    }
    text.retain(|byte| !byte.is_ascii_whitespace());
    // The letters for addresses do as well.
    for byte in &mut text {
        match byte {
            b'-' => *byte = b'+',
            b'_' => *byte = b'/',
            _ => {}
        }
    }
    GeneralPurpose::new(&STANDARD, config).decode(text).ok()
}

/// The bytes of each buffer; `None` of one that is nowhere, as of a copy that a compressed file
/// leaves out.
///
/// # Errors
/// A buffer is shorter than the file says.
pub(super) fn all<'a>(
    path: &Path,
    file: &Gltf,
    blob: Option<&'a [u8]>,
    in_text: &'a [Option<Vec<u8>>],
    files: &'a BTreeMap<PathBuf, Vec<u8>>,
) -> Result<Vec<Option<&'a [u8]>>, FileError> {
    let bytes = |(number, buffer): (usize, &Buffer)| {
        let bytes = match (&buffer.uri, &in_text[number]) {
            (_, Some(bytes)) => Some(&**bytes),
            (Some(uri), None) => {
                beside(path, uri).iter().find_map(|path| files.get(path)).map(|bytes| &**bytes)
            }
            (None, None) if number == 0 => blob,
            (None, None) => None,
        };
        let Some(bytes) = bytes else { return Ok(None) };
        let whole = bytes.get(..buffer.byte_length).ok_or_else(|| {
            let (found, length) = (bytes.len(), buffer.byte_length);
            wrong(path, number, format!("it has {found} bytes, not {length}"))
        })?;
        Ok(Some(whole))
    };
    file.buffers.iter().enumerate().map(bytes).collect()
}

fn wrong(path: &Path, number: usize, problem: impl Into<Box<str>>) -> FileError {
    FileError::wrong_at(path, format!("buffer {number}"), problem)
}
