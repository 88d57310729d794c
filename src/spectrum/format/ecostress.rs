//! Text of the ECOSTRESS (formerly ASTER) spectral library.

use std::collections::HashMap;
use std::path::Path;

use super::{Quantity, Reading, Tabulated, Unit, refuse_transmission, row, text, wrong};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;

/// Reads lines "Key: value" up to an empty one, then two columns.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let text = text(path)?;
    let mut header = HashMap::new();
    let mut rows = Vec::new();
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    for (i, line) in lines.by_ref() {
        if line.trim().is_empty() {
            break;
        }
        let (key, value) = line
            .split_once(':')
            .ok_or_else(|| wrong(path, i, format!("{line:?} is not \"Key: value\"")))?;
        header.insert(key.trim().to_lowercase(), (i, value.trim()));
    }
    let get = |key: &str| header.get(key).copied().unwrap_or((1, ""));
    let (_, measurement) = get("measurement");
    let (y_line, y_units) = get("y units");
    for label in [y_units, measurement] {
        refuse_transmission(path, label)?;
    }
    let (x_line, x_units) = get("x units");
    let unit = Unit::named(x_units)
        .ok_or_else(|| wrong(path, x_line, format!("X Units {x_units:?} are unknown")))?;
    // Some files spell it "Reflectence".
    let quantity = reading
        .quantity
        .or_else(|| Quantity::named(&y_units.to_lowercase().replace("reflectence", "reflectance")))
        .ok_or_else(|| wrong(path, y_line, format!("Y Units {y_units:?} are unknown")))?;
    for (i, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        rows.push(row(path, i, unit, &line.split_whitespace().collect::<Vec<_>>())?);
    }
    let (count_line, count) = get("number of x values");
    if count.parse::<usize>().is_ok_and(|count| count != rows.len()) {
        let problem = format!("{count} values are announced, {} are there", rows.len());
        return Err(wrong(path, count_line, problem));
    }
    let mut spectrum = Tabulated::of_rows(path, rows, quantity, reading.range_um)?;
    // Samples of one mineral differ only in size and number.
    let parts = ["name", "particle size", "sample no."].map(|key| get(key).1);
    spectrum.name =
        Some(parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" "));
    if quantity != Quantity::Emissivity {
        spectrum.warnings.extend(geometry(measurement));
    }
    Ok(spectrum)
}

/// The warning that a geometry of measurement needs, if any.
fn geometry(measurement: &str) -> Option<Warning> {
    let said = measurement.to_lowercase();
    let bi = ["bidirectional", "bi-directional", "biconical", "bi-conical"];
    if bi.iter().any(|geometry| said.contains(geometry)) {
        Some(Warning::Bidirectional(measurement.to_owned()))
    } else {
        (!said.contains("hemispherical")).then_some(Warning::GeometryNotStated)
    }
}
