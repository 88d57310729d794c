//! How columns of text are separated, and how their numbers are written.

use std::path::Path;

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
            let line = line.join(&separator.to_string());
            let mut reader = csv::ReaderBuilder::new()
                .delimiter(separator as u8)
                .has_headers(false)
                .trim(csv::Trim::All)
                .from_reader(line.as_bytes());
            let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
            record.iter().map(str::to_owned).collect()
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
