//! Text files of other programs.

use std::borrow::Cow;
use std::fs;
use std::path::Path;

use super::file_error::FileError;

/// The text of a file, as [`decode`] reads it.
pub fn read(path: &Path) -> Result<String, FileError> {
    let bytes = fs::read(path).map_err(FileError::read(path))?;
    Ok(decode(&bytes).into_owned())
}

/// The text of a file's bytes, without a byte order mark and with `\n` at the ends of lines.
///
/// It is read as UTF-16 or UTF-32 if its first bytes say so. Else it is UTF-8, and each byte that is not
/// UTF-8 is Latin-1. Lines may end with `\n`, `\r\n` or `\r`.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let text = match bytes {
        [0xef, 0xbb, 0xbf, text @ ..] => utf_8_or_latin_1(text),
        [0xff, 0xfe, 0, 0, text @ ..] => utf_32(text, u32::from_le_bytes).into(),
        [0, 0, 0xfe, 0xff, text @ ..] => utf_32(text, u32::from_be_bytes).into(),
        [0xff, 0xfe, text @ ..] => utf_16(text, u16::from_le_bytes).into(),
        [0xfe, 0xff, text @ ..] => utf_16(text, u16::from_be_bytes).into(),
        // UTF-16 without a mark: text has no zero bytes.
        [1..=255, 0, ..] => utf_16(bytes, u16::from_le_bytes).into(),
        [0, 1..=255, ..] => utf_16(bytes, u16::from_be_bytes).into(),
        _ => utf_8_or_latin_1(bytes),
    };
    // The mark of an end that old programs write.
    let text = match text {
        Cow::Borrowed(text) => Cow::Borrowed(text.trim_end_matches('\u{1a}')),
        Cow::Owned(text) => Cow::Owned(text.trim_end_matches('\u{1a}').to_owned()),
    };
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n").into() } else { text }
}

fn utf_8_or_latin_1(bytes: &[u8]) -> Cow<'_, str> {
    if let Ok(text) = std::str::from_utf8(bytes) {
        return text.into();
    }
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        text.extend(chunk.invalid().iter().map(|&byte| char::from(byte)));
    }
    text.into()
}

fn utf_16(bytes: &[u8], unit: impl Fn([u8; 2]) -> u16) -> String {
    let units = bytes.as_chunks().0.iter().map(|&pair| unit(pair));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

fn utf_32(bytes: &[u8], unit: impl Fn([u8; 4]) -> u32) -> String {
    let units = bytes.as_chunks().0.iter().map(|&four| unit(four));
    units.map(|unit| char::from_u32(unit).unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_text_is_read_from_every_encoding_and_line_end() {
        let text = "K\u{f6}rner \u{b5}m\n8 9\n";
        let latin_1: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let units = || text.encode_utf16();
        let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
        let codes = || text.chars().map(u32::from);
        let little_32: Vec<u8> = codes().flat_map(u32::to_le_bytes).collect();
        let big_32: Vec<u8> = codes().flat_map(u32::to_be_bytes).collect();
        for (name, mark, bytes) in [
            ("UTF-8", &[][..], text.as_bytes()),
            ("UTF-8, marked", &[0xef, 0xbb, 0xbf], text.as_bytes()),
            ("Latin-1", &[], &latin_1),
            ("UTF-16", &[], &little),
            ("UTF-16, marked", &[0xff, 0xfe], &little),
            ("UTF-16, big end first", &[], &big),
            ("UTF-16, big end first, marked", &[0xfe, 0xff], &big),
            ("UTF-32, marked", &[0xff, 0xfe, 0, 0], &little_32),
            ("UTF-32, big end first, marked", &[0, 0, 0xfe, 0xff], &big_32),
        ] {
            assert_eq!(decode(&[mark, bytes].concat()), text, "{name}");
        }
        for end in ["\r\n", "\r"] {
            assert_eq!(decode(text.replace('\n', end).as_bytes()), text, "{end:?}");
        }
    }

    #[test]
    fn a_byte_that_is_not_utf_8_spoils_no_other() {
        assert_eq!(decode(b"\xb5m \xc3\xb6 \xf6"), "\u{b5}m \u{f6} \u{f6}");
        for (bytes, text) in [(&b""[..], ""), (b"v", "v"), (b"\xff\xfe", ""), (b"\xff\xfev", "")] {
            assert_eq!(decode(bytes), text);
        }
    }
}
