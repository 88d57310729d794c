//! An image as NetCDF with the attributes of the CF conventions.
//!
//! Lines are the unlimited dimension, so that they can be written one by one, and a file may be larger than 2 GB.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;
use std::rc::Rc;

use netcdf3::{DataSet, FileWriter, InvalidDataSet, Version, WriteError};

use crate::support::output::{Beside, OutputError};

/// The CF name of what leaves a surface, without that of the wavelength it goes by.
const RADIANCE: &str = "upwelling_radiance_per_unit_wavelength_in_air";

/// What a file says of itself besides its numbers.
pub(super) struct About<'a> {
    pub title: &'a str,
    pub scene_sha256: &'a str,
    pub temperature_k: f64,
    pub view_deg: [f64; 2],
    pub seed: u64,
    pub materials: &'a [String],
    /// Size of a pixel, um, where all see as much.
    pub pixel_um: Option<[f64; 2]>,
    /// Lines and samples.
    pub size: [usize; 2],
    pub wavelengths_um: &'a [f64],
}

/// Names of the variables, by lines and bands or by lines alone, in the order in which a line's values come.
pub(super) const CUBES: [&str; 3] = ["radiance", "radiance_standard_error", "emissivity"];
pub(super) const MAPS: [&str; 4] = ["material", "hits", "paths", "emissivity_standard_error"];

/// The dimensions, variables and attributes of a file.
pub(super) fn data_set(about: &About) -> DataSet {
    define(about).expect("names and sizes are sound")
}

fn define(about: &About) -> Result<DataSet, InvalidDataSet> {
    let mut set = DataSet::new();
    set.set_unlimited_dim("y", about.size[0])?;
    set.add_fixed_dim("wavelength", about.wavelengths_um.len())?;
    set.add_fixed_dim("x", about.size[1])?;
    set.add_global_attr_string("Conventions", "CF-1.11")?;
    set.add_global_attr_string("title", about.title)?;
    set.add_global_attr_string("source", concat!("soilsig ", env!("CARGO_PKG_VERSION")))?;
    set.add_global_attr_string("scene_sha256", about.scene_sha256)?;
    set.add_global_attr_string("seed", about.seed.to_string())?;
    set.add_global_attr_f64("temperature_k", vec![about.temperature_k])?;
    set.add_global_attr_f64("view_zenith_deg", vec![about.view_deg[0]])?;
    set.add_global_attr_f64("view_azimuth_deg", vec![about.view_deg[1]])?;

    let mut variable = |name: &str, dimensions: &[&str], texts: &[(&str, &str)]| {
        let double = dimensions.len() == 1;
        if double {
            set.add_var_f64(name, dimensions)?;
        } else {
            set.add_var_f32(name, dimensions)?;
        }
        for (key, text) in texts.iter().filter(|(_, text)| !text.is_empty()) {
            set.add_var_attr_string(name, key, text)?;
        }
        Ok::<(), InvalidDataSet>(())
    };
    let (length, of) =
        if about.pixel_um.is_some() { ("um", "middle of the pixel") } else { ("1", "pixel") };
    let from = |edge: &str| format!("{of}, from the {edge} edge of the view");
    variable("y", &["y"], &[("long_name", &from("upper")), ("units", length), ("axis", "Y")])?;
    variable("x", &["x"], &[("long_name", &from("left")), ("units", length), ("axis", "X")])?;
    variable(
        "wavelength",
        &["wavelength"],
        &[("standard_name", "radiation_wavelength"), ("units", "um")],
    )?;
    let cube = ["y", "wavelength", "x"];
    let unit = ("units", "W m-2 sr-1 um-1");
    let errors = ("ancillary_variables", "radiance_standard_error");
    let long = ("long_name", "radiance at the sensor");
    variable(CUBES[0], &cube, &[("standard_name", RADIANCE), long, unit, errors])?;
    let name = format!("{RADIANCE} standard_error");
    let long = ("long_name", "standard error of the radiance, rays and sensor noise");
    variable(CUBES[1], &cube, &[("standard_name", &name), long, unit])?;
    let long = ("long_name", "emissivity of the bed towards the sensor");
    variable(CUBES[2], &cube, &[long, ("units", "1")])?;

    let map = ["y", "x"];
    // Blanks separate the meanings.
    let meanings: Vec<String> = about.materials.iter().map(|name| name.replace(' ', "_")).collect();
    let long = ("long_name", "material that fills most of the pixel");
    variable(MAPS[0], &map, &[long, ("flag_meanings", &meanings.join(" "))])?;
    variable(MAPS[1], &map, &[("long_name", "mean number of hits of a path"), ("units", "1")])?;
    variable(MAPS[2], &map, &[("long_name", "paths of the pixel"), ("units", "1")])?;
    let long = ("long_name", "standard error of the emissivity in the widest band");
    variable(MAPS[3], &map, &[long, ("units", "1")])?;
    let flags = (0..about.materials.len()).map(|i| i as f32).collect();
    set.add_var_attr_f32(MAPS[0], "flag_values", flags)?;
    Ok(set)
}

/// A file under way.
pub(super) struct NetCdf<'a> {
    beside: Beside,
    writer: FileWriter<'a>,
    buffer: Buffer,
}

/// A buffer that outlives the writer, which writes number by number and would let what fails at the end go unsaid.
#[derive(Clone)]
struct Buffer(Rc<RefCell<BufWriter<File>>>);

impl Write for Buffer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.borrow_mut().flush()
    }
}

impl Seek for Buffer {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.borrow_mut().seek(to)
    }
}

impl<'a> NetCdf<'a> {
    /// Begins a file and writes its coordinates.
    pub(super) fn new(path: &Path, set: &'a DataSet, about: &About) -> Result<Self, OutputError> {
        let beside = Beside::new(path)?;
        let out = BufWriter::with_capacity(1 << 20, beside.handle()?);
        let buffer = Buffer(Rc::new(RefCell::new(out)));
        let begin = || -> Result<FileWriter<'a>, WriteError> {
            let mut writer = FileWriter::open_seek_write("image", Box::new(buffer.clone()))?;
            writer.set_def(set, Version::Offset64Bit, 0)?;
            let [height, width] = about.pixel_um.map_or([1.0, 1.0], |[x, y]| [y, x]);
            // Pixels without a size are numbered.
            let half = if about.pixel_um.is_some() { 0.5 } else { 0.0 };
            let middles = |number: usize, size: f64| -> Vec<f64> {
                (0..number).map(|i| (i as f64 + half) * size).collect()
            };
            writer.write_var_f64("x", &middles(about.size[1], width))?;
            writer.write_var_f64("wavelength", about.wavelengths_um)?;
            for (line, y) in middles(about.size[0], height).into_iter().enumerate() {
                writer.write_record_f64("y", line, &[y])?;
            }
            Ok(writer)
        };
        let writer = begin().map_err(|error| beside.error(source(error)))?;
        Ok(Self { beside, writer, buffer })
    }

    /// Writes a line of one variable: of a cube band by band.
    pub(super) fn write(
        &mut self,
        name: &str,
        line: usize,
        values: &[f32],
    ) -> Result<(), OutputError> {
        let written = self.writer.write_record_f32(name, line, values);
        written.map_err(|error| self.beside.error(source(error)))
    }

    /// Puts the file in its place.
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
