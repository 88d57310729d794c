//! Files of numbers: CSV, whose headings name quantity and unit, and output of other programs.

use std::path::{Path, PathBuf};

use super::RadiometryError;
use super::models::{self, Model};
use crate::support::file_error::FileError;
use crate::support::linear::{LIKELY_UM, rounded_within};
use crate::support::text;

/// Endings of headings that name a unit of spectral radiance, with its factor to W m-2 sr-1 um-1.
/// The second unit is DIRSIG's.
const RADIANCE_UNITS: [(&str, f64); 2] = [("_w_m2_sr_um", 1.0), ("_w_cm2_sr_um", 1e4)];

/// A column of radiances that are all 0 is rounded as one that reaches this, W m-2 sr-1 um-1.
const LEAST_SCALE: f64 = 0.01;
/// Numbers by which programs mark what is missing. None is a radiance.
pub(crate) const MISSING_MARKS: [f64; 4] = [-999.0, -9999.0, -99999.0, -32768.0];

/// Above any radiance of a black body up to 10000 K at any wavelength (4.1e8), W m-2 sr-1 um-1.
pub(crate) const BRIGHTEST: f64 = 1e9;

/// The columns of a CSV file, by their headings. Commas, semicolons or tabs separate them. Lines
/// that begin with # are comments.
#[derive(Debug, Clone)]
pub struct Columns {
    path: PathBuf,
    headings: csv::StringRecord,
    rows: Vec<csv::StringRecord>,
    has_decimal_commas: bool,
}

