//! ENVI files as they are written: little-endian, band by band.

use std::fmt::Write as _;
use std::path::Path;

use crate::support::output::{self, Beside, OutputError};

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An image in single precision.
    Image,
    /// A spectral library in double precision.
    Library,
}

/// What the header of a file says.
#[derive(Debug, Clone)]
pub(crate) struct Contents<'a> {
    pub kind: Kind,
    /// The numbers' quantity and unit.
    pub quantity: &'a str,
    /// Samples, lines and bands of an image; wavelengths, spectra and 1 of a library.
    pub size: [usize; 3],
    /// Names of the bands of an image or of the spectra of a library; may be empty.
    pub names: &'a [String],
    /// Wavelengths, um; empty where the bands are no spectrum.
    pub wavelengths_um: &'a [f64],
    /// Full widths of the bands at half maximum, um; empty where they are not known.
    pub widths_um: &'a [f64],
    /// Bands that are not to be used; may be empty.
    pub is_bad: &'a [bool],
}

/// Names of bands by their wavelengths, um.
pub(crate) fn band_names(wavelengths_um: &[f64]) -> Vec<String> {
    wavelengths_um.iter().map(|um| format!("{um} um")).collect()
}

impl Contents<'_> {
    /// The text of the header.
    fn header(&self) -> String {
        let [samples, lines, bands] = self.size;
        let (file_type, data_type, of_names, scale) = match self.kind {
            Kind::Image => ("Standard", 4, "band names", ""),
            Kind::Library => {
                ("Spectral Library", 5, "spectra names", "reflectance scale factor = 1.0\n")
            }
        };
        let quantity = self.quantity;
        let mut text = format!(
            "ENVI\ndescription = {{soilsig: {quantity}}}\nsamples = {samples}\nlines = {lines}\n\
             bands = {bands}\nheader offset = 0\nfile type = ENVI {file_type}\n\
             data type = {data_type}\ninterleave = bsq\nbyte order = 0\n"
        );
        let has_spectrum = !self.wavelengths_um.is_empty();
        if has_spectrum {
            let _ = write!(
                text,
                "wavelength units = Micrometers\n{scale}z plot titles = {{Wavelength (um), {}}}\n",
                quantity.replace(',', " ")
            );
        }
        if !self.names.is_empty() {
            // A header has no way to quote these characters.
            let names = self.names.iter().map(|name| name.replace(['{', '}', ','], " "));
            let _ = writeln!(text, "{of_names} = {{{}}}", names.collect::<Vec<_>>().join(", "));
        }
        if has_spectrum {
            let list = |um: &[f64]| um.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
            let _ = writeln!(text, "wavelength = {{{}}}", list(self.wavelengths_um));
            if self.widths_um.iter().any(|width| *width > 0.0) {
                let _ = writeln!(text, "fwhm = {{{}}}", list(self.widths_um));
            }
        }
        if self.is_bad.contains(&true) {
            let good = self.is_bad.iter().map(|bad| if *bad { "0" } else { "1" });
            let _ = writeln!(text, "bbl = {{{}}}", good.collect::<Vec<_>>().join(", "));
        }
        text
    }
}

/// Writes a whole file: the data, then the header beside it.
pub(crate) fn write(path: &Path, contents: &Contents, data: &[u8]) -> Result<(), OutputError> {
    let whole = |path: &Path, bytes: &[u8]| {
        let file = Beside::new(path)?;
        file.write_at(bytes, 0).map(|()| file)
    };
    // Both are whole before either has its name.
    let data = whole(path, data)?;
    let name = path.with_extension("hdr");
    let name = name.file_name().unwrap_or_default().to_string_lossy();
    let header = whole(&output::sibling(path, &name)?, contents.header().as_bytes())?;
    data.done()?;
    header.done()
}

/// An image that is written line by line, so that it need not fit into memory.
pub(crate) struct Image {
    data: Beside,
    header: Beside,
    lines: usize,
}

impl Image {
    /// Begins an image in a result's folder.
    pub(crate) fn new(folder: &Path, name: &str, contents: &Contents) -> Result<Self, OutputError> {
        let data = Beside::new(&output::within(folder, name)?)?;
        let header = Path::new(name).with_extension("hdr");
        let header = Beside::new(&output::within(folder, &header.to_string_lossy())?)?;
        header.write_at(contents.header().as_bytes(), 0)?;
        Ok(Self { data, header, lines: contents.size[1] })
    }

    /// Writes one line, band by band.
    pub(crate) fn write(
        &self,
        line: usize,
        samples: usize,
        values: &[f32],
    ) -> Result<(), OutputError> {
        for (band, values) in values.chunks_exact(samples).enumerate() {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            let place = (band * self.lines + line) * samples * size_of::<f32>();
            self.data.write_at(&bytes, place as u64)?;
        }
        Ok(())
    }

    /// Gives data and header their names.
    pub(crate) fn done(self) -> Result<(), OutputError> {
        self.data.done()?;
        self.header.done()
    }
}
