//! A signature as NetCDF with the attributes of the CF conventions.

use std::cell::RefCell;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::rc::Rc;

use netcdf3::{DataSet, FileWriter, InvalidDataSet, Version, WriteError};

use super::Band;
use super::budget::Budget;
use super::csv;
use super::in_bands::{self, InBand};
use crate::radiometry::{Assumed, Temperature};
use crate::table::Table;

/// A variable of a signature, with its attributes.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name, with the unit at its end.
    pub name: String,
    /// What it is.
    pub long_name: &'static str,
    /// Its unit.
    pub units: &'static str,
    /// The names of its errors, divided by spaces.
    pub ancillary_variables: String,
    /// A value in each band.
    pub values: Vec<Option<f64>>,
}

/// The columns of a signature and of its budget. Errors are ancillary variables of what they belong
/// to.
pub fn variables(
    bands: &[Band],
    budget: &Budget,
    temperature: Temperature,
    assumed: Assumed,
) -> Vec<Variable> {
    let mut columns: Vec<(String, &str, _)> = csv::values(bands, budget, temperature, assumed)
        .into_iter()
        .map(|(name, meaning, values)| (name.to_owned(), meaning, values))
        .collect();
    columns.push(("valid".into(), "1 where the models of all facets hold, else 0.", {
        bands.iter().map(|band| Some(f64::from(u8::from(band.valid)))).collect()
    }));
    // The total stands among the columns, beside the emissivity.
    let parts = budget.columns().into_iter().skip(1);
    let has_values = |values: &[Option<f64>]| values.iter().any(Option::is_some);
    let parts: Vec<(String, &str, Vec<Option<f64>>)> = parts
        .filter(|(.., values)| has_values(values))
        .map(|(name, meaning, values)| (format!("budget_{name}"), meaning, values))
        .collect();
    let ancillary = |of: &str| {
        let stem = stem(of);
        let is_error = |name: &&str| {
            *name != of
                && name.strip_prefix(stem).is_some_and(|rest| {
                    ["_standard_error", "_half_width", "_sd", "_total"]
                        .iter()
                        .any(|part| rest.starts_with(part))
                })
        };
        let mut errors: Vec<&str> =
            columns.iter().map(|(name, ..)| &**name).filter(is_error).collect();
        if of == "emissivity" {
            errors.extend(parts.iter().map(|(name, ..)| &**name));
        }
        errors.join(" ")
    };
    let ancillaries: Vec<String> = columns.iter().map(|(name, ..)| ancillary(name)).collect();
    let ancillaries = ancillaries.into_iter().chain(parts.iter().map(|_| String::new()));
    let ancillaries: Vec<String> = ancillaries.collect();
    let all = columns.into_iter().chain(parts).zip(ancillaries);
    all.map(|((name, long_name, values), ancillary_variables)| {
        let unit = UNITS.iter().find(|(suffix, _)| name.ends_with(suffix));
        let units = unit.map_or("1", |(_, unit)| unit);
        Variable { name, long_name, units, ancillary_variables, values }
    })
    .collect()
}

/// The attributes of a signature as a whole: texts, then numbers.
#[allow(clippy::type_complexity, reason = "two lists of names and values")]
pub fn attributes(table: &Table) -> (Vec<(&'static str, String)>, Vec<(&'static str, f64)>) {
    let source = concat!("soilsig ", env!("CARGO_PKG_VERSION"));
    let sha256: String = table.scene_sha256.chars().take(12).collect();
    let history = format!("{source}: signature of scene {sha256} with seed {}", table.seed);
    let texts = vec![
        ("Conventions", "CF-1.11".to_owned()),
        ("title", table.scene.clone()),
        ("source", source.to_owned()),
        ("history", history),
        ("scene_sha256", table.scene_sha256.clone()),
        ("seed", table.seed.to_string()),
    ];
    let numbers = vec![
        ("temperature_k", table.temperature_k),
        ("view_zenith_deg", table.view.zenith_deg),
        ("view_azimuth_deg", table.view.azimuth_deg),
    ];
    (texts, numbers)
}

/// A signature as the bytes of a file. The wavelength is the dimension of its variables.
pub fn bytes(
    table: &Table,
    bands: &[Band],
    budget: &Budget,
    temperature: Temperature,
    assumed: Assumed,
) -> Vec<u8> {
    let um: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let variables = variables(bands, budget, temperature, assumed);
    written(table, &um, &variables).expect("names and sizes are valid, and memory does not fail")
}

/// A name without its unit.
fn stem(name: &str) -> &str {
    UNITS.iter().find_map(|(suffix, _)| name.strip_suffix(suffix)).unwrap_or(name)
}

/// Endings of names and their units.
const UNITS: [(&str, &str); 2] = [("_w_m2_sr_um", "W m-2 sr-1 um-1"), ("_k", "K")];

/// What cannot be written.
#[derive(Debug)]
#[expect(dead_code, reason = "shown when a promise of this crate is broken")]
pub(crate) enum Failed {
    Define(InvalidDataSet),
    Write(WriteError),
}

impl From<InvalidDataSet> for Failed {
    fn from(error: InvalidDataSet) -> Self {
        Self::Define(error)
    }
}

impl From<WriteError> for Failed {
    fn from(error: WriteError) -> Self {
        Self::Write(error)
    }
}

