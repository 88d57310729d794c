//! JCAMP-DX, the exchange format of spectrometers (McDonald & Wilks, Appl. Spectrosc. 42, 151-162,
//! 1988): labelled records, numbers plain (AFFN) or packed (ASDF).

use std::collections::HashMap;
use std::path::Path;

use super::words::{self, Said};
use super::{Reading, Tabulated, Unit, settled, text, unclear, unclear_unit, wrong};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::{Row, Warning};
use crate::support::file_error::FileError;

/// Whether a file is JCAMP-DX: it begins with `##TITLE=` or another of its records.
pub(super) fn is_one(text: &str) -> bool {
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let begins = lines.next().and_then(record).is_some();
    let of_it = ["JCAMPDX", "JCAMP", "XYDATA", "XYPOINTS", "NTUPLES", "PEAKTABLE"];
    begins && text.lines().filter_map(record).any(|(label, _)| of_it.contains(&label.as_str()))
}

/// Label and value of a line that begins a record. Labels have no case, blanks or marks.
fn record(line: &str) -> Option<(String, &str)> {
    let (label, value) = line.trim_start().strip_prefix("##")?.split_once('=')?;
    let label: String = label.chars().filter(char::is_ascii_alphanumeric).collect();
    Some((label.to_uppercase(), value.trim()))
}

/// The form of a table, with its line, and the lines of its numbers.
type Table<'a> = (usize, String, Vec<(usize, &'a str)>);

/// A block: its records with their lines, and the lines of its table.
#[derive(Default)]
struct Block<'a> {
    records: HashMap<String, (usize, &'a str)>,
    table: Option<Table<'a>>,
}

/// Reads every spectrum of a file; a file of several has a block for each.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Vec<Tabulated>, SpectrumError> {
    let text = text(path)?;
    let mut blocks: Vec<Block> = Vec::new();
    let mut is_in_table = false;
    for (i, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line)) {
        let line = line.split("$$").next().unwrap_or_default().trim();
        let Some((label, value)) = record(line) else {
            let table = blocks.last_mut().and_then(|block| block.table.as_mut());
            if let Some((.., lines)) = table.filter(|_| is_in_table && !line.is_empty()) {
                lines.push((i, line));
            }
            continue;
        };
        if label == "TITLE" || blocks.is_empty() {
            blocks.push(Block::default());
        }
        let block = blocks.last_mut().expect("one was begun");
        is_in_table = ["XYDATA", "XYPOINTS"].contains(&label.as_str());
        if ["NTUPLES", "DATATABLE", "PEAKTABLE", "PEAKASSIGNMENTS"].contains(&label.as_str()) {
            let problem = format!("JCAMP-DX with {label} is not read, but XYDATA and XYPOINTS are");
            return Err(FileError::wrong_in_line(path, i as u64, problem)
                .with_hint("export the spectrum as XYDATA, or as two columns of text")
                .into());
        }
        if is_in_table {
            let form = value.chars().filter(|c| !c.is_whitespace()).collect::<String>();
            block.table = Some((i, form.to_uppercase(), Vec::new()));
        } else {
            block.records.entry(label).or_insert((i, value));
        }
    }
    let spectra = blocks.iter().filter(|block| block.table.is_some());
    let spectra: Vec<Tabulated> =
        spectra.map(|block| block.spectrum(path, reading)).collect::<Result<_, _>>()?;
    if spectra.is_empty() {
        return Err(FileError::wrong(path, "JCAMP-DX without XYDATA or XYPOINTS").into());
    }
    Ok(spectra)
}

