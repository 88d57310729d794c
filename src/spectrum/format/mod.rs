//! Spectra in files: one module for each format.

mod csv;
mod dialect;
mod ecostress;
mod ems;
pub(crate) mod envi;
mod jcamp;
mod usgs;
mod words;

use std::path::{Path, PathBuf};

use super::tabulated::{Quantity, Row, Tabulated};
use super::{Spectrum, SpectrumError};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::output;
use words::Said;

pub use words::Unit;
pub(in crate::spectrum) use words::wavelength_unit;

/// The credit that a figure with curves of the ECOSTRESS library must show.
pub const ECOSTRESS_CREDIT: &str = "Library spectra: reproduced from the ECOSTRESS Spectral \
     Library through the courtesy of the Jet Propulsion Laboratory, California Institute of \
     Technology, Pasadena, California. Copyright (c) 2017, California Institute of Technology. All \
     rights reserved. Meerdink et al., Remote Sens. Environ. 230, 111196 (2019); Baldridge et al., \
     Remote Sens. Environ. 113, 711-715 (2009).";

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Two columns of text.
    Csv,
    /// Text of the ECOSTRESS and ASTER spectral libraries.
    Ecostress,
    /// Text of the USGS spectral library, version 6 or 7.
    Usgs,
    /// JCAMP-DX, as spectrometers export it.
    Jcamp,
    /// ENVI spectral library: .sli with its .hdr.
    Envi,
    /// DIRSIG emissivity file.
    Ems,
}

impl Format {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Csv => "two-column text",
            Self::Ecostress => "ECOSTRESS/ASTER text",
            Self::Usgs => "USGS splib text",
            Self::Jcamp => "JCAMP-DX",
            Self::Envi => "ENVI spectral library",
            Self::Ems => "DIRSIG emissivity file",
        }
    }

    /// The format of a file: by its ending, else by its first line.
    pub fn of(path: &Path) -> Result<Self, SpectrumError> {
        if is_envi(path) {
            return Ok(Self::Envi);
        }
        if ending(path) == "ems" {
            return Ok(Self::Ems);
        }
        let text = text(path)?;
        let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        Ok(if ecostress::is_header(&text) {
            Self::Ecostress
        } else if jcamp::is_one(&text) {
            Self::Jcamp
        } else if usgs::is_title(first) || usgs::is_of_version_6(&text) {
            Self::Usgs
        } else {
            Self::Csv
        })
    }
}

/// All files that belong to a spectrum's file: a library of two files gives both.
pub fn files(path: &Path) -> Vec<PathBuf> {
    if is_envi(path) {
        return envi::pair(path).to_vec();
    }
    vec![path.to_owned()]
}

/// How to read a file, beyond what it says itself.
#[derive(Debug, Clone, Default)]
pub struct Reading {
    /// The quantity of the values, if the file does not say it.
    pub quantity: Option<Quantity>,
    /// The unit of the wavelengths, if the file does not say it.
    pub unit: Option<Unit>,
    /// The file of wavelengths, for formats with a separate one (USGS).
    pub wavelengths: Option<PathBuf>,
    /// The range to read, um.
    pub range_um: Option<[f64; 2]>,
    /// Whether the values are a sensor's response: its heading may say transmittance.
    pub is_response: bool,
}

/// Reads all spectra of a file.
pub fn read(path: &Path, reading: &Reading) -> Result<Vec<Tabulated>, SpectrumError> {
    match Format::of(path)? {
        Format::Csv => csv::read(path, reading).map(|one| vec![one]),
        Format::Ecostress => ecostress::read(path, reading).map(|one| vec![one]),
        Format::Usgs => usgs::read(path, reading).map(|one| vec![one]),
        Format::Jcamp => jcamp::read(path, reading),
        Format::Envi => envi::read(path, reading),
        Format::Ems => ems::read(path, reading),
    }
}

/// Reads the spectrum of a file that holds one. Of the curves of a DIRSIG file it gives the mean.
pub fn read_one(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let mut all = read(path, reading)?;
    if all.len() == 1 {
        return Ok(all.remove(0));
    }
    if ending(path) == "ems" {
        return Tabulated::mean(&all);
    }
    Err(SpectrumError::Several {
        path: path.to_owned(),
        names: all.into_iter().filter_map(|one| one.name).collect(),
    })
}

/// Writes emissivities at common wavelengths (um, ascending) in the format of the file's ending.
/// A .csv file holds one curve; .sli (with its .hdr) and .ems files hold several. Reading gives the
/// same numbers, bit for bit.
pub fn write(
    path: &Path,
    wavelength_um: &[f64],
    curves: &[(String, Vec<f64>)],
) -> Result<(), Error> {
    let unfit = |problem: &str, hint| Err(FileError::wrong(path, problem).with_hint(hint).into());
    match ending(path).as_str() {
        "csv" if curves.len() > 1 => unfit(
            &format!("a .csv file holds one spectrum, not {}", curves.len()),
            "write a .sli or .ems file",
        ),
        "csv" => {
            let rows = columns(wavelength_um, &curves[0].1, ',');
            Ok(output::bytes(path, format!("wavelength_um,emissivity\n{rows}").as_bytes())?)
        }
        "sli" => envi::write(path, wavelength_um, curves),
        "ems" => Ok(output::bytes(path, ems::text_of(wavelength_um, curves).as_bytes())?),
        _ => unfit("spectra are written as .csv, .sli or .ems", "give --out one of these endings"),
    }
}

