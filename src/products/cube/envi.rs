//! ENVI images: a data file of numbers, its .hdr file beside it.

use std::path::{Path, PathBuf};

use super::{Cube, CubeError};
use crate::spectrum::format::envi::bands_um;
use crate::support::envi::{self, Contents, Header, Kind};
use crate::support::linear::{LIKELY_UM, ends, span};
use crate::support::output::OutputError;
use crate::support::resources::need_memory;

/// Endings that data files may have.
pub(super) const ENDINGS: [&str; 10] =
    ["img", "bsq", "bil", "bip", "dat", "raw", "rdn", "rad", "rfl", "hyspex"];

/// What an image takes in memory for each of its numbers: in its file, as read, and as results.
const BYTES_OF_A_NUMBER: usize = 36;

impl Cube {
    /// Data and header of an image that is named by either.
    pub fn files(path: &Path) -> [PathBuf; 2] {
        envi::pair(path, &ENDINGS)
    }

    /// Reads an ENVI image of single or double precision in any interleave. `path` is the data or
    /// its .hdr. Bad bands and numbers to ignore become NaN.
    ///
    /// # Errors
    /// A file cannot be read, or the header does not fit the data or has no wavelengths.
    pub fn read(path: &Path) -> Result<Self, CubeError> {
        let header = Header::read(path, &ENDINGS)?;
        let wrong = |problem: String| CubeError::from(header.wrong(problem));
        let file_type = header.get("file type").unwrap_or_default().to_lowercase();
        if file_type.contains("spectral library") {
            return Err(wrong("this is a spectral library, not an image".into()));
        }
        if file_type.contains("classification") {
            return Err(wrong("this is a map of classes, not an image of spectra".into()));
        }
        header.refuse_changed_data()?;
        if let Some(unit) = other_unit(&header) {
            return Err(wrong(format!("its radiance is in {unit}: convert it to W m-2 sr-1 um-1")));
        }
        let count = |key| header.count(key, None);
        let (lines, samples, bands) = (count("lines")?, count("samples")?, count("bands")?);
        let bytes = [lines, samples, bands, BYTES_OF_A_NUMBER];
        let bytes = bytes.iter().fold(1_u64, |all, &n| all.saturating_mul(n as u64));
        need_memory(&format!("{} of {lines} x {samples} x {bands}", path.display()), bytes)?;
        let numbers = header.data([lines, samples, bands])?;
        let bands_um = bands_um(&header, bands, None)?;
        let interleave = header.get("interleave").unwrap_or("bsq").trim_matches(['"', '\'']);
        // Steps in the file from one band, line and sample to the next.
        let steps = match interleave.to_lowercase().as_str() {
            "bsq" => [lines * samples, samples, 1],
            "bil" => [samples, bands * samples, 1],
            "bip" => [1, samples * bands, bands],
            other => return Err(wrong(format!("interleave {other} is not bsq, bil or bip"))),
        };
        let mut good_um: Vec<f64> =
            bands_um.iter().filter(|(_, is_good)| *is_good).map(|(um, _)| *um).collect();
        good_um.sort_by(f64::total_cmp);
        if let Some(um) = good_um.iter().find(|um| !(um.is_finite() && **um > 0.0)) {
            return Err(wrong(format!("{um} um is not a valid wavelength")));
        }
        if good_um.last().is_some_and(|um| *um < LIKELY_UM[0])
            || good_um.first().is_some_and(|um| *um > LIKELY_UM[1])
        {
            let problem = format!("its bands are at {} um", span(ends(&good_um)));
            return Err(header
                .wrong(problem)
                .with_hint("write the unit of its wavelengths into `wavelength units`")
                .into());
        }
        if let Some([um, _]) = good_um.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(wrong(format!("two bands are at {um} um: leave out one of them")));
        }
        let mut cube = Self::new(lines, samples, bands_um.iter().map(|(um, _)| *um).collect());
        cube.is_bad = bands_um.iter().map(|(_, is_good)| !is_good).collect();
        for (band, _) in bands_um.iter().enumerate().filter(|(_, (_, is_good))| *is_good) {
            for line in 0..lines {
                for sample in 0..samples {
                    let from = band * steps[0] + line * steps[1] + sample * steps[2];
                    if let Some(value) = numbers.get(from) {
                        let to = cube.place(band, line, sample);
                        cube.data[to] = (value / numbers.scale) as f32;
                    }
                }
            }
        }
        Ok(cube)
    }

    /// Writes an ENVI image, band by band in single precision: the data to `path`, which should end
    /// in .img, then the .hdr beside it. `quantity` names the numbers and their unit.
    pub fn write(&self, path: &Path, quantity: &str) -> Result<(), OutputError> {
        let data: Vec<u8> = self.data.iter().flat_map(|value| value.to_le_bytes()).collect();
        let contents = Contents {
            kind: Kind::Image,
            quantity,
            size: [self.samples, self.lines, self.wavelengths_um.len()],
            names: &envi::band_names(&self.wavelengths_um),
            wavelengths_um: &self.wavelengths_um,
            widths_um: &[],
            is_bad: &self.is_bad,
        };
        envi::write(path, &contents, &data)
    }
}