fn written(table: &Table, um: &[f64], variables: &[Variable]) -> Result<Vec<u8>, Failed> {
    let mut set = DataSet::new();
    set.add_fixed_dim(WAVELENGTH, um.len())?;
    let (texts, numbers) = attributes(table);
    for (key, text) in texts {
        set.add_global_attr_string(key, &text)?;
    }
    for (key, number) in numbers {
        set.add_global_attr_f64(key, vec![number])?;
    }
    set.add_var_f64(WAVELENGTH, &[WAVELENGTH])?;
    set.add_var_attr_string(WAVELENGTH, "standard_name", "radiation_wavelength")?;
    set.add_var_attr_string(WAVELENGTH, "long_name", "wavelength of the band")?;
    set.add_var_attr_string(WAVELENGTH, "units", "um")?;
    for Variable { name, long_name, units, ancillary_variables: errors, .. } in variables {
        set.add_var_f64(name, &[WAVELENGTH])?;
        set.add_var_attr_string(name, "long_name", long_name)?;
        set.add_var_attr_string(name, "units", units)?;
        set.add_var_attr_f64(name, "_FillValue", vec![FILL])?;
        if !errors.is_empty() {
            set.add_var_attr_string(name, "ancillary_variables", errors)?;
        }
    }
    let memory = Memory::default();
    {
        let mut writer = FileWriter::open_seek_write("signature", Box::new(memory.clone()))?;
        writer.set_def(&set, Version::Classic, 0)?;
        writer.write_var_f64(WAVELENGTH, um)?;
        for Variable { name, values, .. } in variables {
            let values: Vec<f64> = values.iter().map(|value| value.unwrap_or(FILL)).collect();
            writer.write_var_f64(name, &values)?;
        }
        writer.close()?;
    }
    Ok(memory.bytes())
}

/// What sensors see, as the bytes of a file. The band is the dimension of its variables; the names
/// of sensor and band are coordinates.
pub fn bytes_in_bands(table: &Table, seen: &[InBand]) -> Vec<u8> {
    written_in_bands(table, seen).expect("names and sizes are valid, and memory does not fail")
}

fn written_in_bands(table: &Table, seen: &[InBand]) -> Result<Vec<u8>, Failed> {
    const COORDINATES: &str = "sensor band_name centre_um";
    let mut set = DataSet::new();
    set.add_fixed_dim(BAND, seen.len())?;
    let (texts, numbers) = attributes(table);
    for (key, text) in texts {
        set.add_global_attr_string(key, &text)?;
    }
    for (key, number) in numbers {
        set.add_global_attr_f64(key, vec![number])?;
    }
    let names = [
        ("sensor", "sensor_length", seen.iter().map(|band| &*band.sensor).collect::<Vec<_>>()),
        ("band_name", "band_name_length", seen.iter().map(|band| &*band.band).collect()),
    ];
    for (name, length, words) in &names {
        set.add_fixed_dim(length, words.iter().map(|word| word.len()).max().unwrap_or(0).max(1))?;
        set.add_var_u8(name, &[BAND, length])?;
    }
    let values: Vec<_> = seen.iter().map(InBand::numbers).collect();
    let column = |(i, &(name, meaning)): (usize, &(&'static str, &'static str))| {
        let values = values.iter().map(|band| band[i].unwrap_or(FILL));
        (name, meaning, values.collect::<Vec<f64>>())
    };
    let numbers = in_bands::COLUMNS.iter().skip(names.len()).enumerate().map(column);
    let numbers: Vec<_> = numbers.collect();
    for (name, meaning, _) in &numbers {
        set.add_var_f64(name, &[BAND])?;
        set.add_var_attr_string(name, "long_name", meaning.trim_end_matches('.'))?;
        if *name == "centre_um" {
            set.add_var_attr_string(name, "standard_name", "radiation_wavelength")?;
            set.add_var_attr_string(name, "units", "um")?;
            continue;
        }
        let unit = UNITS.iter().find(|(suffix, _)| name.ends_with(suffix));
        set.add_var_attr_string(name, "units", unit.map_or("1", |(_, unit)| unit))?;
        set.add_var_attr_f64(name, "_FillValue", vec![FILL])?;
        set.add_var_attr_string(name, "coordinates", COORDINATES)?;
        let error = format!("{}_half_width_95", stem(name));
        if let Some((error, ..)) = numbers.iter().find(|(of, ..)| of.starts_with(&error)) {
            set.add_var_attr_string(name, "ancillary_variables", error)?;
        }
    }
    let memory = Memory::default();
    {
        let mut writer = FileWriter::open_seek_write("bands", Box::new(memory.clone()))?;
        writer.set_def(&set, Version::Classic, 0)?;
        for (name, length, words) in &names {
            let width = set.dim_size(length).unwrap_or(1);
            let padded = |word: &&str| {
                let mut letters = word.as_bytes().to_vec();
                letters.resize(width, 0);
                letters
            };
            writer.write_var_u8(name, &words.iter().flat_map(padded).collect::<Vec<u8>>())?;
        }
        for (name, _, values) in &numbers {
            writer.write_var_f64(name, values)?;
        }
        writer.close()?;
    }
    Ok(memory.bytes())
}

const BAND: &str = "band";

pub(crate) const WAVELENGTH: &str = "wavelength";

/// NetCDF's own value for what is missing. NaN is not equal to itself, which its writer needs.
pub(crate) const FILL: f64 = 9.969_209_968_386_869e36;

/// Bytes that outlive the writer.
#[derive(Clone, Default)]
pub(crate) struct Memory(Rc<RefCell<Cursor<Vec<u8>>>>);

impl Memory {
    /// What was written.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.0.take().into_inner()
    }
}

impl Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Memory {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.borrow_mut().seek(to)
    }
}
