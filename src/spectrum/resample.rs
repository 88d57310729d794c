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
            // Without what a sum is rounded by: it may end where a spectrum does.
            wavelength_um: [centre_um - width_um, centre_um, centre_um + width_um]
                .map(|um| (um * 1e9).round() / 1e9)
                .to_vec(),
            weight: vec![0.0, 1.0, 0.0],
        }
    }

    /// A band that responds alike from one wavelength to another, which is greater.
    pub fn boxed(from_um: f64, to_um: f64) -> Self {
        Self { wavelength_um: vec![from_um, to_um], weight: vec![1.0, 1.0] }
    }

    /// A Gaussian of full width at half maximum `fwhm_um`, above 0, as far as it is above 1e-4 of its maximum.
    pub fn gaussian(centre_um: f64, fwhm_um: f64) -> Self {
        let points = -60..=60;
        let half_um = fwhm_um / 2.0 * (1e4_f64.ln() / 2_f64.ln()).sqrt();
        let (wavelength_um, weight) = points
            .map(|i| {
                let from_centre_um = half_um * f64::from(i) / 60.0;
                let halves = 2.0 * from_centre_um / fwhm_um;
                (centre_um + from_centre_um, (-2_f64.ln() * halves * halves).exp())
            })
            .unzip();
        Self { wavelength_um, weight }
    }

    /// A response function of two columns, wavelength in um and response from 0 to 1.
    pub fn read(path: &Path) -> Result<Self, SpectrumError> {
        // The numbers are as they stand, whatever the heading calls them.
        let reading = Reading {
            quantity: Some(Quantity::Emissivity),
            is_response: true,
            ..Reading::default()
        };
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
        let span = self.span_um();
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

    /// Least and greatest wavelength, um.
    pub fn span_um(&self) -> [f64; 2] {
        [self.wavelength_um[0], self.wavelength_um[self.wavelength_um.len() - 1]]
    }

    /// The weights with which a curve's values at ascending wavelengths (um) make its mean as the band sees it: exact for
    /// straight lines between them. They hold all of the band.
    pub fn weights(&self, wavelengths_um: &[f64]) -> Vec<f64> {
        let area = self.area();
        (0..wavelengths_um.len())
            .map(|i| {
                let at = wavelengths_um[i];
                // The curve that is 1 here and 0 at all others.
                let slope = |to: Option<&f64>, um: f64| {
                    to.map_or(0.0, |to| ((um - to) / (at - to)).clamp(0.0, 1.0))
                };
                let (below, above) = (i.checked_sub(1), wavelengths_um.get(i + 1));
                let below = below.map(|below| &wavelengths_um[below]);
                let hat = |um: f64| {
                    if um == at { 1.0 } else { slope(if um < at { below } else { above }, um) }
                };
                let reach = (*below.unwrap_or(&at), *above.unwrap_or(&at));
                self.integral_within(reach, &[at], |um| Ok(hat(um))).expect("no error in it") / area
            })
            .collect()
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
        let [from_um, to_um] = self.span_um();
        self.integral_within((from_um, to_um), further_um, of)
    }

    /// The same over a part of the wavelengths.
    fn integral_within(
        &self,
        (from_um, to_um): (f64, f64),
        further_um: &[f64],
        of: impl Fn(f64) -> Result<f64, SpectrumError>,
    ) -> Result<f64, SpectrumError> {
        let [first_um, last_um] = self.span_um();
        let span = from_um.max(first_um)..=to_um.min(last_um);
        let ends = [*span.start(), *span.end()];
        let further = self.wavelength_um.iter().chain(further_um).chain(&ends);
        let mut nodes: Vec<f64> = further.copied().filter(|um| span.contains(um)).collect();
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
