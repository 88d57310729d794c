//! Columns of text: wavelength and emissivity, or what the heading names.

use std::path::Path;

use super::dialect::Dialect;
use super::words::{self, Column, Said};
use super::{Reading, Tabulated, Unit, settled, text, unclear, wrong};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::{Row, Warning};
use crate::support::linear::{LIKELY_UM, span};

/// Marks of comments.
const COMMENTS: [&str; 5] = ["#", "%", "!", "//", "*"];

/// What stands in place of a value that is missing.
const MISSING: [&str; 9] = ["", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--"];

/// Whether a line is a comment. A semicolon may also stand after an empty first column.
fn is_comment(line: &str) -> bool {
    COMMENTS.iter().any(|mark| line.starts_with(mark))
        || line.strip_prefix(';').is_some_and(|rest| !rest.contains(';'))
}

/// Rows of a heading above its last: names and symbols, say.
const MOST_ROWS: usize = 3;

/// Words of the longest heading of two columns with blanks between them; what is longer is prose.
const MOST_WORDS: usize = 40;

/// What stands above the numbers.
struct Above<'a> {
    /// Lines of text, with their numbers from 1.
    lines: Vec<(usize, &'a str)>,
    /// The fields of the heading, and its line.
    heading: Option<(usize, Vec<String>)>,
}

/// Which columns are read, and what the heading says of them.
struct Columns {
    wavelength: usize,
    values: usize,
    unit: Option<Unit>,
    said: Option<Said>,
}

/// Tabs, semicolons, commas or blanks separate the columns. Lines that begin with # are comments;
/// other lines above the numbers are headings.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let text = text(path)?;
    let lines = || {
        let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
        lines.filter(|(_, line)| !line.trim_matches([',', ';']).is_empty())
    };
    let first = lines().filter(|(_, line)| !is_comment(line)).find_map(|(i, line)| {
        Dialect::of(line).map(|dialect| (i, dialect, dialect.fields(line).len()))
    });
    let Some((first, mut dialect, count)) = first else {
        return Err(wrong(path, 1, "no line of it is columns of numbers"));
    };
    // The first value may be missing.
    let widths =
        lines().skip_while(|(i, _)| *i < first).map(|(_, line)| dialect.fields(line).len());
    let count = if count == 1 { widths.take(3).max().unwrap_or(count) } else { count };
    let mut above = Above::new(lines().take_while(|(i, _)| *i < first).collect(), dialect, count);
    // Comments below say as much.
    above.lines.extend(lines().filter(|(i, line)| *i > first && is_comment(line)));
    let columns = above.columns(path, reading, count, first)?;
    let stated = match reading.unit.or(columns.unit) {
        None => above.unit(path)?,
        stated => stated,
    };
    let unit = stated.unwrap_or(Unit::Micrometre);
    let said = above.said(path, reading, &columns)?;
    let said_nothing = said.is_none();
    let quantity = settled(path, reading, said)?;
    let mut rows = Vec::new();
    let mut has_points = false;
    let counted = counted(&text, first);
    if let Some(rest) = counted.filter(|_| reading.quantity.is_none() && said_nothing) {
        let problem =
            format!("line {first} counts the {rest} lines below it; none names a quantity");
        return Err(unclear(path, problem));
    }
    let first = first + usize::from(counted.is_some());
    for (i, line) in lines().skip_while(|(i, _)| *i < first).filter(|(_, line)| !is_comment(line)) {
        let fields = dialect.fields(line);
        dialect.check(path, i, &fields, &mut has_points)?;
        let is_cut = fields.len() == columns.values && columns.wavelength < columns.values;
        if fields.len() != count && !is_cut {
            return Err(wrong(path, i, count_problem(fields.len(), count)));
        }
        let value = fields.get(columns.values).map_or("", |field| field);
        let texts = [&fields[columns.wavelength], value];
        let is_missing = MISSING.contains(&value.to_lowercase().as_str());
        let (x, value) = match texts.map(|text| dialect.number(text)) {
            [Some(x), _] if is_missing => (x, None),
            [Some(x), Some(value)] => (x, super::unless_deleted(value)),
            _ => {
                let problem = format!("{:?}, {:?} are not two numbers", texts[0], texts[1]);
                return Err(wrong(path, i, problem));
            }
        };
        rows.push(Row { line: i as u64, um: unit.um(x), value });
    }
    let values = rows.iter().filter_map(|row| row.value);
    super::refuse_small_percents(path, reading, quantity, values)?;
    let longest = rows.iter().map(|row| row.um).fold(0.0, f64::max);
    let mut spectrum = Tabulated::of_rows(path, rows, quantity, reading.range_um)?;
    if stated.is_none() && longest > LIKELY_UM[1] && spectrum.warnings.is_empty() {
        let held_um = span(spectrum.range_um());
        spectrum.warnings.push(Warning::UnlikelyWavelengths(held_um));
    }
    let bidirectional = above.lines.iter().find(|(_, line)| words::is_bidirectional(line));
    if let Some((_, line)) = bidirectional.filter(|_| quantity.is_reflectance()) {
        spectrum.warnings.push(Warning::Bidirectional(bare(line).to_owned()));
    }
    Ok(spectrum)
}

