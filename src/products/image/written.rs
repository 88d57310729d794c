//! The files of numbers of an image. They are written line by line: a cube of many bands need not
//! fit into memory.

use std::path::Path;

use super::netcdf::{About, CUBES, MAPS, NetCdf};
use super::pixel::Pixel;
use crate::support::envi::{Contents, Image, Kind, band_names};
use crate::support::error::Error;
use crate::support::output;

/// What the ENVI cubes hold, in the order of [`CUBES`].
const QUANTITIES: [&str; 3] = [
    "Radiance at the sensor (W m-2 sr-1 um-1)",
    "Standard error of the radiance (W m-2 sr-1 um-1)",
    "Emissivity",
];

/// Cubes and maps as ENVI images, and all of them as NetCDF.
pub(super) struct Files<'a> {
    cubes: Vec<Image>,
    maps: Image,
    netcdf: NetCdf<'a>,
}

impl<'a> Files<'a> {
    pub(super) fn new(out: &Path, set: &'a netcdf3::DataSet, about: &About) -> Result<Self, Error> {
        let envi = |name: &str, quantity: &str, wavelengths_um: &[f64], names: &[String]| {
            let [lines, samples] = about.size;
            let size = [samples, lines, wavelengths_um.len().max(names.len())];
            let (widths_um, is_bad) = if wavelengths_um.is_empty() {
                (&[][..], &[][..])
            } else {
                (about.widths_um, about.is_bad)
            };
            let kind = Kind::Image;
            let contents =
                Contents { kind, quantity, size, names, wavelengths_um, widths_um, is_bad };
            Image::new(out, &format!("{name}.img"), &contents)
        };
        let cubes = CUBES.iter().zip(QUANTITIES);
        let names = band_names(about.wavelengths_um);
        let cubes =
            cubes.map(|(name, quantity)| envi(name, quantity, about.wavelengths_um, &names));
        let quantity = format!("maps; material 0 on: {}", about.materials.join(" "));
        Ok(Self {
            cubes: cubes.collect::<Result<_, _>>()?,
            maps: envi("maps", &quantity, &[], &MAPS.map(str::to_owned))?,
            netcdf: NetCdf::new(&output::within(out, "image.nc")?, set, about)?,
        })
    }

    /// Writes the pixels of one line.
    pub(super) fn write(&mut self, line: usize, pixels: &[Pixel]) -> Result<(), Error> {
        let samples = pixels.len();
        let by_band = |of: &dyn Fn(&Pixel, usize) -> f32, bands: usize| -> Vec<f32> {
            (0..bands).flat_map(|band| pixels.iter().map(move |p| of(p, band))).collect()
        };
        for (i, (cube, name)) in self.cubes.iter().zip(CUBES).enumerate() {
            let values = by_band(&|pixel, band| pixel.cubes[i][band], pixels[0].cubes[i].len());
            cube.write(line, samples, &values)?;
            self.netcdf.write(name, line, &values)?;
        }
        let values = by_band(&|pixel, map| pixel.maps[map], MAPS.len());
        self.maps.write(line, samples, &values)?;
        for (name, values) in MAPS.iter().zip(values.chunks(samples)) {
            self.netcdf.write(name, line, values)?;
        }
        Ok(())
    }

    /// Gives the files their names.
    pub(super) fn done(self) -> Result<(), Error> {
        self.cubes.into_iter().try_for_each(Image::done)?;
        self.maps.done()?;
        Ok(self.netcdf.done()?)
    }
}