impl Block<'_> {
    fn get(&self, label: &str) -> Option<(usize, &str)> {
        self.records.get(label).copied().filter(|(_, value)| !value.is_empty())
    }

    fn number(&self, path: &Path, label: &str) -> Result<Option<f64>, SpectrumError> {
        let parsed = |(i, value): (usize, &str)| super::number(path, i, value);
        self.get(label).map(parsed).transpose()
    }

    fn spectrum(&self, path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
        let (table_line, form, lines) = self.table.as_ref().expect("it has a table");
        let (x_line, x_units) = self.get("XUNITS").unwrap_or((*table_line, ""));
        let unit = reading.unit.or_else(|| Unit::named(x_units)).ok_or_else(|| {
            unclear_unit(path, x_line, format!("XUNITS {x_units:?} are not known"))
        })?;
        let y_units = self.get("YUNITS").map_or("", |(_, value)| value);
        let said = words::said(y_units, true).map(|said| (said, y_units.to_owned()));
        if said.is_none() && reading.quantity.is_none() {
            return Err(unclear(path, format!("YUNITS {y_units:?} name no known quantity")));
        }
        if let Some((Said::Transmission | Said::Absorbance, _)) = said {
            settled(path, &Reading::default(), said.clone())?;
        }
        let quantity = settled(path, reading, said)?;
        let points = match form.as_str() {
            "(XY..XY)" => pairs(path, lines)?,
            "(X++(Y..Y))" => self.steps(path, lines)?,
            _ => {
                let problem = format!("a table of the form {form} is not read");
                return Err(wrong(path, *table_line, problem));
            }
        };
        let factor = |label| Ok::<_, SpectrumError>(self.number(path, label)?.unwrap_or(1.0));
        let (x_factor, y_factor) = (factor("XFACTOR")?, factor("YFACTOR")?);
        // The X of steps is in units of XUNITS already.
        let x_factor = if form.starts_with("(XY") { x_factor } else { 1.0 };
        if let Some((i, count)) = self.get("NPOINTS")
            && count.parse::<f64>().is_ok_and(|count| count != points.len() as f64)
        {
            let problem = format!("{count} points are announced, {} are there", points.len());
            return Err(wrong(path, i, problem));
        }
        if let (Some(stated), Some(&(line, _, Some(first)))) =
            (self.number(path, "FIRSTY")?, points.first())
        {
            // Some programs write it without the factor, and all round it.
            let most =
                points.iter().filter_map(|point| point.2).fold(0.0, |m: f64, y| m.max(y.abs()));
            let is_near = |y: f64, most: f64| (y - stated).abs() <= 0.01 * y.abs() + 1e-3 * most;
            if !is_near(first, most) && !is_near(first * y_factor, (most * y_factor).abs()) {
                let found = first * y_factor;
                let problem =
                    format!("FIRSTY is {stated}, but by YFACTOR the first value is {found}");
                return Err(wrong(path, line, problem));
            }
        }
        let row = |(line, x, y): (usize, f64, Option<f64>)| Row {
            line: line as u64,
            um: unit.um(x * x_factor),
            value: y.map(|y| y * y_factor),
        };
        let rows: Vec<Row> = points.into_iter().map(row).collect();
        let values = rows.iter().filter_map(|row| row.value);
        super::refuse_small_percents(path, reading, quantity, values)?;
        let mut spectrum = Tabulated::of_rows(path, rows, quantity, reading.range_um)?;
        spectrum.name = self.get("TITLE").map(|(_, title)| title.to_owned());
        if quantity.is_reflectance() {
            spectrum.warnings.push(Warning::GeometryNotStated);
        }
        Ok(spectrum)
    }

    /// Points at equal steps. Each line begins with its X, in units of XFACTOR.
    fn steps(
        &self,
        path: &Path,
        lines: &[(usize, &str)],
    ) -> Result<Vec<(usize, f64, Option<f64>)>, SpectrumError> {
        let x_factor = self.number(path, "XFACTOR")?.unwrap_or(1.0);
        let (xs, ys) = unpacked(path, lines)?;
        let starts: Vec<(usize, f64)> = xs.iter().map(|&(at, x)| (at, x * x_factor)).collect();
        if ys.len() == starts.len() {
            // A point a line: its X is there.
            let points = ys.iter().zip(&starts).map(|(&(line, y), &(_, x))| (line, x, y));
            return Ok(points.collect());
        }
        let ends = [self.number(path, "FIRSTX")?, self.number(path, "LASTX")?];
        let steps = (ys.len().max(2) - 1) as f64;
        let (first, step) = match (ends, self.number(path, "DELTAX")?, &starts[..]) {
            ([Some(first), Some(last)], ..) => (first, (last - first) / steps),
            (_, Some(step), [(_, first), ..]) => (*first, step),
            (_, None, [(_, first), .., (at, last)]) => (*first, (last - first) / *at as f64),
            _ => return Err(FileError::wrong(path, "it has neither LASTX nor DELTAX").into()),
        };
        // Lines round their X, by no more than a step and a few units of the last digit.
        for &(at, x) in &starts {
            let line = ys[at].0;
            let expected = first + step * at as f64;
            let off = (x - expected).abs();
            if off.is_nan() || off > step.abs() + 1e-5 * x.abs() {
                let problem = format!(
                    "the line begins at X = {x}, but by FIRSTX, LASTX and the number of points it \
                     is {expected}"
                );
                return Err(wrong(path, line, problem));
            }
        }
        let x = |at: usize| first + step * at as f64;
        Ok(ys.iter().enumerate().map(|(at, &(line, y))| (line, x(at), y)).collect())
    }
}

