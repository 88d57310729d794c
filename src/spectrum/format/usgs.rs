//! Text of the USGS spectral library, version 7: one column of values; the wavelengths are in a
//! separate file.

use std::path::Path;

use super::{Quantity, Reading, Row, Tabulated, number, refuse_transmission, text, unless_deleted};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;
use crate::support::file_error::FileError;

/// Whether a first line is the title of such a file: " splib07a Record=5932: ...".
pub(super) fn is_title(line: &str) -> bool {
    line.trim_start().starts_with("splib") && line.contains("Record=")
}

pub(super) fn read(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let Some(beside) = &reading.wavelengths else {
        return Err(FileError::wrong(path, "its wavelengths are in another file of the library")
            .with_hint(
                "write both to one file: `soilsig spectra convert FILE --wavelengths \
                 splib07a_Wavelengths_....txt --out FILE.csv`",
            )
            .into());
    };
    let (title, values) = column(path)?;
    let (_, wavelengths) = column(beside)?;
    let name = title.split_once(": ").map_or(title.as_str(), |(_, name)| name);
    refuse_transmission(path, name)?;
    if values.len() != wavelengths.len() {
        let (values, um, beside) = (values.len(), wavelengths.len(), beside.display());
        let problem = format!("it has {values} values, but {beside} has {um} wavelengths");
        return Err(FileError::wrong(path, problem)
            .with_hint("use the wavelength file of the spectrometer that the title names")
            .into());
    }
    let rows = values
        .into_iter()
        .zip(wavelengths)
        .map(|((line, value), (_, um))| Row { line, um, value: unless_deleted(value) })
        .collect();
    let quantity = reading.quantity.unwrap_or(Quantity::Reflectance);
    let mut spectrum = Tabulated::of_rows(path, rows, quantity, reading.range_um)?;
    spectrum.name = Some(name.split_whitespace().collect::<Vec<_>>().join(" "));
    if quantity != Quantity::Emissivity {
        spectrum.warnings.push(Warning::GeometryNotStated);
    }
    Ok(spectrum)
}

/// The title, and the numbers with their lines.
fn column(path: &Path) -> Result<(String, Vec<(u64, f64)>), SpectrumError> {
    let text = text(path)?;
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    let title = lines.next().map_or_else(String::new, |(_, title)| title.trim().to_owned());
    let numbers = lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(i, line)| Ok((i as u64, number(path, i, line)?)))
        .collect::<Result<_, SpectrumError>>()?;
    Ok((title, numbers))
}
