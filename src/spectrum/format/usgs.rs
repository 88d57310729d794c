//! Text of the USGS spectral library, version 7: one column of values, the wavelengths in a file of
//! their own.

use std::path::Path;

use super::{Quantity, Reading, Row, Tabulated, number, refuse_transmission, text, unless_deleted};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;

/// Whether a first line is the title of such a file: " splib07a Record=5932: ...".
pub(super) fn is_title(line: &str) -> bool {
    line.trim_start().starts_with("splib") && line.contains("Record=")
}

pub(super) fn read(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let unfit = |problem, hint| SpectrumError::File { path: path.to_owned(), problem, hint };
    let Some(beside) = &reading.wavelengths else {
        return Err(unfit(
            "the wavelengths stand in another file of the library".into(),
            "write both to one: `soilsig spectra convert FILE --wavelengths \
             splib07a_Wavelengths_....txt --out FILE.csv`",
        ));
    };
    let (title, values) = column(path)?;
    let (_, wavelengths) = column(beside)?;
    let name = title.split_once(": ").map_or(title.as_str(), |(_, name)| name);
    refuse_transmission(path, name)?;
    if values.len() != wavelengths.len() {
        return Err(unfit(
            format!(
                "{} values for the {} wavelengths of {}",
                values.len(),
                wavelengths.len(),
                beside.display()
            ),
            "each spectrometer of the library has its own file of wavelengths: the title names it",
        ));
    }
    let rows = values
        .into_iter()
        .zip(wavelengths)
        .map(|((line, value), (_, um))| Row { line, um, value: unless_deleted(value) })
        .collect();
    let quantity = reading.quantity.unwrap_or(Quantity::Reflectance);
    let mut spectrum = Tabulated::new(path, rows, quantity, reading.range_um)?;
    spectrum.name = Some(name.split_whitespace().collect::<Vec<_>>().join(" "));
    if quantity != Quantity::Emissivity {
        spectrum.warnings.push(Warning::GeometryNotStated);
    }
    Ok(spectrum)
}

/// The title and the numbers, each with its line.
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
