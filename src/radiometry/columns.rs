//! CSV files of numbers whose headings name quantity and unit.

use std::path::{Path, PathBuf};

use super::RadiometryError;

/// Ends of headings that give a unit of spectral radiance, with what makes W m-2 sr-1 um-1 of it. The second is
/// DIRSIG's.
const RADIANCE_UNITS: [(&str, f64); 2] = [("_w_m2_sr_um", 1.0), ("_w_cm2_sr_um", 1e4)];

/// The columns of a CSV file by their headings. Lines that start with # are left out.
#[derive(Debug, Clone)]
pub struct Columns {
    path: PathBuf,
    headings: csv::StringRecord,
    rows: Vec<csv::StringRecord>,
}

impl Columns {
    /// Reads a file.
    ///
    /// # Errors
    /// One that cannot be read, is no CSV, or has lines of different numbers of fields.
    pub fn read(path: &Path) -> Result<Self, RadiometryError> {
        let file = std::fs::File::open(path)
            .map_err(|source| RadiometryError::Read { path: path.to_owned(), source })?;
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(std::io::BufReader::new(file));
        let wrong = |error: csv::Error| RadiometryError::Form {
            path: path.to_owned(),
            line: error.position().map_or(1, csv::Position::line),
            problem: error.to_string(),
        };
        let headings = reader.headers().map_err(wrong)?.clone();
        let rows: Vec<_> = reader.records().collect::<Result<_, _>>().map_err(wrong)?;
        let columns = Self { path: path.to_owned(), headings, rows };
        if columns.rows.is_empty() {
            return Err(columns.wrong_file("there are no rows below the headings".into()));
        }
        Ok(columns)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's name, for messages and results.
    pub fn file(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// A column; `None` if there is no such heading.
    ///
    /// # Errors
    /// A field that is no finite number.
    pub fn column(&self, heading: &str) -> Result<Option<Vec<f64>>, RadiometryError> {
        let Some(place) = self.headings.iter().position(|name| name == heading) else {
            return Ok(None);
        };
        let numbers = self.rows.iter().enumerate().map(|(row, record)| {
            let field = record.get(place).unwrap_or_default();
            match field.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                _ => Err(self.wrong(row, format!("{heading}: {field:?} is not a number"))),
            }
        });
        numbers.collect::<Result<_, _>>().map(Some)
    }

    /// A column that has to be there.
    pub fn needed(&self, heading: &str) -> Result<Vec<f64>, RadiometryError> {
        self.column(heading)?.ok_or_else(|| self.lacks(heading))
    }

    /// The column of a radiance in W m-2 sr-1 um-1, by its heading less the unit.
    pub fn radiance(&self, stem: &str) -> Result<Option<Vec<f64>>, RadiometryError> {
        for (unit, factor) in RADIANCE_UNITS {
            if let Some(values) = self.column(&format!("{stem}{unit}"))? {
                return Ok(Some(values.into_iter().map(|l| l * factor).collect()));
            }
        }
        Ok(None)
    }

    /// The column of a measured radiance, which may be below 0 by noise.
    pub fn measured_radiance(&self, stem: &str) -> Result<Vec<f64>, RadiometryError> {
        let wanted = || self.lacks(&format!("{stem}{}", RADIANCE_UNITS[0].0));
        self.radiance(stem)?.ok_or_else(wanted)
    }

    /// The column of a radiance that has to be there, 0 or more.
    pub fn needed_radiance(&self, stem: &str) -> Result<Vec<f64>, RadiometryError> {
        let l = self.measured_radiance(stem)?;
        match l.iter().position(|&l| l < 0.0) {
            Some(row) => Err(self.wrong(row, format!("{stem}: a radiance below 0"))),
            None => Ok(l),
        }
    }

    /// The wavelengths, um.
    ///
    /// # Errors
    /// One that is not above 0.
    pub fn wavelength_um(&self) -> Result<Vec<f64>, RadiometryError> {
        let um = self.needed("wavelength_um")?;
        match um.iter().position(|&um| um <= 0.0) {
            Some(row) => Err(self.wrong(row, format!("{} is not a wavelength in um", um[row]))),
            None => Ok(um),
        }
    }

    /// The wavelengths in ascending order, each once, and the rows that hold them.
    pub fn ascending_um(&self) -> Result<(Vec<f64>, Vec<usize>), RadiometryError> {
        let um = self.wavelength_um()?;
        let mut rows: Vec<usize> = (0..um.len()).collect();
        rows.sort_by(|&a, &b| um[a].total_cmp(&um[b]));
        if let Some(pair) = rows.windows(2).find(|pair| um[pair[0]] == um[pair[1]]) {
            let problem = format!("the wavelength {} um stands twice", um[pair[1]]);
            return Err(self.wrong(pair[1], problem));
        }
        Ok((rows.iter().map(|&row| um[row]).collect(), rows))
    }

    /// For what straight lines are drawn between.
    pub(super) fn two_at_least(&self, wavelength_um: &[f64]) -> Result<(), RadiometryError> {
        match wavelength_um.len() {
            0 | 1 => Err(self.wrong_file("there must be at least two wavelengths".into())),
            _ => Ok(()),
        }
    }

    /// An error in a row, counted from 0 below the headings.
    pub(super) fn wrong(&self, row: usize, problem: String) -> RadiometryError {
        let line = self.rows[row].position().map_or(0, csv::Position::line);
        RadiometryError::Form { path: self.path.clone(), line, problem }
    }

    pub(super) fn wrong_file(&self, problem: String) -> RadiometryError {
        let hint = "docs/radiometry.md shows the columns of each kind of file";
        RadiometryError::File { path: self.path.clone(), problem, hint }
    }

    fn lacks(&self, heading: &str) -> RadiometryError {
        let have: Vec<&str> = self.headings.iter().collect();
        self.wrong_file(format!("there is no column {heading}, but {}", have.join(", ")))
    }
}

/// On the straight line between the points on both sides of a place within the range; `x` ascending, two at least.
pub(super) fn on_line(x: &[f64], y: &[f64], at: f64) -> f64 {
    let above = x.partition_point(|&x| x < at).clamp(1, x.len() - 1);
    let share = (at - x[above - 1]) / (x[above] - x[above - 1]);
    y[above - 1] * (1.0 - share) + y[above] * share
}

/// Whether ascending wavelengths of a file hold all from one to another, um.
pub(super) fn covers(
    of: &str,
    wavelength_um: &[f64],
    wanted_um: [f64; 2],
) -> Result<(), RadiometryError> {
    let held_um = [wavelength_um[0], wavelength_um[wavelength_um.len() - 1]];
    if held_um[0] <= wanted_um[0] && wanted_um[1] <= held_um[1] {
        return Ok(());
    }
    Err(RadiometryError::Range { of: of.to_owned(), wanted_um, held_um })
}
