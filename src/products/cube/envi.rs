//! ENVI images: the numbers band by band in a .img file, what they mean in the .hdr beside it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::Cube;
use crate::spectrum::format::Unit;
use crate::support::envi::{EnviError, Header, pair};
use crate::support::output::{self, OutputError};

/// Endings of the data that a header may stand beside.
const ENDINGS: [&str; 6] = ["img", "bsq", "bil", "bip", "dat", "raw"];

/// The header of an image as soilsig writes them: band by band in single precision.
#[derive(Debug, Clone)]
pub struct ImageHeader<'a> {
    /// What the numbers are, and their unit.
    pub quantity: &'a str,
    /// Lines.
    pub lines: usize,
    /// Pixels of a line.
    pub samples: usize,
    /// Wavelengths, um; none where the bands are no spectrum.
    pub wavelengths_um: &'a [f64],
    /// Names of the bands; none where their wavelengths tell them.
    pub band_names: &'a [String],
}

impl ImageHeader<'_> {
    /// The text of the .hdr file.
    pub fn text(&self) -> String {
        let list = |items: Vec<String>| items.join(", ");
        let mut text = format!(
            "ENVI\ndescription = {{soilsig: {}}}\nsamples = {}\nlines = {}\nbands = {}\n\
             header offset = 0\nfile type = ENVI Standard\ndata type = 4\ninterleave = bsq\nbyte order = 0\n",
            self.quantity,
            self.samples,
            self.lines,
            self.wavelengths_um.len().max(self.band_names.len()),
        );
        if !self.band_names.is_empty() {
            // What separates names in a header cannot stand in one.
            let names = self.band_names.iter().map(|name| name.replace(['{', '}', ','], " "));
            let _ = writeln!(text, "band names = {{{}}}", list(names.collect()));
        }
        if !self.wavelengths_um.is_empty() {
            let _ = writeln!(
                text,
                "wavelength units = Micrometers\nz plot titles = {{Wavelength (um), {}}}\n\
                 wavelength = {{{}}}",
                self.quantity.replace(',', " "),
                list(self.wavelengths_um.iter().map(ToString::to_string).collect()),
            );
        }
        text
    }
}

impl Cube {
    /// The data and the header of an image that is named by either.
    pub fn files(path: &Path) -> [PathBuf; 2] {
        pair(path, &ENDINGS).into()
    }

