//! An image as NetCDF with the attributes of the CF conventions.
//!
//! Lines are the unlimited dimension: so a file is written line by line and may exceed 2 GB.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use netcdf3::{DataSet, FileWriter, InvalidDataSet, Version, WriteError};

use crate::support::netcdf::{Shared, VALID};
use crate::support::output::{Beside, OutputError};

/// The CF standard name of the radiance.
const RADIANCE: &str = "upwelling_radiance_per_unit_wavelength_in_air";

/// What a file says besides its numbers.
pub(super) struct About<'a> {
    pub title: &'a str,
    pub scene_sha256: &'a str,
    pub temperature_k: f64,
    pub view_deg: [f64; 2],
    pub seed: u64,
    pub materials: &'a [String],
    /// Width and height of a pixel.
    pub pixel: [f64; 2],
    /// Whether these are in um; else they are differences of the angle's tangent.
    pub is_parallel: bool,
    /// Lines and samples.
    pub size: [usize; 2],
    pub wavelengths_um: &'a [f64],
    /// Full widths of the bands, um; 0 for single wavelengths.
    pub widths_um: &'a [f64],
    /// Bands in which the models of facets do not hold.
    pub is_bad: &'a [bool],
}

impl About<'_> {
    /// The dimension of the bands. Only wavelengths in order can be a coordinate of their own.
    fn of_bands(&self) -> &'static str {
        let ascends = self.wavelengths_um.is_sorted_by(|a, b| a < b);
        if ascends { "wavelength" } else { "band" }
    }
}

/// Variables by line, band and sample.
pub(super) const CUBES: [&str; 3] = ["radiance", "radiance_standard_error", "emissivity"];
/// Variables by line and sample.
pub(super) const MAPS: [&str; 4] = ["material", "hits", "paths", "emissivity_standard_error"];

/// The dimensions, variables and attributes of a file.
pub(super) fn data_set(about: &About) -> DataSet {
    define(about).expect(VALID)
}

fn define(about: &About) -> Result<DataSet, InvalidDataSet> {
    let mut set = DataSet::new();
    set.set_unlimited_dim("y", about.size[0])?;
    let of_bands = about.of_bands();
    set.add_fixed_dim(of_bands, about.wavelengths_um.len())?;
    set.add_fixed_dim("x", about.size[1])?;
    for (key, text) in [
        ("Conventions", "CF-1.11"),
        ("title", about.title),
        ("source", concat!("soilsig ", env!("CARGO_PKG_VERSION"))),
        (
            "history",
            &format!(
                "soilsig {}: soilsig image of scene {} with seed {}",
                env!("CARGO_PKG_VERSION"),
                &about.scene_sha256[..12.min(about.scene_sha256.len())],
                about.seed
            ),
        ),
        ("scene_sha256", about.scene_sha256),
        ("seed", &about.seed.to_string()),
    ] {
        set.add_global_attr_string(key, text)?;
    }
    set.add_global_attr_f64("temperature_k", vec![about.temperature_k])?;
    set.add_global_attr_f64("view_zenith_deg", vec![about.view_deg[0]])?;
    set.add_global_attr_f64("view_azimuth_deg", vec![about.view_deg[1]])?;

    let (length, of) =
        if about.is_parallel { ("um", "distance") } else { ("1", "tangent of the angle") };
    // A line for each variable: its name, then its attributes.
    let variables = format!(
        "y | long_name: {of} of the pixel's middle from that of the view, upward | \
         units: {length}\n\
         x | long_name: {of} of the pixel's middle from that of the view, to the right | \
         units: {length}\n\
         wavelength | standard_name: radiation_wavelength | long_name: centroid of the band | \
         units: um\n\
         band_width | long_name: full width of the band at half maximum | units: um\n\
         valid | long_name: whether the models of all facets hold in the band\n\
         radiance | standard_name: {RADIANCE} | long_name: radiance at the sensor | \
         units: W m-2 sr-1 um-1 | ancillary_variables: radiance_standard_error valid\n\
         radiance_standard_error | standard_name: {RADIANCE} standard_error | \
         long_name: standard error of the radiance, rays and sensor noise | \
         units: W m-2 sr-1 um-1\n\
         emissivity | long_name: emissivity of the bed towards the sensor | units: 1 | \
         ancillary_variables: valid\n\
         material | long_name: material that fills most of the pixel\n\
         hits | long_name: mean number of hits of a path | units: 1\n\
         paths | long_name: paths of the pixel | units: 1\n\
         emissivity_standard_error | long_name: standard error of the emissivity in the widest \
         band | units: 1"
    );
    for line in variables.lines() {
        let mut parts = line.split(" | ");
        let name = parts.next().expect("a line is not empty");
        if CUBES.contains(&name) {
            set.add_var_f32(name, &["y", of_bands, "x"])?;
        } else if MAPS.contains(&name) {
            set.add_var_f32(name, &["y", "x"])?;
        } else if name == "valid" {
            set.add_var_i8(name, &[of_bands])?;
            set.add_var_attr_string(name, "flag_meanings", "not_valid valid")?;
            set.add_var_attr_i8(name, "flag_values", vec![0, 1])?;
        } else if ["wavelength", "band_width"].contains(&name) {
            set.add_var_f64(name, &[of_bands])?;
        } else {
            set.add_var_f64(name, &[name])?;
        }
        if CUBES.contains(&name) {
            let of_band = if of_bands == "band" { "wavelength " } else { "" };
            set.add_var_attr_string(name, "coordinates", format!("{of_band}band_width"))?;
        }
        for (key, text) in parts.filter_map(|part| part.split_once(": ")) {
            set.add_var_attr_string(name, key, text)?;
        }
    }
    // Blanks separate the meanings.
    let meanings: Vec<String> = about.materials.iter().map(|name| name.replace(' ', "_")).collect();
    set.add_var_attr_string(MAPS[0], "flag_meanings", meanings.join(" "))?;
    let flags = (0..about.materials.len()).map(|i| i as f32).collect();
    set.add_var_attr_f32(MAPS[0], "flag_values", flags)?;
    Ok(set)
}

