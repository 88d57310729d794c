//! Output of the radiative-transfer programs MODTRAN and libRadtran, as the columns of our files.

use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

use crate::support::file_error::FileError;

/// What a file says, by columns of our own: wavelength, um, and those that it has of the others.
pub(super) struct Model {
    pub headings: Vec<&'static str>,
    /// Rows with their lines, counted from 1.
    pub rows: Vec<(u64, Vec<f64>)>,
}

const UM: &str = "wavelength_um";
const TRANSMITTANCE: &str = "transmittance";
const PATH: &str = "l_path_w_m2_sr_um";
const SKY: &str = "l_downwelling_w_m2_sr_um";

/// W cm-2 in W m-2.
const PER_CM2: f64 = 1e4;

/// Factor from radiance per cm-1 to radiance per um, at a wavenumber in cm-1: a micrometre has
/// nu^2 / 10^4 of them.
fn per_um(wavenumber: f64) -> f64 {
    wavenumber * wavenumber / 1e4
}

fn um_of(wavenumber: f64) -> f64 {
    1e4 / wavenumber
}

/// The content of a file, if it is of one of these programs.
pub(super) fn read(path: &Path, text: &str) -> Option<Result<Model, FileError>> {
    tape7(path, text).or_else(|| libradtran(path, text))
}

/// Names of tape7's columns, as MODTRAN 4 writes them; later versions join them by underscores.
const NAMES: [&str; 13] = [
    "TOT TRANS",
    "PTH THRML",
    "THRML SCT",
    "SURF EMIS",
    "SOL SCAT",
    "SING SCAT",
    "SNGL SCAT",
    "GRND RFLT",
    "DRCT RFLT",
    "TOTAL RAD",
    "REF SOL",
    "DIR EM",
    "TOA SUN",
];

/// MODTRAN's tape7: by wavenumber, cm-1; radiance in W cm-2 sr-1 per cm-1.
fn tape7(path: &Path, text: &str) -> Option<Result<Model, FileError>> {
    let is_heading = |line: &str| {
        let mut words = line.split_whitespace();
        words.next() == Some("FREQ") && line.contains("TRANS")
    };
    let headings = text.lines().position(is_heading)?;
    let hint = "docs/guide/atmospheres.md shows the runs of MODTRAN that give sky and atmosphere";
    let wrong = |problem: String| Some(Err(FileError::wrong(path, problem).with_hint(hint)));
    if text.lines().skip(headings + 1).any(is_heading) {
        return wrong("this tape7 has several runs: give a file for each".into());
    }
    let mut heading = text.lines().nth(headings)?.to_owned();
    for name in NAMES {
        heading = heading.replace(name, &name.replace(' ', "_"));
    }
    let names = words(&heading);
    let place = |name: &str| names.iter().position(|(word, _)| *word == name);
    let [Some(trans), Some(thermal), Some(total)] =
        ["TOT_TRANS", "PTH_THRML", "TOTAL_RAD"].map(place)
    else {
        return wrong("this tape7 has no radiance: run MODTRAN with IEMSCT 1 or 2".into());
    };
    let mut rows = Vec::new();
    for (number, line) in text.lines().enumerate().skip(headings + 1) {
        let words = words(line);
        let Some(first) = words.first().and_then(|(word, _)| word.parse::<f64>().ok()) else {
            // Later versions have a second line of headings.
            if rows.is_empty() || line.trim().is_empty() {
                continue;
            }
            return Some(Err(not_numbers(path, number)));
        };
        if first < 0.0 {
            break;
        }
        let mut values = vec![0.0; names.len()];
        for (i, (word, span)) in words.iter().enumerate() {
            // Thermal runs leave the columns of the sun blank.
            let of = if words.len() == names.len() { Some(i) } else { nearest(&names, span) };
            match (of, word.parse::<f64>()) {
                (Some(of), Ok(value)) => values[of] = value,
                _ => return Some(Err(not_numbers(path, number))),
            }
        }
        let scattered = place("SOL_SCAT").map_or(0.0, |place| values[place]);
        let factor = PER_CM2 * per_um(first);
        let row = vec![
            um_of(first),
            values[trans],
            factor * (values[thermal] + scattered),
            factor * values[total],
        ];
        rows.push((number as u64 + 1, row));
    }
    Some(Ok(Model { headings: vec![UM, TRANSMITTANCE, PATH, SKY], rows }))
}

