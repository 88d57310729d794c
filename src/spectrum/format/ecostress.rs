//! Text of the ECOSTRESS spectral library, formerly ASTER's.

use std::collections::HashMap;
use std::path::Path;

use super::{Quantity, Reading, Tabulated, Unit, refuse_transmission, row, text, wrong};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;

/// Lines "Key: value" up to an empty one, then two columns.
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
            .ok_or_else(|| wrong(path, i, format!("{line:?} is no \"Key: value\"")))?;
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
        .ok_or_else(|| wrong(path, x_line, format!("X Units {x_units:?} are not known")))?;
    // Some files spell it "Reflectence".
    let quantity = reading
        .quantity
        .or_else(|| Quantity::named(&y_units.to_lowercase().replace("reflectence", "reflectance")))
        .ok_or_else(|| wrong(path, y_line, format!("Y Units {y_units:?} are not known")))?;
    for (i, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        rows.push(row(path, i, unit, &line.split_whitespace().collect::<Vec<_>>())?);
    }
    let (count_line, count) = get("number of x values");
    if count.parse::<usize>().is_ok_and(|count| count != rows.len()) {
        return Err(wrong(
            path,
            count_line,
            format!("{count} values are announced, {} are there", rows.len()),
        ));
    }
    let mut spectrum = Tabulated::new(path, rows, quantity, reading.range_um)?;
    // Samples of one mineral differ in size and number only.
    let parts = ["name", "particle size", "sample no."].map(|key| get(key).1);
    spectrum.name =
        Some(parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" "));
    if quantity != Quantity::Emissivity {
        spectrum.warnings.extend(geometry(measurement));
    }
    Ok(spectrum)
}

/// What the way of measuring means for Kirchhoff's law.
fn geometry(measurement: &str) -> Option<Warning> {
    let said = measurement.to_lowercase();
    if ["bidirectional", "bi-directional", "biconical", "bi-conical"]
        .iter()
        .any(|g| said.contains(g))
    {
        Some(Warning::Bidirectional(measurement.to_owned()))
    } else if said.contains("hemispherical") {
        None
    } else {
        Some(Warning::GeometryNotStated)
    }
}