/// The unit of radiance that a header states, if it is another than W m-2 sr-1 um-1.
fn other_unit(header: &Header) -> Option<&str> {
    let keys = ["data units", "radiance units", "units", "z plot titles"];
    let mut stated = keys.into_iter().filter_map(|key| header.get(key));
    let is_other = |text: &&str| {
        let text = text.to_lowercase().replace(['\u{b5}', '\u{3bc}'], "u");
        let words: Vec<&str> =
            text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).collect();
        if !words.iter().any(|word| word.starts_with("sr") || word.contains("flick")) {
            return false;
        }
        let Some(power) = words.iter().position(|word| ["w", "watt", "watts"].contains(word))
        else {
            return true;
        };
        let of = &words[power + 1..];
        let is_um = |word: &&str| word.starts_with("um") || word.starts_with("micro");
        let is_own = |word: &&str| is_um(word) || ["m", "m2", "1", "2", "sr", "sr1"].contains(word);
        !(of.iter().all(is_own) && of.iter().any(is_um))
    };
    stated.find(is_other)
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

    /// A written image and its header's text.
    fn written(cube: &Cube) -> (tempfile::TempDir, PathBuf, String) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("image.img");
        cube.write(&path, "radiance, W m-2 sr-1 um-1").expect("written");
        let header = std::fs::read_to_string(path.with_extension("hdr")).expect("a header");
        (folder, path, header)
    }

    fn read(path: &Path, header: &str) -> Result<Cube, CubeError> {
        std::fs::write(path.with_extension("hdr"), header).expect("written");
        Cube::read(path)
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
                    "ENVI\nsamples = 3\nlines = 2\nbands = 4\nheader offset = 3\n\
                     data type = {data_type}\ninterleave = {interleave}\n\
                     byte order = {byte_order}\nwavelength units = Nanometers\n\
                     wavelength = {{ 8250,\n 9500, 10000, 11750 }}\n"
                );
                let read = read(&path, &header).expect("an image");
                assert_eq!(read, cube, "{interleave} {data_type}");
            }
        }
    }

    #[test]
    fn bad_bands_and_ignored_numbers_are_not_known() {
        let (_folder, path, header) = written(&cube());
        let read = read(&path, &(header + "bbl = {1, 0, 1, 1}\ndata ignore value = 112\n"));
        let read = read.expect("an image");
        assert!(read.data[6..12].iter().all(|value| value.is_nan()));
        assert!(read.spectrum(1, 1)[2].is_nan());
        assert_eq!(read.data.iter().filter(|value| value.is_nan()).count(), 7);
    }

    /// The file holds the nearest number in single precision.
    #[test]
    fn a_number_to_be_ignored_is_known_as_the_file_holds_it() {
        let mut cube = cube();
        cube.data[3] = -9999.9;
        let (_folder, path, header) = written(&cube);
        let ignoring = read(&path, &(header.clone() + "data ignore value = -9999.9\n"));
        let ignoring = ignoring.expect("an image");
        assert!(ignoring.data[3].is_nan());
        assert_eq!(ignoring.data.iter().filter(|value| value.is_nan()).count(), 1);
        // Bad bands need no wavelength.
        let bad = read(&path, &(header.replace("9.5", "0") + "bbl = {1, 0, 1, 1}\n"));
        assert!(bad.expect("an image").data[6..12].iter().all(|value| value.is_nan()));
        let twice = header.replace("9.5", "8.25");
        assert_ne!(twice, header);
        let error = read(&path, &twice).expect_err("two bands at 8.25 um");
        assert!(error.to_string().contains("two bands are at 8.25 um"), "{error}");
    }

    #[test]
    fn an_image_that_is_not_whole_is_refused() {
        let (_folder, path, _) = written(&cube());
        std::fs::write(&path, [0; 4 * 23]).expect("written");
        let error = Cube::read(&path).expect_err("a number is missing");
        assert!(error.to_string().contains("do not make the 92 bytes"), "{error}");
    }
}