/// The heading over a number: both end near the same place.
fn nearest(names: &[(&str, Range<usize>)], span: &Range<usize>) -> Option<usize> {
    (0..names.len()).min_by_key(|&i| names[i].1.end.abs_diff(span.end))
}

/// The words of a line and their places.
fn words(line: &str) -> Vec<(&str, Range<usize>)> {
    let of = |word: &str| word.as_ptr() as usize - line.as_ptr() as usize;
    line.split_whitespace().map(|word| (word, of(word)..of(word) + word.len())).collect()
}

/// uvspec's output, below comments that repeat its options `output_user` and `output_process`.
fn libradtran(path: &Path, text: &str) -> Option<Result<Model, FileError>> {
    let option = |name: &str| {
        let comments = text.lines().filter_map(|line| line.trim().strip_prefix('#'));
        let mut of = comments.filter_map(|line| {
            let mut words = line.split_whitespace();
            (words.next() == Some(name)).then(|| words.map(str::to_owned).collect::<Vec<_>>())
        });
        of.next()
    };
    let names = option("output_user")?;
    let hint = "docs/guide/atmospheres.md shows the options of uvspec that give sky and atmosphere";
    let wrong = |problem: String| Some(Err(FileError::wrong(path, problem).with_hint(hint)));
    let process = option("output_process").map(|words| words.join(" "));
    let is_per_nm = match process.as_deref() {
        Some("per_nm") => true,
        // The default of thermal runs.
        Some("per_cm-1") | None => false,
        Some(other) => {
            return wrong(format!("output_process {other} gives no spectrum: per_nm does"));
        }
    };
    let place = |known: &[&str]| names.iter().position(|name| known.contains(&&**name));
    let Some(um) = place(&["lambda", "wavelength"]) else {
        return wrong("output_user has no column lambda".into());
    };
    let columns = [
        (TRANSMITTANCE, place(&["transmittance"]), 1.0),
        (PATH, place(&["uu_path"]), 1.0),
        (SKY, place(&["uu"]), 1.0),
        (SKY, place(&["edn"]).filter(|_| place(&["uu"]).is_none()), 1.0 / PI),
    ];
    let columns: Vec<(&str, usize, f64)> =
        columns.into_iter().filter_map(|(to, from, factor)| Some((to, from?, factor))).collect();
    if columns.is_empty() {
        return wrong("output_user has none of the columns uu, edn, transmittance, uu_path".into());
    }
    let mut rows = Vec::new();
    for (number, line) in text.lines().enumerate() {
        if line.trim().is_empty() || line.trim().starts_with('#') {
            continue;
        }
        let values: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let values = match values {
            Ok(values) if values.len() == names.len() => values,
            Ok(values) => {
                let [has, wanted] = [values.len(), names.len()];
                let problem = format!("{has} columns, but output_user names {wanted}");
                return Some(Err(FileError::wrong_in_line(path, number as u64 + 1, problem)));
            }
            Err(_) => return Some(Err(not_numbers(path, number))),
        };
        let um = values[um] / 1e3;
        let factor = if is_per_nm { 1e3 } else { per_um(um_of(um)) };
        let of = |&(to, from, by): &(&str, usize, f64)| {
            values[from] * by * if to == TRANSMITTANCE { 1.0 } else { factor }
        };
        let row = [um].into_iter().chain(columns.iter().map(of)).collect();
        rows.push((number as u64 + 1, row));
    }
    let headings = [UM].into_iter().chain(columns.iter().map(|(to, ..)| *to)).collect();
    Some(Ok(Model { headings, rows }))
}

fn not_numbers(path: &Path, line: usize) -> FileError {
    FileError::wrong_in_line(path, line as u64 + 1, "these are not numbers")
}
