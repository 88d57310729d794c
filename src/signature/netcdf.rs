//! A signature as NetCDF with the attributes of the CF conventions.

use netcdf3::Version;

use super::Band;
use super::budget::Budget;
use super::csv;
use super::in_bands::{self, InBand};
use crate::radiometry::{Assumed, Temperature};
use crate::support::netcdf::{FILL, NetCdf, WAVELENGTH};
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
        let units = unit(&name);
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

/// A file with the attributes of a signature.
fn begun(table: &Table) -> NetCdf {
    let mut file = NetCdf::default();
    let (texts, numbers) = attributes(table);
    for (key, text) in &texts {
        file.text(key, text);
    }
    for (key, number) in &numbers {
        file.number(key, *number);
    }
    file
}

/// A signature as the bytes of a file. The wavelength is the dimension of its variables.
pub fn bytes(
    table: &Table,
    bands: &[Band],
    budget: &Budget,
    temperature: Temperature,
    assumed: Assumed,
) -> Vec<u8> {
    let mut file = begun(table);
    file.dimension(WAVELENGTH, bands.len());
    let um = bands.iter().map(|band| band.wavelength_um).collect();
    let attributes = [
        ("standard_name", "radiation_wavelength"),
        ("long_name", "wavelength of the band"),
        ("units", "um"),
    ];
    file.variable(WAVELENGTH, &[WAVELENGTH], &attributes, um);
    for of in variables(bands, budget, temperature, assumed) {
        let attributes = [("long_name", of.long_name), ("units", of.units)];
        let values = of.values.iter().map(|value| value.unwrap_or(FILL)).collect();
        file.variable(&of.name, &[WAVELENGTH], &attributes, values);
        file.numbers(&of.name, "_FillValue", vec![FILL]);
        if !of.ancillary_variables.is_empty() {
            file.attribute(&of.name, "ancillary_variables", &of.ancillary_variables);
        }
    }
    file.bytes(Version::Classic)
}

/// A name without its unit.
fn stem(name: &str) -> &str {
    UNITS.iter().find_map(|(suffix, _)| name.strip_suffix(suffix)).unwrap_or(name)
}

/// Endings of names and their units.
const UNITS: [(&str, &str); 2] = [("_w_m2_sr_um", "W m-2 sr-1 um-1"), ("_k", "K")];

fn unit(name: &str) -> &'static str {
    UNITS.iter().find(|(suffix, _)| name.ends_with(suffix)).map_or("1", |(_, unit)| unit)
}

/// What sensors see, as the bytes of a file. The band is the dimension of its variables; the names
/// of sensor and band are coordinates.
pub fn bytes_in_bands(table: &Table, seen: &[InBand]) -> Vec<u8> {
    const BAND: &str = "band";
    let mut file = begun(table);
    file.dimension(BAND, seen.len());
    let sensors: Vec<&str> = seen.iter().map(|band| &*band.sensor).collect();
    let names: Vec<&str> = seen.iter().map(|band| &*band.band).collect();
    file.words("sensor", [BAND, "sensor_length"], &sensors);
    file.words("band_name", [BAND, "band_name_length"], &names);
    let values: Vec<_> = seen.iter().map(InBand::numbers).collect();
    let numbers = &in_bands::COLUMNS[2..];
    for (i, &(name, meaning)) in numbers.iter().enumerate() {
        let values = values.iter().map(|band| band[i].unwrap_or(FILL)).collect();
        file.variable(name, &[BAND], &[("long_name", meaning.trim_end_matches('.'))], values);
        if name == "centre_um" {
            file.attribute(name, "standard_name", "radiation_wavelength");
            file.attribute(name, "units", "um");
            continue;
        }
        file.attribute(name, "units", unit(name));
        file.numbers(name, "_FillValue", vec![FILL]);
        file.attribute(name, "coordinates", "sensor band_name centre_um");
        let error = format!("{}_half_width_95", stem(name));
        if let Some((error, _)) = numbers.iter().find(|(of, _)| of.starts_with(&error)) {
            file.attribute(name, "ancillary_variables", error);
        }
    }
    file.bytes(Version::Classic)
}
