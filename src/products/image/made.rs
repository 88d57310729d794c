//! What an image took, and how exact it is.

use super::Asked;
use super::pixel::Pixel;

/// The statistics of an image.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Made {
    /// Columns and lines.
    pub pixels: [usize; 2],
    /// Bands.
    pub bands: usize,
    /// Paths of all pixels, without their pilots.
    pub paths: u64,
    /// Share of pixels that see nothing.
    pub empty: f64,
    /// Standard error in emissivity of each pixel's widest band: root mean square over the pixels.
    pub noise: f64,
    /// Share of pixels that reach the standard error asked for.
    pub reached: f64,
    /// Share of pixels that would need more paths than allowed.
    pub capped: f64,
    /// Warnings about the bed, the spectra and the bands.
    pub warnings: Vec<String>,
}

impl Made {
    pub(super) fn new(pixels: [usize; 2], bands: usize) -> Self {
        Self {
            pixels,
            bands,
            paths: 0,
            empty: 0.0,
            noise: 0.0,
            reached: 0.0,
            capped: 0.0,
            warnings: Vec::new(),
        }
    }

    /// Adds a pixel to the sums, from which [`Made::means`] makes means.
    pub(super) fn count(&mut self, pixel: &Pixel, asked: &Asked) {
        self.paths += pixel.paths;
        let error = f64::from(pixel.maps[3]);
        if error.is_nan() {
            self.empty += 1.0;
            return;
        }
        self.noise += error * error;
        self.reached += f64::from(u8::from(error <= asked.noise));
        self.capped += f64::from(u8::from(pixel.paths == asked.max_paths && error > asked.noise));
    }

    /// The means over the pixels; `None` if no pixel sees anything.
    pub(super) fn means(self) -> Option<Self> {
        let all = self.all();
        let met = all - self.empty;
        (met > 0.0).then(|| Self {
            empty: self.empty / all,
            noise: (self.noise / met).sqrt(),
            reached: self.reached / met,
            capped: self.capped / met,
            ..self
        })
    }

    fn all(&self) -> f64 {
        (self.pixels[0] * self.pixels[1]) as f64
    }
}