    /// Reads an ENVI image of single or double precision in any interleave; `path` is the data or its .hdr. Bands that the
    /// header calls bad and numbers to be ignored are not known.
    ///
    /// # Errors
    /// A file that cannot be read, a header that does not fit the data or gives no wavelengths.
    pub fn read(path: &Path) -> Result<Self, EnviError> {
        let (data, header_path) = pair(path, &ENDINGS);
        let header = Header::read(&header_path)?;
        let wrong = |problem: String| header.wrong(problem);
        if let Some(kind) = header.get("file type")
            && kind.to_lowercase().contains("spectral library")
        {
            return Err(wrong("this is a spectral library, and an image is wanted".into()));
        }
        for key in ["data gain values", "data offset values"] {
            if header.get(key).is_some() {
                return Err(wrong(format!("{key} are not applied: bring the numbers themselves")));
            }
        }
        let count = |key| header.count(key, None);
        let (lines, samples, bands) = (count("lines")?, count("samples")?, count("bands")?);
        let float = header.float()?;
        let bytes = header.data(&data, [lines, samples, bands])?;
        let units = header.get("wavelength units").unwrap_or_default();
        let unit = Unit::named(units)
            .ok_or_else(|| wrong(format!("wavelength units {units:?} are not known")))?;
        let wavelengths = header.numbers("wavelength")?;
        let is_good = match header.get("bbl") {
            None => vec![1.0; bands],
            Some(_) => header.numbers("bbl")?,
        };
        if wavelengths.len() != bands || is_good.len() != bands {
            return Err(wrong(format!(
                "there must be {bands} wavelengths (and entries of bbl, if any)"
            )));
        }
        let ignored =
            header.numbers("data ignore value")?.first().map(|&value| float.rounded(value));
        let scale = header.numbers("reflectance scale factor")?.first().copied().unwrap_or(1.0);
        // From what is next to each other in the file to band, line and sample.
        let place: fn([usize; 3], [usize; 3]) -> usize =
            match header.get("interleave").unwrap_or("bsq").to_lowercase().as_str() {
                "bsq" => |[lines, samples, _], [b, l, s]| (b * lines + l) * samples + s,
                "bil" => |[_, samples, bands], [b, l, s]| (l * bands + b) * samples + s,
                "bip" => |[_, samples, bands], [b, l, s]| (l * samples + s) * bands + b,
                other => return Err(wrong(format!("interleave {other} is not bsq, bil or bip"))),
            };
        let wavelengths_um: Vec<f64> = wavelengths.iter().map(|&value| unit.um(value)).collect();
        let good = wavelengths_um.iter().zip(&is_good).filter(|(_, good)| **good != 0.0);
        let mut ascending: Vec<f64> = good.map(|(um, _)| *um).collect();
        ascending.sort_by(f64::total_cmp);
        if let Some(um) = ascending.iter().find(|um| !(um.is_finite() && **um > 0.0)) {
            return Err(wrong(format!("a wavelength of {um} um is none")));
        }
        if let Some([um, _]) = ascending.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(wrong(format!("two bands are at {um} um: leave one of them out")));
        }
        let mut cube = Self::new(lines, samples, wavelengths_um);
        for (band, _) in is_good.iter().enumerate().filter(|(_, good)| **good != 0.0) {
            for line in 0..lines {
                for sample in 0..samples {
                    let at = place([lines, samples, bands], [band, line, sample]) * float.size();
                    let value = float.read(&bytes[at..at + float.size()]);
                    if ignored != Some(value) {
                        let to = cube.place(band, line, sample);
                        cube.data[to] = (value / scale) as f32;
                    }
                }
            }
        }
        Ok(cube)
    }

    /// Writes the cube as ENVI image, band by band in single precision: the data first, to a path that should end
    /// in .img, then the .hdr beside it. `quantity` is what the numbers are, and their unit.
    pub fn write(&self, path: &Path, quantity: &str) -> Result<(), OutputError> {
        let data: Vec<u8> = self.data.iter().flat_map(|value| value.to_le_bytes()).collect();
        let header = ImageHeader {
            quantity,
            lines: self.lines,
            samples: self.samples,
            wavelengths_um: &self.wavelengths_um,
            band_names: &[],
        };
        output::bytes(path, &data)?;
        output::bytes(&path.with_extension("hdr"), header.text().as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each number tells its place.
    fn cube() -> Cube {
        let mut cube = Cube::new(2, 3, vec![8.25, 9.5, 10.0, 11.75]);
        for line in 0..2 {
            for sample in 0..3 {
                let spectrum = [0, 1, 2, 3].map(|band| (100 * line + 10 * sample + band) as f32);
                cube.set_spectrum(line, sample, &spectrum);
            }
        }
        cube
    }

    #[test]
    fn a_cube_reads_back_to_the_last_bit_by_its_data_or_its_header() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("radiance.img");
        let mut cube = cube();
        cube.data[5] = f32::MIN_POSITIVE;
        cube.write(&path, "radiance, W m-2 sr-1 um-1").expect("written");
        for named in [path.clone(), path.with_extension("hdr")] {
            assert_eq!(Cube::read(&named).expect("an image"), cube);
        }
        let header = std::fs::read_to_string(path.with_extension("hdr")).expect("a header");
        assert!(header.contains("\nwavelength units = Micrometers\n"));
    }

    #[test]
    fn every_interleave_precision_and_byte_order_gives_the_same_cube() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cube = cube();
        let orders: [(&str, [usize; 3]); 3] =
            [("bsq", [0, 1, 2]), ("bil", [1, 0, 2]), ("bip", [1, 2, 0])];
        let sizes = [4, 2, 3];
        for (interleave, order) in orders {
            for (data_type, byte_order) in [(4, 0), (4, 1), (5, 0), (5, 1)] {
                let mut data = vec![0; 3];
                for i in 0..24 {
                    let mut at = [0; 3];
                    at[order[2]] = i % sizes[order[2]];
                    at[order[1]] = i / sizes[order[2]] % sizes[order[1]];
                    at[order[0]] = i / sizes[order[2]] / sizes[order[1]];
                    let [band, line, sample] = at;
                    let value = cube.data[cube.place(band, line, sample)];
                    let mut bytes = match data_type {
                        4 => value.to_le_bytes().to_vec(),
                        _ => f64::from(value).to_le_bytes().to_vec(),
                    };
                    if byte_order == 1 {
                        bytes.reverse();
                    }
                    data.extend(bytes);
                }
                let path = folder.path().join("theirs.dat");
                std::fs::write(&path, data).expect("written");
                let header = format!(
                    "ENVI\nsamples = 3\nlines = 2\nbands = 4\nheader offset = 3\ndata type = {data_type}\n\
                     interleave = {interleave}\nbyte order = {byte_order}\nwavelength units = Nanometers\n\
                     wavelength = {{ 8250,\n 9500, 10000, 11750 }}\n"
                );
                std::fs::write(folder.path().join("theirs.hdr"), header).expect("written");
                assert_eq!(Cube::read(&path).expect("an image"), cube, "{interleave} {data_type}");
            }
        }
    }

    #[test]
    fn bad_bands_and_ignored_numbers_are_not_known() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("image.img");
        cube().write(&path, "radiance").expect("written");
        let header_path = path.with_extension("hdr");
        let mut header = std::fs::read_to_string(&header_path).expect("a header");
        header += "bbl = {1, 0, 1, 1}\ndata ignore value = 112\n";
        std::fs::write(&header_path, header).expect("written");
        let read = Cube::read(&path).expect("an image");
        assert!(read.band(1).iter().all(|value| value.is_nan()));
        assert!(read.spectrum(1, 1)[2].is_nan());
        assert_eq!(read.data.iter().filter(|value| value.is_nan()).count(), 7);
    }

    /// Of a number that singles do not hold, what the file has is the nearest that they do.
    #[test]
    fn a_number_to_be_ignored_is_known_as_the_file_holds_it() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("image.img");
        let mut cube = cube();
        cube.data[3] = -9999.9;
        cube.write(&path, "radiance").expect("written");
        let header_path = path.with_extension("hdr");
        let header = std::fs::read_to_string(&header_path).expect("a header");
        std::fs::write(&header_path, header.clone() + "data ignore value = -9999.9\n")
            .expect("written");
        let read = Cube::read(&path).expect("an image");
        assert!(read.data[3].is_nan());
        assert_eq!(read.data.iter().filter(|value| value.is_nan()).count(), 1);
        // Bad bands need no wavelength.
        let bad = header.replace("9.5", "0") + "bbl = {1, 0, 1, 1}\n";
        std::fs::write(&header_path, bad).expect("written");
        assert!(Cube::read(&path).expect("an image").band(1).iter().all(|value| value.is_nan()));
        let twice = header.replace("9.5", "8.25");
        assert_ne!(twice, header);
        std::fs::write(&header_path, twice).expect("written");
        let error = Cube::read(&path).expect_err("two bands at 8.25 um");
        assert!(error.to_string().contains("two bands are at 8.25 um"), "{error}");
    }

    #[test]
    fn an_image_that_is_not_whole_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("image.img");
        cube().write(&path, "radiance").expect("written");
        std::fs::write(&path, [0; 4 * 23]).expect("written");
        let error = Cube::read(&path).expect_err("a number is missing");
        assert!(error.to_string().contains("do not make the 92 bytes"), "{error}");
    }
}