/// The lines below the first, if that counts them: so some libraries begin their files, and hold
/// reflectance.
fn counted(text: &str, first: usize) -> Option<usize> {
    let mut lines = text.lines().skip(first - 1);
    let count = lines.next()?.trim().parse().ok()?;
    (lines.filter(|line| !line.trim().is_empty()).count() == count).then_some(count)
}

fn count_problem(there: usize, needed: usize) -> String {
    format!("there are {there} columns where {needed} are needed")
}

/// A line without the mark of a comment.
fn bare(line: &str) -> &str {
    line.trim_start_matches(['#', '%', '!', '/', '*', ';', '"', ' ']).trim()
}

impl<'a> Above<'a> {
    fn new(lines: Vec<(usize, &'a str)>, dialect: Dialect, count: usize) -> Self {
        let fields = |line: &str| dialect.fields(line);
        let commented = is_comment;
        let Some(&(last, line)) = lines.last() else { return Self { lines, heading: None } };
        let heading = if commented(line) {
            // As numpy writes it. Most comments are prose.
            let fields = apart(&fields(bare(line)), count);
            let is_of = |field: &String| matches!(words::column(field), Column::Wavelength(_));
            let is_key = fields.first().is_some_and(|field| field.ends_with(':'));
            let is_heading = !is_key && fields.iter().any(&is_of) && !fields.iter().all(is_of);
            (fields.len() == count && is_heading).then_some(fields)
        } else {
            let mut heading = fields(line);
            // Units may be in a row of their own.
            let others = lines.iter().rev().skip(1).take(MOST_ROWS).map(|(_, line)| *line);
            for above in others.take_while(|line| !commented(line)).map(fields) {
                let is_complete = heading.iter().all(|f| words::column(f) != Column::Unknown);
                if is_complete || above.len() != heading.len() {
                    break;
                }
                heading = above.iter().zip(&heading).map(|(a, b)| format!("{a} {b}")).collect();
            }
            // One field is no heading of columns: a title, or a key with its value.
            Some(heading).filter(|fields| fields.len() > 1)
        };
        Self { lines, heading: heading.map(|fields| (last, fields)) }
    }

    /// The columns of wavelength and values, of so many.
    fn columns(
        &self,
        path: &Path,
        reading: &Reading,
        count: usize,
        first: usize,
    ) -> Result<Columns, SpectrumError> {
        let heading = self.heading.as_ref().map(|(i, fields)| (*i, apart(fields, count)));
        let Some((line, fields)) = heading else {
            if count != 2 {
                return Err(wrong(path, first, of_numbers(count)));
            }
            return Ok(Columns { wavelength: 0, values: 1, unit: None, said: None });
        };
        if fields.len() > count {
            let problem = format!(
                "the heading has {} columns, the numbers below it have {count}",
                fields.len()
            );
            return Err(wrong(path, line, problem));
        }
        let known: Vec<Column> = fields.iter().map(|field| words::column(field)).collect();
        let places = |is: fn(&Column) -> bool| -> Vec<usize> {
            (0..known.len()).filter(|&i| is(&known[i])).collect()
        };
        let wavelengths = places(|column| matches!(column, Column::Wavelength(_)));
        let unit_of = |i: usize| match known[i] {
            Column::Wavelength(unit) => unit,
            _ => None,
        };
        let wavelength = wavelengths.iter().copied().find(|&i| unit_of(i).is_some());
        let wavelength = wavelength.or(wavelengths.first().copied());
        let wavelength = wavelength.or((reading.unit.is_some() && count == 2).then_some(0));
        let Some(wavelength) = wavelength else {
            let problem =
                format!("the heading {:?} names no wavelength in a known unit", fields.join(", "));
            return Err(super::unclear_unit(path, line, problem));
        };
        let mut values = places(|column| matches!(column, Column::Values(_)));
        if values.is_empty() {
            values = places(|column| *column == Column::Unknown);
            values.retain(|&i| i != wavelength && !fields[i].is_empty());
        }
        let others = places(|column| *column == Column::Unknown);
        let unread = others.iter().any(|i| !values.contains(i) && !fields[*i].is_empty());
        let [values] = values[..] else {
            return Err(wrong(path, line, of_numbers(count)));
        };
        if unread && count > 2 || fields.len() < count {
            return Err(wrong(path, line, of_numbers(count)));
        }
        let said = match known[values] {
            Column::Values(said) => Some(said),
            _ => None,
        };
        if let (Some(Said::Transmission), false) = (said, reading.is_response) {
            let (path, said) = (path.to_owned(), fields.join(", "));
            return Err(SpectrumError::Transmission { path, said });
        }
        if let (Some(Said::Absorbance), false) = (said, reading.is_response) {
            return Err(SpectrumError::Absorbance {
                path: path.to_owned(),
                said: fields.join(", "),
            });
        }
        Ok(Columns { wavelength, values, unit: unit_of(wavelength), said })
    }

    /// Lines other than the heading: number, key, value and all of the line. Prose has no key.
    fn statements(&self) -> impl Iterator<Item = (usize, String, &'a str, &'a str)> + '_ {
        let heading = self.heading.as_ref().map(|(line, _)| *line);
        self.lines.iter().filter(move |(i, _)| Some(*i) != heading).map(|&(i, line)| {
            let line = bare(line);
            let (key, value) = line.split_once([':', '=']).unwrap_or(("", line));
            (i, key.to_lowercase().replace([' ', '_', '-'], ""), value.trim(), line)
        })
    }

