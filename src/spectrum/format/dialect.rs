//! How columns of text are separated, and how their numbers are written.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;

use csv_core::{Reader, ReaderBuilder};

use super::wrong;
use crate::spectrum::SpectrumError;

/// The separator of a file's columns, and the mark of its decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    separator: Separator,
    has_decimal_commas: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Tab,
    Semicolon,
    Comma,
    Bar,
    Blanks,
}

impl Dialect {
    /// The dialect of a file whose first line of numbers is this; `None` for other lines.
    pub(super) fn of(line: &str) -> Option<Self> {
        let with = |separator, has_decimal_commas| Self { separator, has_decimal_commas };
        let dialect = if line.contains('\t') {
            with(Separator::Tab, line.contains(','))
        } else if line.contains(';') {
            with(Separator::Semicolon, line.contains(','))
        } else if line.contains('|') {
            with(Separator::Bar, line.contains(','))
        } else if line.contains(',') {
            let by_comma = with(Separator::Comma, false);
            let by_blanks = with(Separator::Blanks, true);
            let fits = |dialect: &Self| {
                let fields = dialect.fields(line);
                fields.len() > 1 && fields.iter().all(|field| dialect.number(field).is_some())
            };
            // Quoted numbers may have decimal commas even so.
            let quoted = with(Separator::Comma, true);
            [by_comma, by_blanks, quoted].into_iter().find(fits).unwrap_or(by_comma)
        } else {
            with(Separator::Blanks, false)
        };
        let first = dialect.fields(line).into_iter().next()?;
        dialect.number(&first).map(|_| dialect)
    }

    /// The fields of a line, without quotes and without empty ones at the end.
    pub(super) fn fields(self, line: &str) -> Vec<String> {
        let split = |separator: char| -> Vec<String> {
            if !line.contains('"') {
                return line.split(separator).map(|field| field.trim().to_owned()).collect();
            }
            // Blanks may stand between a separator and a quote.
            let tidy = |field: &str| -> String {
                let bare = field.trim();
                if bare.starts_with('"') { bare } else { field }.to_owned()
            };
            let line: Vec<String> = line.split(separator).map(tidy).collect();
            unquoted(&line.join(&separator.to_string()), separator)
        };
        let mut fields = match self.separator {
            // Tabs may also align the columns.
            Separator::Tab => split('\t').into_iter().filter(|field| !field.is_empty()).collect(),
            Separator::Semicolon => split(';'),
            Separator::Comma => split(','),
            Separator::Bar => split('|'),
            Separator::Blanks => line.split_whitespace().map(|f| f.replace('"', "")).collect(),
        };
        let end = fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1);
        fields.truncate(end);
        fields
    }

    /// The number that a field is, if it is one.
    pub(super) fn number(self, field: &str) -> Option<f64> {
        let field = field.trim_matches('\'');
        if self.has_decimal_commas && field.contains(',') {
            return field.replacen(',', ".", 1).parse().ok();
        }
        // Fortran's exponents, and the minus of word processors.
        let plain = || field.replace('\u{2212}', "-").replacen(['d', 'D'], "e", 1);
        field.parse().ok().or_else(|| plain().parse().ok())
    }

    /// Checks that the numbers of a line are written as those of the first: decimals after commas
    /// and after points in one file may be thousands.
    pub(super) fn check(
        &mut self,
        path: &Path,
        line: usize,
        fields: &[String],
        has_decimal_points: &mut bool,
    ) -> Result<(), SpectrumError> {
        if self.separator != Separator::Comma {
            self.has_decimal_commas |= fields.iter().any(|field| field.contains(','));
        }
        *has_decimal_points |= fields.iter().any(|field| field.contains('.'));
        if self.has_decimal_commas && *has_decimal_points {
            let problem = "the numbers have decimal commas and decimal points: it is not clear \
                           which of them are thousands";
            return Err(wrong(path, line, problem));
        }
        Ok(())
    }
}

thread_local! {
    /// Readers by separator: to make one takes longer than to read a line.
    static READERS: RefCell<BTreeMap<char, Reader>> = RefCell::default();
}

/// The fields of a line with quotes.
fn unquoted(line: &str, separator: char) -> Vec<String> {
    let mut bytes = vec![0; line.len()];
    let mut ends = vec![0; line.matches(separator).count() + 1];
    let count = READERS.with_borrow_mut(|readers| {
        let new = || ReaderBuilder::new().delimiter(separator as u8).build();
        let reader = readers.entry(separator).or_insert_with(new);
        reader.reset();
        let (_, _, written, count) = reader.read_record(line.as_bytes(), &mut bytes, &mut ends);
        // What is open at the end of the line ends there.
        let (_, _, _, last) = reader.read_record(&[], &mut bytes[written..], &mut ends[count..]);
        count + last
    });
    let mut from = 0;
    let field = |&end: &usize| {
        let field = String::from_utf8_lossy(&bytes[from..end]).trim().to_owned();
        from = end;
        field
    };
    ends[..count].iter().map(field).collect()
}