impl Columns {
    /// Reads a file: CSV, MODTRAN's tape7, or uvspec's output with its options in comments.
    ///
    /// # Errors
    /// A file that cannot be read, is none of these, has no rows, or has rows of different lengths.
    pub fn read(path: &Path) -> Result<Self, RadiometryError> {
        let text = text::read(path)?;
        if let Some(model) = models::read(path, &text) {
            return Self::of_model(path, model?);
        }
        let is_heading = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
        let heading = text.lines().find(is_heading).unwrap_or_default();
        let delimiters = [',', ';', '\t'];
        let delimiter = delimiters.into_iter().find(|&of| heading.contains(of)).unwrap_or(',');
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .delimiter(delimiter as u8)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let wrong = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            FileError::wrong_in_line(path, line, error.to_string())
        };
        let headings = reader.headers().map_err(wrong)?.clone();
        let rows: Vec<_> = reader.records().collect::<Result<_, _>>().map_err(wrong)?;
        let has = |mark: char| rows.iter().flatten().any(|field| field.contains(mark));
        let has_decimal_commas = has(',');
        let is_mixed = has_decimal_commas && has('.');
        let columns = Self { path: path.to_owned(), headings, rows, has_decimal_commas };
        if columns.rows.is_empty() {
            return Err(columns.wrong_file("there are no rows below the headings"));
        }
        if is_mixed {
            let problem = "the numbers have decimal commas and decimal points: it is not clear \
                           which of them are thousands";
            return Err(columns.wrong_file(problem));
        }
        Ok(columns)
    }

    fn of_model(path: &Path, model: Model) -> Result<Self, RadiometryError> {
        let row = |(line, numbers): (u64, Vec<f64>)| {
            let fields: Vec<String> = numbers.iter().map(f64::to_string).collect();
            let mut row = csv::StringRecord::from(fields);
            let mut place = csv::Position::new();
            place.set_line(line);
            row.set_position(Some(place));
            row
        };
        let rows: Vec<_> = model.rows.into_iter().map(row).collect();
        let headings = model.headings.into();
        let columns = Self { path: path.to_owned(), headings, rows, has_decimal_commas: false };
        if columns.rows.is_empty() {
            return Err(columns.wrong_file("there are no numbers below the headings"));
        }
        Ok(columns)
    }

    /// The file's name without its folder.
    pub fn file(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// A column; `None` if its heading is missing.
    ///
    /// # Errors
    /// A field that is not a finite number.
    pub fn column(&self, heading: &str) -> Result<Option<Vec<f64>>, RadiometryError> {
        let is_of = |name: &str| name.eq_ignore_ascii_case(heading);
        let Some(place) = self.headings.iter().position(is_of) else { return Ok(None) };
        if self.headings.iter().skip(place + 1).any(is_of) {
            return Err(self.wrong_file(format!("there are two columns {heading}")));
        }
        let numbers = self.rows.iter().enumerate().map(|(row, record)| {
            let field = record.get(place).unwrap_or_default();
            let number = if self.has_decimal_commas {
                field.replacen(',', ".", 1).parse::<f64>()
            } else {
                field.parse::<f64>()
            };
            match number {
                Ok(value) if value.is_finite() => Ok(value),
                _ => Err(self.wrong(row, format!("{heading}: {field:?} is not a number"))),
            }
        });
        numbers.collect::<Result<_, _>>().map(Some)
    }

    fn holds(&self, heading: &str) -> bool {
        self.headings.iter().any(|name| name.eq_ignore_ascii_case(heading))
    }

    /// A column that must exist.
    pub fn needed(&self, heading: &str) -> Result<Vec<f64>, RadiometryError> {
        self.column(heading)?.ok_or_else(|| self.lacks(heading))
    }

    /// A column of radiance, W m-2 sr-1 um-1, by its heading without the unit; `None` if it is
    /// missing.
    ///
    /// # Errors
    /// A field that is not a finite number, or a radiance above that of any body of 10000 K.
    pub fn radiance(&self, stem: &str) -> Result<Option<Vec<f64>>, RadiometryError> {
        let is_held = |(unit, _): &(&str, f64)| self.holds(&format!("{stem}{unit}"));
        if RADIANCE_UNITS.iter().all(is_held) {
            let problem = format!("{stem} stands there in two units: leave out one of them");
            return Err(self.wrong_file(problem));
        }
        for (unit, factor) in RADIANCE_UNITS {
            let Some(values) = self.column(&format!("{stem}{unit}"))? else { continue };
            let values: Vec<f64> = values.into_iter().map(|l| l * factor).collect();
            if let Some(row) = values.iter().position(|l| l.abs() > BRIGHTEST) {
                let problem = format!(
                    "{stem}: {:e} W m-2 sr-1 um-1 is brighter than any body of 10000 K",
                    values[row]
                );
                return Err(self.wrong(row, problem));
            }
            return Ok(Some(values));
        }
        Ok(None)
    }

    /// A column of measured radiance, which must exist. Noise may make it negative.
    pub fn measured_radiance(&self, stem: &str) -> Result<Vec<f64>, RadiometryError> {
        let missing = || self.lacks(&format!("{stem}{}", RADIANCE_UNITS[0].0));
        let l = self.radiance(stem)?.ok_or_else(missing)?;
        match l.iter().position(|l| MISSING_MARKS.contains(l)) {
            Some(row) => {
                let problem =
                    format!("{stem}: {} marks what is missing: leave the row out", l[row]);
                Err(self.wrong(row, problem))
            }
            None => Ok(l),
        }
    }

    /// A column of radiance that must exist, 0 or more. What only rounding made negative is 0.
    pub fn needed_radiance(&self, stem: &str) -> Result<Vec<f64>, RadiometryError> {
        let mut l = self.measured_radiance(stem)?;
        let most = l.iter().copied().fold(0.0, f64::max);
        for l in &mut l {
            *l = rounded_within(*l, [0.0, most.max(LEAST_SCALE)]);
        }
        match l.iter().position(|&l| l < 0.0) {
            Some(row) => Err(self.wrong(row, format!("{stem}: {} is below 0", l[row]))),
            None => Ok(l),
        }
    }

    /// The wavelengths, um, above 0.
    pub fn wavelength_um(&self) -> Result<Vec<f64>, RadiometryError> {
        let um = self.needed("wavelength_um")?;
        if let Some(row) = um.iter().position(|&um| um <= 0.0) {
            return Err(self.wrong(row, format!("{} is not a valid wavelength in um", um[row])));
        }
        let [least, most] = LIKELY_UM;
        if um.iter().all(|um| *um > most) || um.iter().all(|um| *um < least) {
            let problem = format!("wavelength_um: all are outside {least} to {most} um");
            return Err(self.wrong_file(problem));
        }
        Ok(um)
    }

    /// The wavelengths in ascending order, um, each once, and their rows.
    pub fn ascending_um(&self) -> Result<(Vec<f64>, Vec<usize>), RadiometryError> {
        let um = self.wavelength_um()?;
        let mut rows: Vec<usize> = (0..um.len()).collect();
        rows.sort_by(|&a, &b| um[a].total_cmp(&um[b]));
        if let Some(pair) = rows.windows(2).find(|pair| um[pair[0]] == um[pair[1]]) {
            return Err(self.wrong(pair[1], format!("{} um appears twice", um[pair[1]])));
        }
        Ok((rows.iter().map(|&row| um[row]).collect(), rows))
    }

    /// An error unless there are two wavelengths to interpolate between.
    pub(super) fn two_at_least(&self, wavelength_um: &[f64]) -> Result<(), RadiometryError> {
        match wavelength_um.len() {
            0 | 1 => Err(self.wrong_file("there must be at least two wavelengths")),
            _ => Ok(()),
        }
    }

    /// An error in a row, counted from 0 below the headings.
    pub(super) fn wrong(&self, row: usize, problem: String) -> RadiometryError {
        let line = self.rows[row].position().map_or(0, csv::Position::line);
        FileError::wrong_in_line(&self.path, line, problem).into()
    }

    pub(super) fn wrong_file(&self, problem: impl Into<Box<str>>) -> RadiometryError {
        FileError::wrong(&self.path, problem).into()
    }

    fn lacks(&self, heading: &str) -> RadiometryError {
        let have: Vec<&str> = self.headings.iter().collect();
        self.wrong_file(format!("column {heading} is missing; the file has {}", have.join(", ")))
    }
}