/// A file that is written line by line.
pub(super) struct NetCdf<'a> {
    beside: Beside,
    writer: FileWriter<'a>,
    /// The writer writes number by number, and would hide an error in the last flush.
    buffer: Shared<BufWriter<File>>,
}

impl<'a> NetCdf<'a> {
    /// Begins a file and writes its coordinates.
    pub(super) fn new(path: &Path, set: &'a DataSet, about: &About) -> Result<Self, OutputError> {
        let beside = Beside::new(path)?;
        let out = BufWriter::with_capacity(1 << 20, beside.handle()?);
        let buffer = Shared::new(out);
        let begin = || -> Result<FileWriter<'a>, WriteError> {
            let mut writer = FileWriter::open_seek_write("image", Box::new(buffer.clone()))?;
            writer.set_def(set, Version::Offset64Bit, 0)?;
            let [width, height] = about.pixel;
            let middles = |number: usize, size: f64| -> Vec<f64> {
                (0..number).map(|i| (i as f64 + 0.5 - number as f64 / 2.0) * size).collect()
            };
            writer.write_var_f64("x", &middles(about.size[1], width))?;
            writer.write_var_f64("wavelength", about.wavelengths_um)?;
            writer.write_var_f64("band_width", about.widths_um)?;
            let valid: Vec<i8> = about.is_bad.iter().map(|bad| i8::from(!bad)).collect();
            writer.write_var_i8("valid", &valid)?;
            // The first line is the upper one: y descends.
            for (line, y) in middles(about.size[0], height).into_iter().rev().enumerate() {
                writer.write_record_f64("y", line, &[y])?;
            }
            Ok(writer)
        };
        let writer = begin().map_err(|error| beside.error(source(error)))?;
        Ok(Self { beside, writer, buffer })
    }

    /// Writes a line of one variable, band by band.
    pub(super) fn write(
        &mut self,
        name: &str,
        line: usize,
        values: &[f32],
    ) -> Result<(), OutputError> {
        let written = self.writer.write_record_f32(name, line, values);
        written.map_err(|error| self.beside.error(source(error)))
    }

    /// Gives the file its name.
    pub(super) fn done(self) -> Result<(), OutputError> {
        let Self { beside, writer, mut buffer } = self;
        writer.close().map_err(|error| beside.error(source(error)))?;
        buffer.flush().map_err(|error| beside.error(error))?;
        beside.done()
    }
}

fn source(error: WriteError) -> io::Error {
    match error {
        WriteError::IOErrorKind(kind) => kind.into(),
        other => io::Error::other(format!("{other:?}")),
    }
}
