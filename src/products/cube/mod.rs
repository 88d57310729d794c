//! Image cubes: a spectrum for every pixel.

mod envi;

pub use envi::ImageHeader;

/// An image of so many lines and samples (columns) in so many bands.
///
/// Radiance is in W m-2 sr-1 um-1. What is not known is not a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Cube {
    /// Lines, from the top of the image.
    pub lines: usize,
    /// Pixels of a line, from the left.
    pub samples: usize,
    /// Wavelengths of the bands, um.
    pub wavelengths_um: Vec<f64>,
    /// Band by band, in it line by line.
    pub data: Vec<f32>,
}

impl Cube {
    /// A cube in which nothing is known yet.
    pub fn new(lines: usize, samples: usize, wavelengths_um: Vec<f64>) -> Self {
        let data = vec![f32::NAN; lines * samples * wavelengths_um.len()];
        Self { lines, samples, wavelengths_um, data }
    }

    /// Where a number stands in the data.
    pub fn place(&self, band: usize, line: usize, sample: usize) -> usize {
        (band * self.lines + line) * self.samples + sample
    }

    /// One band of the image, line by line.
    ///
    /// # Panics
    /// Without such a band.
    pub fn band(&self, band: usize) -> &[f32] {
        let size = self.lines * self.samples;
        &self.data[band * size..][..size]
    }

    /// The spectrum of a pixel.
    ///
    /// # Panics
    /// Without such a pixel.
    pub fn spectrum(&self, line: usize, sample: usize) -> Vec<f32> {
        (0..self.wavelengths_um.len())
            .map(|band| self.data[self.place(band, line, sample)])
            .collect()
    }

    /// Puts a spectrum into a pixel.
    ///
    /// # Panics
    /// Without such a pixel, or if the spectrum has not as many bands.
    pub fn set_spectrum(&mut self, line: usize, sample: usize, spectrum: &[f32]) {
        assert_eq!(spectrum.len(), self.wavelengths_um.len(), "as many bands as the cube has");
        for (band, &value) in spectrum.iter().enumerate() {
            let place = self.place(band, line, sample);
            self.data[place] = value;
        }
    }
}
