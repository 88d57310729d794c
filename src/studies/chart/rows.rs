//! `chart.csv`: a row for each setting, written here and read for settings measured elsewhere.

use std::path::Path;

use super::{Reference, Setting, Took};
use crate::support::csv::{Csv, decimals};
use crate::support::error::Failure;
use crate::support::file_error::FileError;

const HEADINGS: [&str; 10] = [
    "level",
    "setting",
    "repeats",
    "wall_s",
    "cpu_s",
    "rms_error",
    "worst_band_error",
    "bias",
    "reference_rms",
    "reference_worst_band",
];

/// Settings measured elsewhere cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct BesideError(#[from] FileError);

impl Failure for BesideError {
    fn hint(&self) -> Option<String> {
        let columns = HEADINGS.join(",");
        matches!(self.0, FileError::Wrong { .. })
            .then(|| format!("the file needs the columns of chart.csv: {columns}"))
    }
}

/// The settings as CSV; the errors are against that reference but of settings measured elsewhere.
pub fn csv(settings: &[Setting], reference: &Reference) -> String {
    let mut csv = Csv::new(&HEADINGS);
    for s in settings {
        let floors = s.elsewhere.unwrap_or([reference.floor(), reference.worst_floor()]);
        let numbers = [s.took.wall_s, s.took.cpu_s, s.rms, s.worst, s.bias, floors[0], floors[1]];
        let words = [s.level.clone(), s.setting.clone(), s.repeats.to_string()];
        csv.row(words.into_iter().chain(numbers.map(decimals)));
    }
    csv.text()
}

/// Reads settings that were measured by another program or on another machine.
///
/// # Errors
/// A file that cannot be read or has other columns; a row with an invalid number.
pub fn beside(path: &Path) -> Result<Vec<Setting>, BesideError> {
    let file = std::fs::File::open(path).map_err(FileError::read(path))?;
    let wrong = |line, problem: String| FileError::wrong_in_line(path, line, problem);
    let unreadable = |error: csv::Error| {
        wrong(error.position().map_or(1, csv::Position::line), error.to_string())
    };
    let mut reader = csv::Reader::from_reader(std::io::BufReader::new(file));
    if reader.headers().map_err(unreadable)? != HEADINGS.as_slice() {
        return Err(wrong(1, "the headings are not those of a chart.csv".into()).into());
    }
    let mut settings = Vec::new();
    for row in reader.records() {
        let row = row.map_err(unreadable)?;
        let line = row.position().map_or(1, csv::Position::line);
        settings.push(setting(&row).map_err(|problem| wrong(line, problem))?);
    }
    if settings.is_empty() {
        return Err(wrong(1, "there are no rows below the headings".into()).into());
    }
    Ok(settings)
}

fn setting(row: &csv::StringRecord) -> Result<Setting, String> {
    let wrong = |column: usize, wanted: &str| {
        format!("{} is {:?}, not {wanted}", HEADINGS[column], &row[column])
    };
    let number = |column: usize| {
        let read = row[column].parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
        read.ok_or_else(|| wrong(column, "a number of 0 or more"))
    };
    if row[0].is_empty() {
        return Err(wrong(0, "a name"));
    }
    let repeats = row[2].parse().ok().filter(|&repeats: &usize| repeats > 0);
    let took = Took { wall_s: number(3)?, cpu_s: number(4)? };
    if took.cpu_s == 0.0 {
        return Err(wrong(4, "a number above 0"));
    }
    Ok(Setting {
        level: row[0].into(),
        setting: row[1].into(),
        repeats: repeats.ok_or_else(|| wrong(2, "a whole number of 1 or more"))?,
        took,
        rms: number(5)?,
        worst: number(6)?,
        bias: number(7)?,
        elsewhere: Some([number(8)?, number(9)?]),
    })
}
