//! Text of the USGS spectral library. Version 7 has one column of values, and the wavelengths in a
//! separate file; version 6 has wavelengths, values and their standard deviations.

use std::path::Path;

use super::words::{self, Said};
use super::{
    Quantity, Reading, Row, Tabulated, Unit, number, text, unclear, unless_deleted, wrong,
};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;
use crate::support::file_error::FileError;

/// Whether a first line is the title of a file of version 7: " splib07a Record=5932: ...". Spectra
/// convolved to a sensor have other first words, as s07_ASD.
pub(super) fn is_title(line: &str) -> bool {
    let record = line.to_lowercase().split_once("record=").map(|(_, rest)| rest.to_owned());
    record.is_some_and(|rest| rest.trim_start().starts_with(|c: char| c.is_ascii_digit()))
}

/// Whether a file is of version 6 or an earlier one.
pub(super) fn is_of_version_6(text: &str) -> bool {
    let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let first = first.to_lowercase();
    let is_named = first.contains("usgs") && first.contains("spectral library");
    is_named && text.lines().any(|line| is_rule(line.trim()))
}

/// The line above a title.
fn is_rule(line: &str) -> bool {
    line.len() > 9 && line.chars().all(|c| c == '-')
}

pub(super) fn read(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let text = text(path)?;
    let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let (name, rows) = if is_title(first) {
        of_version_7(path, &text, reading)?
    } else {
        of_version_6(path, &text, reading)?
    };
    refuse_transmission(path, &name)?;
    // The code of the measurement is the last word.
    let code = name.split_whitespace().next_back().unwrap_or_default();
    let said = words::said(code, true).or_else(|| words::said(&name, false));
    let quantity = match (reading.quantity, said) {
        (Some(quantity), _) => quantity,
        (None, Some(Said::Absorbance)) => {
            return Err(SpectrumError::Absorbance { path: path.to_owned(), said: name });
        }
        (None, Some(Said::Quantity(Quantity::Emissivity | Quantity::EmissivityPercent))) => {
            return Err(unclear(path, format!("its title names emissivity: {:?}", name.trim())));
        }
        (None, _) => Quantity::Reflectance,
    };
    let mut spectrum = Tabulated::of_rows(path, rows, quantity, reading.range_um)?;
    spectrum.name = Some(name.split_whitespace().collect::<Vec<_>>().join(" "));
    if quantity.is_reflectance() {
        spectrum.warnings.push(Warning::GeometryNotStated);
    }
    Ok(spectrum)
}

/// The code of a measurement is the last word of a title: AREF and RREF are reflectances. Titles
/// may be cut at 40 characters.
fn refuse_transmission(path: &Path, title: &str) -> Result<(), SpectrumError> {
    let title_lower = title.to_lowercase();
    let mut words = title_lower.split(|c: char| !c.is_ascii_alphanumeric());
    let is_code = |word: &str| ["tran", "trans"].iter().any(|code| word.ends_with(code));
    if words.any(is_code) || title_lower.ends_with(" tra") || title_lower.contains("transmi") {
        let (path, said) = (path.to_owned(), title.trim().to_owned());
        return Err(SpectrumError::Transmission { path, said });
    }
    Ok(())
}

fn of_version_7(
    path: &Path,
    text: &str,
    reading: &Reading,
) -> Result<(String, Vec<Row>), SpectrumError> {
    let (title, values) = column(path, text)?;
    let name = title.split_once(": ").map_or(title.as_str(), |(_, name)| name);
    refuse_transmission(path, name)?;
    let lower = title.to_lowercase();
    // Files of the library that lie beside its spectra.
    if ["error", "bandpass", "fwhm", "wavelength"].iter().any(|word| lower.contains(word)) {
        let problem = format!("this is no spectrum: {name:?}");
        return Err(FileError::wrong(path, problem)
            .with_hint("use the file of the reflectance of that sample")
            .into());
    }
    let Some(beside) = &reading.wavelengths else {
        return Err(FileError::wrong(path, "its wavelengths are in another file of the library")
            .with_hint(
                "write both to one file: `soilsig spectra convert FILE --wavelengths \
                 splib07a_Wavelengths_....txt --out FILE.csv`",
            )
            .into());
    };
    let (of_wavelengths, wavelengths) = column(beside, &super::text(beside)?)?;
    let lower = of_wavelengths.to_lowercase();
    if ["error", "bandpass", "fwhm"].iter().any(|word| lower.contains(word)) {
        let problem = format!("these are no wavelengths: {of_wavelengths:?}");
        return Err(FileError::wrong(beside, problem).into());
    }
    let unit = reading.unit.or_else(|| Unit::named(&of_wavelengths)).unwrap_or(Unit::Micrometre);
    if values.len() != wavelengths.len() {
        let (values, um, beside) = (values.len(), wavelengths.len(), beside.display());
        let problem = format!("it has {values} values, but {beside} has {um} wavelengths");
        return Err(FileError::wrong(path, problem)
            .with_hint("use the wavelength file of the spectrometer that the title names")
            .into());
    }
    let rows = values.into_iter().zip(wavelengths).map(|((line, value), (_, x))| Row {
        line,
        um: unit.um(x),
        value: unless_deleted(value),
    });
    Ok((name.to_owned(), rows.collect()))
}

/// The title, and the numbers with their lines.
fn column(path: &Path, text: &str) -> Result<(String, Vec<(u64, f64)>), SpectrumError> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let title = lines.next().map_or_else(String::new, |(_, title)| title.trim().to_owned());
    let numbers = lines
        .map(|(i, line)| Ok((i as u64, number(path, i, line)?)))
        .collect::<Result<_, SpectrumError>>()?;
    Ok((title, numbers))
}

/// Below a line of dashes: title, history, and columns of wavelength (um), reflectance and standard
/// deviation.
fn of_version_6(
    path: &Path,
    text: &str,
    reading: &Reading,
) -> Result<(String, Vec<Row>), SpectrumError> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let mut lines = lines.filter(|(_, line)| !line.is_empty());
    let _above = lines.by_ref().find(|(_, line)| is_rule(line));
    let name = lines.next().map_or_else(String::new, |(_, title)| title.to_owned());
    let unit = reading.unit.unwrap_or(Unit::Micrometre);
    let mut rows = Vec::new();
    for (i, line) in lines.skip(1) {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let ([x, y] | [x, y, _]) = fields[..] else {
            return Err(wrong(path, i, "there must be wavelength, reflectance and deviation"));
        };
        rows.push(super::row(path, i, unit, &[x, y])?);
    }
    Ok((name, rows))
}
