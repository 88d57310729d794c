//! Spectra on other wavelengths: by point, or as a sensor's bands see them.

use std::path::Path;

use super::format::{Reading, read_one};
use super::{Quantity, Spectrum, SpectrumError};

/// The response of a band: straight lines between points, nothing outside them.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    wavelength_um: Vec<f64>,
    weight: Vec<f64>,
}

impl Response {
    /// The triangle of a spectrometer's slit: full width at half maximum `width_um`.
    pub fn triangle(centre_um: f64, width_um: f64) -> Self {
        Self {
            wavelength_um: vec![centre_um - width_um, centre_um, centre_um + width_um],
            weight: vec![0.0, 1.0, 0.0],
        }
    }

    /// A response function of two columns, wavelength in um and response from 0 to 1.
    pub fn read(path: &Path) -> Result<Self, SpectrumError> {
        // The numbers are as they stand, whatever the heading calls them.
        let reading = Reading { quantity: Some(Quantity::Emissivity), ..Reading::default() };
        let points = read_one(path, &reading)?;
        if points.emissivity.iter().all(|&weight| weight == 0.0) {
            return Err(SpectrumError::File {
                path: path.to_owned(),
                problem: "the response is 0 at every wavelength".into(),
                hint: "bring a response function with its maximum at 1",
            });
        }
        Ok(Self { wavelength_um: points.wavelength_um, weight: points.emissivity })
    }

    /// Centroid, um.
    pub fn centre_um(&self) -> f64 {
        self.integral(&[], Ok).expect("no error in it") / self.area()
    }

    /// Emissivity of a spectrum as the band sees it: the mean weighed by the response, exact for
    /// tabulated spectra.
    ///
    /// # Errors
    /// A spectrum that does not hold all of the band.
    pub fn band_mean(&self, spectrum: &Spectrum) -> Result<f64, SpectrumError> {
        let span = [self.wavelength_um[0], self.wavelength_um[self.wavelength_um.len() - 1]];
        spectrum.covers(span)?;
        let steps: Vec<f64> = if let Spectrum::Tabulated(points) = spectrum {
            points.wavelength_um.clone()
        } else {
            // Curves bend on a scale of 10 nm or more.
            let steps = ((span[1] - span[0]) / 1e-3) as u32;
            (1..=steps).map(|i| span[0] + 1e-3 * f64::from(i)).collect()
        };
        Ok(self.integral(&steps, |um| spectrum.emissivity(um))? / self.area())
    }

    fn area(&self) -> f64 {
        self.integral(&[], |_| Ok(1.0)).expect("no error in it")
    }

    /// Integral of response times `of`, by Simpson's rule between all points of both: exact where both are
    /// straight there.
    fn integral(
        &self,
        further_um: &[f64],
        of: impl Fn(f64) -> Result<f64, SpectrumError>,
    ) -> Result<f64, SpectrumError> {
        let span = self.wavelength_um[0]..*self.wavelength_um.last().expect("two points");
        let mut nodes = self.wavelength_um.clone();
        nodes.extend(further_um.iter().filter(|um| span.contains(um)));
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        let weighed = |um| of(um).map(|value| self.at(um) * value);
        nodes.windows(2).try_fold(0.0, |sum, ends| {
            let middle = f64::midpoint(ends[0], ends[1]);
            let mean = (weighed(ends[0])? + 4.0 * weighed(middle)? + weighed(ends[1])?) / 6.0;
            Ok(sum + mean * (ends[1] - ends[0]))
        })
    }

    fn at(&self, um: f64) -> f64 {
        let above =
            self.wavelength_um.partition_point(|&x| x < um).clamp(1, self.wavelength_um.len() - 1);
        let (x, y) = (&self.wavelength_um[above - 1..=above], &self.weight[above - 1..=above]);
        y[0] + (y[1] - y[0]) * (um - x[0]) / (x[1] - x[0])
    }
}

/// What is lost by resampling: straight lines between the new points, less the spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResamplingError {
    /// Root mean square, over the points of the spectrum and midway between the new ones.
    pub rms: f64,
    /// The largest, with its sign.
    pub largest: f64,
    /// Where it is, um.
    pub at_um: f64,
}

/// Compares points on ascending wavelengths (um, at least two) with the spectrum they come from.
pub fn resampling_error(
    spectrum: &Spectrum,
    wavelength_um: &[f64],
    emissivity: &[f64],
) -> Result<ResamplingError, SpectrumError> {
    let line = Response { wavelength_um: wavelength_um.to_vec(), weight: emissivity.to_vec() };
    let span = wavelength_um[0]..=wavelength_um[wavelength_um.len() - 1];
    let mut at: Vec<f64> = wavelength_um.windows(2).map(|w| f64::midpoint(w[0], w[1])).collect();
    at.extend(wavelength_um);
    if let Spectrum::Tabulated(points) = spectrum {
        at.extend(points.wavelength_um.iter().filter(|um| span.contains(um)));
    }
    let mut worst = (0.0_f64, wavelength_um[0]);
    let mut squares = 0.0;
    for &um in &at {
        let error = line.at(um) - spectrum.emissivity(um)?;
        squares += error * error;
        if error.abs() > worst.0.abs() {
            worst = (error, um);
        }
    }
    Ok(ResamplingError {
        rms: (squares / at.len() as f64).sqrt(),
        largest: worst.0,
        at_um: worst.1,
    })
}