/// Points of X and Y, separated by commas, semicolons or blanks.
fn pairs(
    path: &Path,
    lines: &[(usize, &str)],
) -> Result<Vec<(usize, f64, Option<f64>)>, SpectrumError> {
    let mut points = Vec::new();
    for &(i, line) in lines {
        let fields: Vec<&str> =
            line.split([',', ';', ' ', '\t']).filter(|field| !field.is_empty()).collect();
        for pair in fields.chunks(2) {
            let [x, y] = pair else {
                return Err(wrong(path, i, "an X has no Y"));
            };
            let y = if *y == "?" { None } else { Some(super::number(path, i, y)?) };
            points.push((i, super::number(path, i, x)?, y));
        }
    }
    Ok(points)
}

/// The X of each line with the place of its first Y, and each Y with its line.
type Unpacked = (Vec<(usize, f64)>, Vec<(usize, Option<f64>)>);

/// Numbers of lines of X and Y..Y, plain or packed. A difference (DIF) at the end of a line makes
/// the first Y of the next a check, not a point.
fn unpacked(path: &Path, lines: &[(usize, &str)]) -> Result<Unpacked, SpectrumError> {
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    let mut ended_by_difference = false;
    for &(i, line) in lines {
        let wrong = |problem: String| wrong(path, i, problem);
        let fields = numbers(line).map_err(wrong)?;
        let mut fields = fields.into_iter();
        let Some(Packed::Number(x)) = fields.next() else {
            return Err(wrong("the line does not begin with X".into()));
        };
        let before = ys.last().and_then(|&(_, y): &(usize, Option<f64>)| y);
        let start = ys.len();
        let mut last = before;
        let mut difference = None;
        for field in fields {
            match field {
                Packed::Number(y) => {
                    (last, difference) = (Some(y), None);
                    ys.push((i, last));
                }
                Packed::Unknown => {
                    (last, difference) = (None, None);
                    ys.push((i, None));
                }
                Packed::Difference(d) => {
                    let y = last.ok_or_else(|| wrong("a difference follows no number".into()))?;
                    (last, difference) = (Some(y + d), Some(d));
                    ys.push((i, last));
                }
                Packed::Times(times) => {
                    if ys.len() == start || times > 1_000_000 {
                        return Err(wrong("a repetition follows no number".into()));
                    }
                    for _ in 1..times {
                        last = last.map(|y| y + difference.unwrap_or(0.0));
                        ys.push((i, last));
                    }
                }
            }
        }
        if ended_by_difference && ys.len() > start {
            let (_, check) = ys.remove(start);
            if check != before {
                let problem = "the line does not begin with the last value of the line before";
                return Err(wrong(problem.into()));
            }
        }
        if ys.len() > start {
            // X stands for the check, if there is one.
            xs.push((start - usize::from(ended_by_difference), x));
        }
        ended_by_difference = difference.is_some();
    }
    Ok((xs, ys))
}

/// A number of a line.
enum Packed {
    Number(f64),
    /// It is added to the number before (DIF).
    Difference(f64),
    /// The number or difference before is there so many times (DUP).
    Times(usize),
    Unknown,
}