/// Rows of wavelength and emissivity.
fn columns(wavelength_um: &[f64], emissivity: &[f64], separator: char) -> String {
    let points = wavelength_um.iter().zip(emissivity);
    let rows = points.map(|(um, emissivity)| format!("{um}{separator}{emissivity}\n"));
    rows.collect::<Vec<_>>().concat()
}

/// The emissivity of a spectrum at wavelengths (um), for [`write()`].
pub fn sampled(spectrum: &Spectrum, wavelength_um: &[f64]) -> Result<Vec<f64>, SpectrumError> {
    wavelength_um.iter().map(|&um| spectrum.emissivity(um)).collect()
}

fn is_envi(path: &Path) -> bool {
    ["sli", "hdr"].contains(&&*ending(path))
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// A text file in any usual encoding.
fn text(path: &Path) -> Result<String, SpectrumError> {
    let text = crate::support::text::read(path)?;
    if text.chars().take(1024).any(|c| c < '\t') {
        return Err(FileError::wrong(path, "this is not text")
            .with_hint("export it as columns of text: of a spreadsheet a .csv file")
            .into());
    }
    Ok(text)
}

/// Refuses a label that says transmission or absorbance.
fn refuse_no_emissivity(path: &Path, label: &str) -> Result<(), SpectrumError> {
    let (path, said) = (path.to_owned(), label.trim().to_owned());
    match words::said(label, true) {
        Some(Said::Transmission) => Err(SpectrumError::Transmission { path, said }),
        Some(Said::Absorbance) => Err(SpectrumError::Absorbance { path, said }),
        _ => Ok(()),
    }
}

/// The quantity asked for, else the one that the file says, else emissivity. What the file says
/// has the text where it says so.
fn settled(
    path: &Path,
    reading: &Reading,
    said: Option<(Said, String)>,
) -> Result<Quantity, SpectrumError> {
    let path = path.to_owned();
    match (reading.quantity, said) {
        (Some(quantity), _) | (None, Some((Said::Quantity(quantity), _))) => Ok(quantity),
        (None, Some((Said::Transmission, said))) => Err(SpectrumError::Transmission { path, said }),
        (None, Some((Said::Absorbance, said))) => Err(SpectrumError::Absorbance { path, said }),
        (None, Some((Said::Unclear, said))) => {
            Err(unclear(&path, format!("it is not clear what {said:?} says of the values")))
        }
        (None, None) => Ok(Quantity::Emissivity),
    }
}

/// A file that does not say clearly what its values are.
fn unclear(path: &Path, problem: impl Into<Box<str>>) -> SpectrumError {
    FileError::wrong(path, problem)
        .with_hint(
            "say what the values are: `soilsig spectra convert FILE --quantity reflectance --out \
             FILE.csv`",
        )
        .into()
}

/// Refuses values all of which are at most 1 where the file says percent.
fn refuse_small_percents(
    path: &Path,
    reading: &Reading,
    quantity: Quantity,
    mut values: impl Iterator<Item = f64>,
) -> Result<(), SpectrumError> {
    let says_percent = reading.quantity.is_none() && quantity.is_percent();
    if says_percent && values.all(|value| value.abs() <= 1.0) {
        return Err(unclear(path, "the heading says percent, but no value is above 1"));
    }
    Ok(())
}

/// A line that does not say clearly in which unit the wavelengths are.
fn unclear_unit(path: &Path, line: usize, problem: impl Into<Box<str>>) -> SpectrumError {
    FileError::wrong_in_line(path, line as u64, problem)
        .with_hint(
            "name the unit in the heading, as in wavelength_um, or say it: `soilsig spectra \
             convert FILE --unit nm --out FILE.csv`",
        )
        .into()
}

fn wrong(path: &Path, line: usize, problem: impl Into<Box<str>>) -> SpectrumError {
    FileError::wrong_in_line(path, line as u64, problem).into()
}

/// A number of a text file; `line` counts from 1.
fn number(path: &Path, line: usize, field: &str) -> Result<f64, SpectrumError> {
    let field = field.trim();
    field.parse().map_err(|_| wrong(path, line, format!("{field:?} is not a number")))
}

/// `None` for the value of deleted channels: that of SPECPR, -1.23e34, in any rounding.
fn unless_deleted(value: f64) -> Option<f64> {
    (value > -1e34).then_some(value).or_else(|| value.is_nan().then_some(value))
}

/// A row of two numbers.
fn row(path: &Path, line: usize, unit: Unit, fields: &[&str]) -> Result<Row, SpectrumError> {
    let [x, y] = fields else {
        return Err(wrong(
            path,
            line,
            format!("there are {} columns where two are needed", fields.len()),
        ));
    };
    Ok(Row {
        line: line as u64,
        um: unit.um(number(path, line, x)?),
        value: unless_deleted(number(path, line, y)?),
    })
}
