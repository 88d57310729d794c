//! `chart.csv`: a row for each setting, as it is written and as settings measured elsewhere are read.

use std::path::{Path, PathBuf};

use super::{Reference, Setting, Took};
use crate::support::csv::{Csv, decimals};
use crate::support::error::Failure;

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
/// Where the numbers of seconds and errors begin.
const FIRST_NUMBER: usize = 3;

/// Settings measured elsewhere cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BesideError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line of the file is wrong.
    #[error("{}, line {line}: {problem}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong there.
        problem: String,
    },
}

impl Failure for BesideError {
    fn hint(&self) -> Option<String> {
        let columns = HEADINGS.join(",");
        match self {
            Self::Read { .. } => None,
            Self::Form { .. } => {
                Some(format!("a file beside the chart has the columns of chart.csv: {columns}"))
            }
        }
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

/// Settings that were measured elsewhere, by another program or on another machine.
///
/// # Errors
/// A file that cannot be read or has other columns; a row with a number that none of its kind can be.
pub fn beside(path: &Path) -> Result<Vec<Setting>, BesideError> {
    let file = std::fs::File::open(path)
        .map_err(|source| BesideError::Read { path: path.to_owned(), source })?;
    let wrong = |line, problem| BesideError::Form { path: path.to_owned(), line, problem };
    let unreadable = |error: csv::Error| {
        wrong(error.position().map_or(1, csv::Position::line), error.to_string())
    };
    let mut reader = csv::Reader::from_reader(std::io::BufReader::new(file));
    if reader.headers().map_err(unreadable)? != HEADINGS.as_slice() {
        return Err(wrong(1, "the headings are not those of a chart.csv".into()));
    }
    let mut settings = Vec::new();
    for row in reader.records() {
        let row = row.map_err(unreadable)?;
        let line = row.position().map_or(1, csv::Position::line);
        settings.push(setting(&row).map_err(|problem| wrong(line, problem))?);
    }
    if settings.is_empty() {
        return Err(wrong(1, "there are no rows below the headings".into()));
    }
    Ok(settings)
}

fn setting(row: &csv::StringRecord) -> Result<Setting, String> {
    let wrong = |column: usize, wanted: &str| {
        format!("{} is {:?} and has to be {wanted}", HEADINGS[column], &row[column])
    };
    if row[0].is_empty() {
        return Err(wrong(0, "a name"));
    }
    let repeats = row[2].parse().ok().filter(|&repeats: &usize| repeats > 0);
    let mut numbers = [0.0; HEADINGS.len() - FIRST_NUMBER];
    for (place, number) in numbers.iter_mut().enumerate() {
        let column = FIRST_NUMBER + place;
        let read = row[column].parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
        *number = read.ok_or_else(|| wrong(column, "a number, not below 0"))?;
    }
    let [wall_s, cpu_s, rms, worst, bias, floor, worst_floor] = numbers;
    if cpu_s == 0.0 {
        return Err(wrong(4, "above 0"));
    }
    Ok(Setting {
        level: row[0].into(),
        setting: row[1].into(),
        repeats: repeats.ok_or_else(|| wrong(2, "a whole number from 1"))?,
        took: Took { wall_s, cpu_s },
        rms,
        worst,
        bias,
        elsewhere: Some([floor, worst_floor]),
    })
}
