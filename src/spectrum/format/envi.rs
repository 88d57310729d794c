//! ENVI spectral libraries: numbers in a .sli file, what they mean in the .hdr beside it.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::{
    Quantity, Reading, Row, Tabulated, Unit, bytes, refuse_transmission, text, unless_deleted,
    wrong,
};
use crate::error::Error;
use crate::output;
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;

/// Reads every spectrum of a library; `path` is the .sli or its .hdr.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Vec<Tabulated>, SpectrumError> {
    let (data, header_path) = pair(path);
    let header = Header::read(&header_path)?;
    let wrong = |problem: String| wrong(&header_path, 1, problem);
    let kind = header.get("file type").unwrap_or_default();
    if !kind.to_lowercase().contains("spectral library") {
        return Err(wrong(format!("the file type is {kind:?}, not ENVI Spectral Library")));
    }
    let (channels, spectra) = (header.count("samples", None)?, header.count("lines", None)?);
    if header.count("bands", Some(1))? != 1 {
        return Err(wrong("a spectral library has bands = 1".into()));
    }
    let size = match header.count("data type", None)? {
        4 => 4,
        5 => 8,
        other => return Err(wrong(format!("data type {other} is not 4 or 5 (single or double)"))),
    };
    let is_big_endian = match header.count("byte order", Some(0))? {
        0 => false,
        1 => true,
        other => return Err(wrong(format!("byte order {other} is not 0 or 1"))),
    };
    let data_bytes = bytes(&data)?;
    let offset = header.count("header offset", Some(0))?;
    let needed = [channels, spectra, size].iter().try_fold(1, |n: usize, &m| n.checked_mul(m));
    if needed.and_then(|n| n.checked_add(offset)) != Some(data_bytes.len()) || channels == 0 {
        return Err(wrong(format!(
            "{spectra} spectra of {channels} channels of {size} bytes do not make the {} bytes of {}",
            data_bytes.len(),
            data.display()
        )));
    }
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
    let ignored = header.numbers("data ignore value")?.first().copied();
    let quantity = quantity(&header, &header_path, reading)?;
    data_bytes[offset..]
        .chunks_exact(size * channels)
        .enumerate()
        .map(|(i, chunk)| {
            let values = chunk.chunks_exact(size).map(|bytes| float(bytes, is_big_endian));
            let rows = values
                .zip(wavelengths.iter().zip(&is_good))
                .map(|(value, (&wavelength, &good))| {
                    let is_held = good != 0.0 && ignored != Some(value);
                    let value =
                        unless_deleted(value).filter(|_| is_held).map(|value| value / scale);
                    Row { line: i as u64 + 1, um: unit.um(wavelength), value }
                })
                .collect();
            let mut spectrum = Tabulated::new(&data, rows, quantity, reading.range_um)?;
            spectrum.name = Some(names.get(i).cloned().unwrap_or_else(|| (i + 1).to_string()));
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
        || SpectrumError::File {
            path: path.to_owned(),
            problem: "the file does not say whether it holds reflectance or emissivity".into(),
            hint: "say it: `soilsig spectra convert FILE --quantity reflectance --out FILE.csv`",
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
    if super::ending(path) == "hdr" {
        let data = path.with_extension("");
        let is_whole_name = super::ending(&data) == "sli";
        return (if is_whole_name { data } else { path.with_extension("sli") }, path.to_owned());
    }
    let mut whole_name = path.as_os_str().to_owned();
    whole_name.push(".hdr");
    let whole_name = PathBuf::from(whole_name);
    let header = if whole_name.exists() { whole_name } else { path.with_extension("hdr") };
    (path.to_owned(), header)
}

fn float(bytes: &[u8], is_big_endian: bool) -> f64 {
    let mut bytes = bytes.to_vec();
    if is_big_endian {
        bytes.reverse();
    }
    match <[u8; 4]>::try_from(bytes.as_slice()) {
        Ok(single) => f64::from(f32::from_le_bytes(single)),
        Err(_) => f64::from_le_bytes(bytes.try_into().expect("4 or 8 bytes")),
    }
}

/// The keys of a .hdr file, in small letters, with their values; those in braces without them.
struct Header<'a> {
    path: &'a Path,
    values: HashMap<String, String>,
}

impl<'a> Header<'a> {
    fn read(path: &'a Path) -> Result<Self, SpectrumError> {
        let text = text(path)?;
        if text.lines().next().map(str::trim) != Some("ENVI") {
            return Err(wrong(path, 1, "a header starts with the line ENVI"));
        }
        let mut values = HashMap::new();
        let mut lines = text.lines().skip(1);
        while let Some(line) = lines.next() {
            let Some((key, value)) = line.split_once('=') else { continue };
            let mut value = value.trim().to_owned();
            while value.starts_with('{') && !value.contains('}') {
                let Some(next) = lines.next() else { break };
                value = value + " " + next.trim();
            }
            let value = value.trim_matches(['{', '}', ' ']).to_owned();
            values.insert(key.trim().to_lowercase(), value);
        }
        Ok(Self { path, values })
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    fn list(&self, key: &str) -> Vec<String> {
        let value = self.get(key).unwrap_or_default();
        value
            .split(',')
            .map(|item| item.trim().to_owned())
            .filter(|item| !item.is_empty())
            .collect()
    }

    fn numbers(&self, key: &str) -> Result<Vec<f64>, SpectrumError> {
        self.list(key).iter().map(|item| super::number(self.path, 1, item)).collect()
    }

    fn count(&self, key: &str, default: Option<usize>) -> Result<usize, SpectrumError> {
        let value = self.get(key).map(str::parse);
        match (value, default) {
            (Some(Ok(count)), _) => Ok(count),
            (None, Some(default)) => Ok(default),
            _ => Err(wrong(self.path, 1, format!("{key} = a whole number is missing"))),
        }
    }
}
