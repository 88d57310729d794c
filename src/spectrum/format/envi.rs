//! ENVI spectral libraries: a .sli file of numbers with its .hdr file.

use std::path::{Path, PathBuf};

use super::words::{self, Said};
use super::{
    Quantity, Reading, Row, Tabulated, Unit, refuse_no_emissivity, unclear, unless_deleted,
};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;
use crate::support::envi::{self, Contents, Header, Kind};
use crate::support::error::Error;
use crate::support::file_error::FileError;

const ENDINGS: [&str; 1] = ["sli"];

/// Reads every spectrum of a library; `path` is the .sli or its .hdr.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Vec<Tabulated>, SpectrumError> {
    let header = Header::read(path, &ENDINGS)?;
    let file_type = header.get("file type").unwrap_or_default();
    if !file_type.to_lowercase().contains("spectral library") {
        let problem = format!("the file type is {file_type:?}, not ENVI Spectral Library");
        return Err(header.wrong(problem).into());
    }
    header.refuse_changed_data()?;
    let (channels, spectra) = (header.count("samples", None)?, header.count("lines", None)?);
    if header.count("bands", Some(1))? != 1 {
        return Err(header.wrong("a spectral library must have bands = 1").into());
    }
    let numbers = header.data([spectra, channels, 1])?;
    let bands = bands_um(&header, channels, reading.unit)?;
    let names = header.list("spectra names");
    let quantity = quantity(&header, reading)?;
    let values = (0..spectra * channels).filter_map(|i| numbers.get(i).and_then(unless_deleted));
    let values = values.map(|value| value / numbers.scale);
    super::refuse_small_percents(&header.path, reading, quantity, values)?;
    let spectrum = |i: usize| {
        let row = |(channel, &(um, is_good)): (usize, &(f64, bool))| {
            let value = numbers.get(i * channels + channel).and_then(unless_deleted);
            let value = value.filter(|_| is_good).map(|value| value / numbers.scale);
            Row { line: i as u64 + 1, um, value }
        };
        let rows = bands.iter().enumerate().map(row).collect();
        let mut spectrum = Tabulated::of_rows(&header.data, rows, quantity, reading.range_um)?;
        let name = names.get(i).filter(|name| !name.is_empty()).cloned();
        spectrum.name = Some(name.unwrap_or_else(|| (i + 1).to_string()));
        if quantity.is_reflectance() {
            spectrum.warnings.push(Warning::GeometryNotStated);
        }
        Ok(spectrum)
    };
    (0..spectra).map(spectrum).collect()
}

/// Wavelengths of a header's bands, um, and whether each band is good.
pub(crate) fn bands_um(
    header: &Header,
    count: usize,
    unit: Option<Unit>,
) -> Result<Vec<(f64, bool)>, FileError> {
    let units = header.get("wavelength units").unwrap_or_default();
    let unit = unit.or_else(|| Unit::named(units)).ok_or_else(|| {
        header
            .wrong(format!("wavelength units {units:?} are not known"))
            .with_hint("write `wavelength units = Micrometers` or the like into the header")
    })?;
    let bands = header.bands(count)?;
    Ok(bands.into_iter().map(|(wavelength, is_good)| (unit.um(wavelength), is_good)).collect())
}

/// The quantity asked for, else the one that the plot's labels or the description name.
fn quantity(header: &Header, reading: &Reading) -> Result<Quantity, SpectrumError> {
    let mut labels =
        ["z plot titles", "description"].map(|key| header.get(key).unwrap_or_default());
    // Of the plot's two titles the second is that of the values.
    labels[0] = labels[0].split_once(',').map_or(labels[0], |(_, title)| title);
    // The description is prose.
    refuse_no_emissivity(&header.path, labels[0])?;
    let said =
        labels.iter().zip([true, false]).find_map(|(label, is_title)| words::said(label, is_title));
    if let Some(quantity) = reading.quantity {
        return Ok(quantity);
    }
    match said {
        Some(Said::Quantity(quantity)) => Ok(quantity),
        Some(Said::Transmission | Said::Absorbance | Said::Unclear) => {
            refuse_no_emissivity(&header.path, labels[1]).and_then(|()| {
                Err(unclear(&header.path, "the description does not say what the values are"))
            })
        }
        None => Err(unclear(
            &header.path,
            "the file does not say whether it holds reflectance or emissivity",
        )),
    }
}

/// Writes a library in double precision.
pub(super) fn write(
    path: &Path,
    wavelengths_um: &[f64],
    curves: &[(String, Vec<f64>)],
) -> Result<(), Error> {
    let values = curves.iter().flat_map(|(_, curve)| curve);
    let data: Vec<u8> = values.flat_map(|value| value.to_le_bytes()).collect();
    let names: Vec<String> = curves.iter().map(|(name, _)| name.clone()).collect();
    let contents = Contents {
        kind: Kind::Library,
        quantity: "Emissivity",
        size: [wavelengths_um.len(), curves.len(), 1],
        names: &names,
        wavelengths_um,
        widths_um: &[],
        is_bad: &[],
    };
    Ok(envi::write(path, &contents, &data)?)
}

/// Data and header of a library that is named by either.
pub(super) fn pair(path: &Path) -> [PathBuf; 2] {
    envi::pair(path, &ENDINGS)
}
