//! Image cubes: a spectrum for every pixel.

mod envi;
mod radiance;

use crate::support::error::{Failure, Status};
use crate::support::file_error::FileError;
use crate::support::resources::ResourceError;

/// An image cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum CubeError {
    /// The file cannot be read, or is not such an image.
    #[error(transparent)]
    File(#[from] FileError),
    /// It is too large for the memory.
    #[error(transparent)]
    Resource(#[from] ResourceError),
}

impl Failure for CubeError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::File(error) => {
                error.hint_or("docs/guide/images.md says which ENVI images are read")
            }
            Self::Resource(_) => Some("cut the image into parts".into()),
        }
    }

    fn status(&self) -> Status {
        match self {
            Self::File(error) => error.status(),
            Self::Resource(error) => error.status(),
        }
    }
}

/// An image with a spectrum for every pixel. Unknown numbers are NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct Cube {
    /// Lines, from the top of the image.
    pub lines: usize,
    /// Pixels of a line, from the left.
    pub samples: usize,
    /// Wavelengths of the bands, um.
    pub wavelengths_um: Vec<f64>,
    /// Whether the header's list of bad bands leaves a band out.
    pub is_bad: Vec<bool>,
    /// Numbers band by band, in each band line by line. Radiance is in W m-2 sr-1 um-1.
    pub data: Vec<f32>,
}

impl Cube {
    /// A cube of NaN.
    pub fn new(lines: usize, samples: usize, wavelengths_um: Vec<f64>) -> Self {
        let data = vec![f32::NAN; lines * samples * wavelengths_um.len()];
        let is_bad = vec![false; wavelengths_um.len()];
        Self { lines, samples, wavelengths_um, is_bad, data }
    }

    /// The index of a number in the data.
    pub fn place(&self, band: usize, line: usize, sample: usize) -> usize {
        (band * self.lines + line) * self.samples + sample
    }

    /// The spectrum of a pixel.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn spectrum(&self, line: usize, sample: usize) -> Vec<f32> {
        (0..self.wavelengths_um.len())
            .map(|band| self.data[self.place(band, line, sample)])
            .collect()
    }

    /// Sets the spectrum of a pixel.
    ///
    /// # Panics
    /// If there is no such pixel, or the spectrum has another number of bands.
    pub fn set_spectrum(&mut self, line: usize, sample: usize, spectrum: &[f32]) {
        assert_eq!(spectrum.len(), self.wavelengths_um.len(), "a number for each band");
        for (band, &value) in spectrum.iter().enumerate() {
            let place = self.place(band, line, sample);
            self.data[place] = value;
        }
    }
}
