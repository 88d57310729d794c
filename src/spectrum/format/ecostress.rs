//! Text of the ECOSTRESS (formerly ASTER) spectral library.

use std::path::Path;

use super::words::{self, Said};
use super::{
    Reading, Row, Tabulated, Unit, refuse_no_emissivity, row, text, unclear, unclear_unit, wrong,
};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;

/// Keys of the header. Other lines continue the value above them.
const KEYS: [&str; 20] = [
    "name",
    "type",
    "class",
    "subclass",
    "particle size",
    "sample no.",
    "owner",
    "wavelength range",
    "origin",
    "collection date",
    "phase",
    "description",
    "measurement",
    "first column",
    "second column",
    "x units",
    "y units",
    "first x value",
    "last x value",
    "number of x values",
];
/// The last key, which some files leave out.
const LAST: &str = "additional information";

/// Key and value of a line that has one of the header's keys.
fn pair(line: &str) -> Option<(&'static str, &str)> {
    let (key, value) = line.split_once(':')?;
    let key = key.trim().to_lowercase();
    let known = KEYS.iter().chain([&LAST]).find(|known| ***known == key)?;
    Some((known, value.trim()))
}

/// Whether a file begins with such a header.
pub(super) fn is_header(text: &str) -> bool {
    let first = text.lines().find(|line| !line.trim().is_empty());
    first.and_then(pair).is_some_and(|(key, _)| key == "name")
        && text.lines().filter_map(pair).any(|(key, _)| ["x units", "y units"].contains(&key))
}

/// Reads lines "Key: value", which other lines may continue, then two columns.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let text = text(path)?;
    let lines: Vec<(usize, &str)> = (1..).zip(text.lines()).collect();
    let mut header = Vec::new();
    let mut end = 0;
    for (at, &(i, line)) in lines.iter().enumerate() {
        if let Some((key, value)) = pair(line) {
            header.push((key, i, value));
            end = at + 1;
        }
    }
    let get = |key: &str| {
        let found = header.iter().find(|(name, _, value)| *name == key && !value.is_empty());
        found.map_or((1, ""), |&(_, i, value)| (i, value))
    };
    let (_, measurement) = get("measurement");
    let (_, y_units) = get("y units");
    for (key, _, value) in &header {
        if ["measurement", "y units"].contains(key) {
            refuse_no_emissivity(path, value)?;
        }
    }
    let (x_line, x_units) = get("x units");
    let unit = reading
        .unit
        .or_else(|| Unit::named(x_units))
        .ok_or_else(|| unclear_unit(path, x_line, format!("X Units {x_units:?} are unknown")))?;
    let quantity = reading.quantity.or_else(|| match words::said(y_units, true) {
        Some(Said::Quantity(quantity)) => Some(quantity),
        _ => None,
    });
    let quantity =
        quantity.ok_or_else(|| unclear(path, format!("Y Units {y_units:?} are unknown")))?;
    // Emissivity may come of a measured reflectance, but not the other way round.
    if reading.quantity.is_none()
        && let Some(Said::Quantity(measured)) = words::said(measurement, false)
        && quantity.is_reflectance()
        && !measured.is_reflectance()
    {
        let problem = format!("Measurement is {measurement:?}, but Y Units are {y_units:?}");
        return Err(unclear(path, problem));
    }
    let starts_with_number =
        |line: &str| line.split_whitespace().next().is_some_and(|word| word.parse::<f64>().is_ok());
    let rows = lines[end..].iter().skip_while(|(_, line)| !starts_with_number(line));
    // The order of the columns is stated too.
    let is_turned = get("first column").1.eq_ignore_ascii_case("y");
    let rows: Vec<Row> = rows
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|&(i, line)| {
            let mut fields: Vec<&str> = line.split_whitespace().collect();
            if is_turned {
                fields.reverse();
            }
            row(path, i, unit, &fields)
        })
        .collect::<Result<_, _>>()?;
    let (count_line, count) = get("number of x values");
    if count.parse::<usize>().is_ok_and(|count| count != rows.len()) {
        let problem = format!("{count} values are announced, {} are there", rows.len());
        return Err(wrong(path, count_line, problem));
    }
    let values = rows.iter().filter_map(|row| row.value);
    super::refuse_small_percents(path, reading, quantity, values)?;
    let mut spectrum = Tabulated::of_rows(path, rows, quantity, reading.range_um)?;
    // Samples of one mineral differ only in size and number.
    let parts = ["name", "particle size", "sample no."].map(|key| get(key).1);
    spectrum.name =
        Some(parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" "));
    if quantity.is_reflectance() {
        spectrum.warnings.extend(geometry(measurement));
    }
    Ok(spectrum)
}

/// The warning that a geometry of measurement needs, if any.
fn geometry(measurement: &str) -> Option<Warning> {
    if words::is_bidirectional(measurement) {
        return Some(Warning::Bidirectional(measurement.to_owned()));
    }
    let is_stated = measurement.to_lowercase().contains("hemispherical");
    (!is_stated).then_some(Warning::GeometryNotStated)
}