    /// The unit that the lines above the heading name, if one.
    fn unit(&self, path: &Path) -> Result<Option<Unit>, SpectrumError> {
        let mut found: Option<Unit> = None;
        for (i, key, value, line) in self.statements() {
            let is_key = ["x", "xunit", "xunits", "xaxis", "abscissa"].contains(&key.as_str());
            let is_unit = ["unit", "units"].contains(&key.as_str())
                && matches!(words::column(value), Column::Wavelength(_));
            if !(is_key || is_unit || words::has_wavelength(line)) {
                continue;
            }
            // Beside wavelengths cm-1 may be a resolution.
            let unit = Unit::named(line)
                .filter(|unit| is_key || self.heading.is_none() || *unit != Unit::Wavenumber);
            if is_key && unit.is_none() && !value.is_empty() {
                let problem = format!("{value:?} is not a known unit of wavelength");
                return Err(super::unclear_unit(path, i, problem));
            }
            if let (Some(before), Some(unit)) = (found, unit)
                && before != unit
            {
                let problem = "it names another unit of wavelength than a line above";
                return Err(super::unclear_unit(path, i, problem));
            }
            found = found.or(unit);
        }
        Ok(found)
    }

    /// What heading and other lines say of the values.
    fn said(
        &self,
        path: &Path,
        reading: &Reading,
        columns: &Columns,
    ) -> Result<Option<(Said, String)>, SpectrumError> {
        let in_heading = columns.said.map(|said| (said, String::new()));
        if reading.quantity.is_some() || reading.is_response {
            return Ok(in_heading);
        }
        if let (Some(Said::Unclear), Some((_, fields))) = (columns.said, &self.heading) {
            let problem = format!(
                "the heading {:?} has a word or sign that may change its quantity",
                fields.join(", ")
            );
            return Err(unclear(path, problem));
        }
        let mut stated = Vec::new();
        let mut prose = Vec::new();
        for (i, key, value, line) in self.statements() {
            let keys = ["quantity", "y", "yunit", "yunits", "yaxis", "ordinate", "values"];
            if keys.contains(&key.as_str()) && !value.is_empty() {
                let Some(said) = words::said(value, true) else {
                    let problem = format!("line {i} names a quantity that is not known: {value:?}");
                    return Err(unclear(path, problem));
                };
                stated.push((said, value.to_owned()));
            } else if let Some(said) = words::said(line, false) {
                prose.push((said, line.to_owned()));
            }
        }
        let all_same = |all: &[(Said, String)]| {
            all.windows(2).all(|pair| pair[0].0 == pair[1].0)
                && all.iter().all(|(said, _)| *said != Said::Unclear)
        };
        let several = || unclear(path, "lines above the numbers name several quantities");
        stated.extend(in_heading);
        if !all_same(&stated) {
            return Err(several());
        }
        if let Some(said) = stated.into_iter().next() {
            return Ok(Some(said));
        }
        if !all_same(&prose) {
            return Err(several());
        }
        let has_heading =
            self.heading.is_some() || self.lines.iter().any(|(_, line)| !is_comment(line));
        match prose.into_iter().next() {
            None if has_heading => Err(unclear(
                path,
                format!(
                    "the heading {:?} names no known quantity",
                    self.heading.as_ref().map_or_else(
                        || self.lines.last().map_or("", |(_, line)| line).to_owned(),
                        |(_, fields)| fields.join(", ")
                    )
                ),
            )),
            said => Ok(said),
        }
    }
}

/// The fields of a heading. With blanks between columns, words of one field may stand apart.
fn apart(fields: &[String], count: usize) -> Vec<String> {
    if fields.len() <= count || count != 2 || fields.len() > MOST_WORDS {
        return fields.to_vec();
    }
    let is_wavelength =
        |part: &[String]| matches!(words::column(&part.join(" ")), Column::Wavelength(_));
    let end = (1..fields.len()).rev().find(|&end| is_wavelength(&fields[..end]));
    end.map_or(fields.to_vec(), |end| vec![fields[..end].join(" "), fields[end..].join(" ")])
}

fn of_numbers(count: usize) -> String {
    let more = if count == 4 {
        ": if the commas are decimals, separate the columns by semicolons"
    } else if count > 2 {
        ": leave out the others"
    } else {
        ""
    };
    format!("there are {count} columns where two are needed{more}")
}
