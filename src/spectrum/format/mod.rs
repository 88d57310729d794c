//! Spectra in files: one module for each format.

mod csv;
mod ecostress;
mod ems;
pub(crate) mod envi;
mod usgs;

use std::path::{Path, PathBuf};

use super::tabulated::{Quantity, Row, Tabulated};
use super::{Spectrum, SpectrumError};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::output;

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
    /// Text of the USGS spectral library, version 7.
    Usgs,
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
            Self::Usgs => "USGS splib07 text",
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
        let first = text.lines().next().unwrap_or_default();
        Ok(if first.starts_with("Name:") {
            Self::Ecostress
        } else if usgs::is_title(first) {
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
        Format::Envi => envi::read(path, reading),
        Format::Ems => ems::read(path, reading),
    }
}

/// Reads the spectrum of a file that holds one.
pub fn read_one(path: &Path, reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let mut all = read(path, reading)?;
    if all.len() == 1 {
        return Ok(all.remove(0));
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

/// The unit of a file's wavelengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Unit {
    Micrometre,
    Nanometre,
    Wavenumber,
}

impl Unit {
    /// The unit that a heading or label names, if it names one.
    pub(crate) fn named(text: &str) -> Option<Self> {
        let text = text.to_lowercase();
        let has = |parts: &[&str]| parts.iter().any(|part| text.contains(part));
        if has(&["wavenumber", "cm-1", "cm^-1", "1/cm"]) {
            Some(Self::Wavenumber)
        } else if has(&["nanomet", "(nm)", "[nm]", "_nm"]) || text.trim() == "nm" {
            Some(Self::Nanometre)
        } else if has(&["micromet", "micron", "(um)", "[um]", "_um", "\u{b5}m", "\u{3bc}m"])
            || text.trim() == "um"
        {
            Some(Self::Micrometre)
        } else {
            None
        }
    }

    pub(crate) fn um(self, value: f64) -> f64 {
        match self {
            Self::Micrometre => value,
            Self::Nanometre => value / 1e3,
            Self::Wavenumber => 1e4 / value,
        }
    }
}

fn is_envi(path: &Path) -> bool {
    ["sli", "hdr"].contains(&&*ending(path))
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// A text file in UTF-8, else in Latin-1, without a byte order mark.
fn text(path: &Path) -> Result<String, SpectrumError> {
    Ok(crate::support::text::read(path)?)
}

/// Refuses a label that says transmission, in any of the libraries' spellings.
fn refuse_transmission(path: &Path, label: &str) -> Result<(), SpectrumError> {
    let lower = label.to_lowercase();
    if ["transmi", "transit"].iter().any(|part| lower.contains(part)) {
        let (path, said) = (path.to_owned(), label.trim().into());
        return Err(SpectrumError::Transmission { path, said });
    }
    Ok(())
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
