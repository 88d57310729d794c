//! Two columns of text: wavelength and emissivity, or what the heading names.

use std::path::Path;

use super::{Quantity, Reading, Tabulated, Unit, refuse_transmission, row, text, wrong};
use crate::spectrum::SpectrumError;

/// Commas, semicolons or white space separate the columns. Lines that begin with # are comments;
/// the first other line may be a heading.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let text = text(path)?;
    let (mut unit, mut quantity) = (Unit::Micrometre, None);
    let mut rows = Vec::new();
    let mut is_first = true;
    for (i, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let fields = fields(line);
        let is_heading = is_first && fields.iter().all(|field| field.parse::<f64>().is_err());
        is_first = false;
        if is_heading {
            if !reading.is_response {
                refuse_transmission(path, line)?;
            }
            // With white space between columns the unit may be a field of its own.
            let apart = fields.get(1).filter(|field| field.starts_with(['(', '[']));
            let wavelength = [fields[0]].into_iter().chain(apart.copied()).collect::<String>();
            let named = Unit::named(&wavelength);
            if named.is_none() && wavelength.contains(['(', '[']) {
                let problem = format!("the heading {line:?} names no known unit of wavelength");
                return Err(wrong(path, i, problem));
            }
            unit = named.unwrap_or(unit);
            quantity = Quantity::named(fields[1..].join(" ").as_str());
            continue;
        }
        if fields.len() == 2 && fields.iter().any(|field| field.parse::<f64>().is_err()) {
            let problem = format!("{:?}, {:?} are not two numbers", fields[0], fields[1]);
            return Err(wrong(path, i, problem));
        }
        rows.push(row(path, i, unit, &fields)?);
    }
    let quantity = reading.quantity.or(quantity).unwrap_or(Quantity::Emissivity);
    Tabulated::of_rows(path, rows, quantity, reading.range_um)
}

fn fields(line: &str) -> Vec<&str> {
    match [',', ';', '\t'].into_iter().find(|&mark| line.contains(mark)) {
        Some(mark) => line.split(mark).map(str::trim).collect(),
        None => line.split_whitespace().collect(),
    }
}
