//! ENVI spectral libraries: numbers in a .sli file, what they mean in the .hdr beside it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::{Quantity, Reading, Row, Tabulated, Unit, refuse_transmission, unless_deleted};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;
use crate::support::envi::{self, Header};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::output;

/// Reads every spectrum of a library; `path` is the .sli or its .hdr.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Vec<Tabulated>, SpectrumError> {
    let (data, header_path) = pair(path);
    let header = Header::read(&header_path)?;
    let wrong = |problem: String| SpectrumError::from(header.wrong(problem));
    let kind = header.get("file type").unwrap_or_default();
    if !kind.to_lowercase().contains("spectral library") {
        return Err(wrong(format!("the file type is {kind:?}, not ENVI Spectral Library")));
    }
    let (channels, spectra) = (header.count("samples", None)?, header.count("lines", None)?);
    if header.count("bands", Some(1))? != 1 {
        return Err(wrong("a spectral library has bands = 1".into()));
    }
    let float = header.float()?;
    let data_bytes = header.data(&data, [spectra, channels, 1])?;
    let units = header.get("wavelength units").unwrap_or_default();
    let unit = Unit::named(units)
        .ok_or_else(|| wrong(format!("wavelength units {units:?} are not known")))?;
    let wavelengths = header.numbers("wavelength")?;
    let is_good = match header.get("bbl") {
        None => vec![1.0; channels],
        Some(_) => header.numbers("bbl")?,
    };
    if wavelengths.len() != channels || is_good.len() != channels {
        return Err(wrong(format!(
            "there must be {channels} wavelengths (and entries of bbl, if any)"
        )));
    }
    let names = header.list("spectra names");
    let scale = header.numbers("reflectance scale factor")?.first().copied().unwrap_or(1.0);
    let ignored = header.numbers("data ignore value")?.first().map(|&value| float.rounded(value));
    let quantity = quantity(&header, &header_path, reading)?;
    data_bytes
        .chunks_exact(float.size() * channels)
        .enumerate()
        .map(|(i, chunk)| {
            let values = chunk.chunks_exact(float.size()).map(|bytes| float.read(bytes));
            let rows = values
                .zip(wavelengths.iter().zip(&is_good))
                .map(|(value, (&wavelength, &good))| {
                    let is_ignored =
                        |ignored: f64| ignored == value || (ignored.is_nan() && value.is_nan());
                    let is_held = good != 0.0 && !ignored.is_some_and(is_ignored);
                    let value =
                        unless_deleted(value).filter(|_| is_held).map(|value| value / scale);
                    Row { line: i as u64 + 1, um: unit.um(wavelength), value }
                })
                .collect();
            let mut spectrum = Tabulated::new(&data, rows, quantity, reading.range_um)?;
            spectrum.name = Some(
                names
                    .get(i)
                    .filter(|name| !name.is_empty())
                    .cloned()
                    .unwrap_or_else(|| (i + 1).to_string()),
            );
            if quantity != Quantity::Emissivity {
                spectrum.warnings.push(Warning::GeometryNotStated);
            }
            Ok(spectrum)
        })
        .collect()
}

/// What is asked for, else what the labels of the plot's axes or the description say.
fn quantity(header: &Header, path: &Path, reading: &Reading) -> Result<Quantity, SpectrumError> {
    let labels = ["z plot titles", "description"].map(|key| header.get(key).unwrap_or_default());
    for label in labels {
        refuse_transmission(path, label)?;
    }
    reading.quantity.or_else(|| labels.iter().find_map(|label| Quantity::named(label))).ok_or_else(
        || {
            FileError::wrong(
                path,
                "the file does not say whether it holds reflectance or emissivity",
            )
            .with_hint(
                "say it: `soilsig spectra convert FILE --quantity reflectance --out FILE.csv`",
            )
            .into()
        },
    )
}

/// Writes a library in double precision, the data first.
pub(super) fn write(
    path: &Path,
    wavelength_um: &[f64],
    curves: &[(String, Vec<f64>)],
) -> Result<(), Error> {
    let data: Vec<u8> =
        curves.iter().flat_map(|(_, curve)| curve).flat_map(|value| value.to_le_bytes()).collect();
    let list = |items: Vec<String>| items.join(", ");
    let mut header = String::from("ENVI\ndescription = {soilsig: emissivity}\n");
    let _ = write!(
        header,
        "samples = {}\nlines = {}\nbands = 1\nheader offset = 0\nfile type = ENVI Spectral Library\n\
         data type = 5\ninterleave = bsq\nbyte order = 0\nwavelength units = Micrometers\n\
         reflectance scale factor = 1.0\nz plot titles = {{Wavelength (um), Emissivity}}\n\
         spectra names = {{{}}}\nwavelength = {{{}}}\n",
        wavelength_um.len(),
        curves.len(),
        list(curves.iter().map(|(name, _)| name.replace(['{', '}', ','], " ")).collect()),
        list(wavelength_um.iter().map(ToString::to_string).collect()),
    );
    output::bytes(path, &data)?;
    Ok(output::bytes(&path.with_extension("hdr"), header.as_bytes())?)
}

/// The data and the header of a library that is named by either.
pub(super) fn pair(path: &Path) -> (PathBuf, PathBuf) {
    envi::pair(path, &["sli"])
}