/// The numbers of a line. Packed ones (SQZ, DIF, DUP) have a letter for sign and first digit.
fn numbers(line: &str) -> Result<Vec<Packed>, String> {
    let mut found = Vec::new();
    let mut rest = line.trim_start();
    while let Some(first) = rest.chars().next() {
        let after = &rest[first.len_utf8()..];
        if first == '?' {
            found.push(Packed::Unknown);
            rest = after.trim_start_matches([' ', '\t', ',']);
            continue;
        }
        let is_of = |from: char, to: char| (from..=to).contains(&first).then_some(first as u8);
        let digit = |letter: u8, from: char| i32::from(letter - from as u8) + 1;
        // Sign and first digit, and which kind of number it is.
        let (packed, lead) = if first == '@' || first == '%' {
            (Some(if first == '@' { 'S' } else { 'D' }), "0".to_owned())
        } else if let Some(letter) = is_of('A', 'I') {
            (Some('S'), digit(letter, 'A').to_string())
        } else if let Some(letter) = is_of('a', 'i') {
            (Some('S'), (-digit(letter, 'a')).to_string())
        } else if let Some(letter) = is_of('J', 'R') {
            (Some('D'), digit(letter, 'J').to_string())
        } else if let Some(letter) = is_of('j', 'r') {
            (Some('D'), (-digit(letter, 'j')).to_string())
        } else if let Some(letter) = is_of('S', 'Z') {
            (Some('U'), digit(letter, 'S').to_string())
        } else if first == 's' {
            (Some('U'), "9".to_owned())
        } else {
            (None, first.to_string())
        };
        let bytes = after.as_bytes();
        let is_exponent = |at: usize| {
            packed.is_none()
                && matches!(bytes[at], b'E' | b'e')
                && bytes.get(at + 1).is_some_and(|b| b"+-".contains(b))
        };
        let mut end = 0;
        while end < bytes.len() {
            let follows_exponent = end > 0 && b"+-".contains(&bytes[end]) && is_exponent(end - 1);
            if !(bytes[end].is_ascii_digit()
                || bytes[end] == b'.'
                || is_exponent(end)
                || follows_exponent)
            {
                break;
            }
            end += 1;
        }
        let text = lead + &after[..end];
        let number: f64 =
            text.parse().map_err(|_| format!("{:?} is not a number", rest.trim_end()))?;
        found.push(match packed {
            Some('D') => Packed::Difference(number),
            Some('U') => Packed::Times(number as usize),
            _ => Packed::Number(number),
        });
        rest = after[end..].trim_start_matches([' ', '\t', ',']);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ys(lines: &[&str]) -> Result<Vec<Option<f64>>, SpectrumError> {
        let lines: Vec<(usize, &str)> = (1..).zip(lines.iter().copied()).collect();
        Ok(unpacked(Path::new("x.dx"), &lines)?.1.into_iter().map(|(_, y)| y).collect())
    }

    /// The example of the format's paper, in each of its forms.
    #[test]
    fn packed_and_plain_numbers_are_the_same() {
        let plain = [0.0, 1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 0.0, -1.0, -2.0, -3.0].map(Some);
        for lines in [
            &["1 0 1 2 3 3 2 1 0 -1 -2 -3"][..],
            &["1+0+1+2+3+3+2+1+0-1-2-3"],
            &["1@ABCCBA@abc"],
            &["1@JJJ%jjjjjj"],
            &["1@JU%jX"],
            &["1@JJJ", "4C%jjjjjj"],
        ] {
            assert_eq!(ys(lines).expect("sound"), plain, "{lines:?}");
        }
        assert_eq!(ys(&["400,1.5E-2,2e+1?"]).expect("sound"), [Some(0.015), Some(20.0), None]);
        assert_eq!(ys(&["9J12"]).ok(), None, "a difference of nothing");
        for lines in [&["1@J", "2D"][..], &["1 x"], &["1S"], &["?"]] {
            assert!(ys(lines).is_err(), "{lines:?}");
        }
    }
}
