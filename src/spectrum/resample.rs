//! Spectra at other wavelengths: by point, or as the bands of a sensor see them.

use std::f64::consts::LN_2;
use std::path::Path;

use super::format::{Reading, read_one};
use super::{Quantity, Spectrum, SpectrumError};
use crate::support::file_error::FileError;
use crate::support::linear::{ends, interpolate};
use crate::support::math;

/// Wavelengths that a response may have, um.
const REACH_UM: [f64; 2] = [0.01, 1e4];

/// The response of a band: straight lines between points, 0 outside them.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    wavelength_um: Vec<f64>,
    weight: Vec<f64>,
}

impl Response {
    /// The triangular response of a spectrometer's slit; `width_um` is its full width at half
    /// maximum.
    pub fn triangle(centre_um: f64, width_um: f64) -> Self {
        // Without rounding errors: it may end where a spectrum does.
        let wavelength_um = [centre_um - width_um, centre_um, centre_um + width_um]
            .map(|um| (um * 1e9).round() / 1e9)
            .to_vec();
        Self { wavelength_um, weight: vec![0.0, 1.0, 0.0] }
    }

    /// A constant response from one wavelength to a greater one, um.
    pub fn boxed(from_um: f64, to_um: f64) -> Self {
        Self { wavelength_um: vec![from_um, to_um], weight: vec![1.0, 1.0] }
    }

    /// A Gaussian response, cut where it falls to 1e-4 of its maximum; `fwhm_um` is its full width
    /// at half maximum, above 0.
    pub fn gaussian(centre_um: f64, fwhm_um: f64) -> Self {
        let half_um = fwhm_um / 2.0 * (math::log(1e4) / LN_2).sqrt();
        let (wavelength_um, weight) = (-60..=60)
            .map(|i| {
                let from_centre_um = half_um * f64::from(i) / 60.0;
                let halves = 2.0 * from_centre_um / fwhm_um;
                (centre_um + from_centre_um, math::exp(-LN_2 * halves * halves))
            })
            .unzip();
        Self { wavelength_um, weight }
    }

    /// A response by points of ascending wavelength, um, cut to where it is above 0; `None` if it is
    /// nowhere.
    pub(crate) fn of_points(points: &[(f64, f64)]) -> Option<Self> {
        let first = points.iter().position(|(_, weight)| *weight > 0.0)?.saturating_sub(1);
        let last = points.iter().rposition(|(_, weight)| *weight > 0.0)? + 1;
        let points = &points[first..=last.min(points.len() - 1)];
        let (wavelength_um, weight) = points.iter().copied().unzip();
        Some(Self { wavelength_um, weight })
    }

    /// Reads a response of two columns: wavelength, um, and response, 0 to 1.
    pub fn read(path: &Path) -> Result<Self, SpectrumError> {
        // The numbers are not converted, whatever the heading says.
        let reading = Reading {
            quantity: Some(Quantity::Emissivity),
            is_response: true,
            ..Reading::default()
        };
        let points = read_one(path, &reading)?;
        if points.emissivity.iter().all(|&weight| weight == 0.0) {
            return Err(FileError::wrong(path, "the response is 0 at every wavelength")
                .with_hint("use a response with a maximum of 1")
                .into());
        }
        let [from, to] = points.range_um();
        if from < REACH_UM[0] || to > REACH_UM[1] {
            let [least, most] = REACH_UM;
            let problem =
                format!("the response reaches from {from} to {to} um, beyond {least} to {most} um");
            return Err(FileError::wrong(path, problem)
                .with_hint("use wavelengths in um, or name their unit in the heading")
                .into());
        }
        Ok(Self { wavelength_um: points.wavelength_um, weight: points.emissivity })
    }

    /// Full width at half maximum, um: between the first and the last wavelength of that response.
    pub fn width_um(&self) -> f64 {
        let half = self.weight.iter().copied().fold(0.0, f64::max) / 2.0;
        let points = || self.wavelength_um.iter().copied().zip(self.weight.iter().copied());
        let crossing =
            |(x0, y0): (f64, f64), (x1, y1): (f64, f64)| x0 + (x1 - x0) * (half - y0) / (y1 - y0);
        let all: Vec<(f64, f64)> = points().collect();
        let Some(first) = all.iter().position(|(_, y)| *y >= half) else { return 0.0 };
        let last = all.iter().rposition(|(_, y)| *y >= half).unwrap_or(first);
        let from = if first == 0 { all[0].0 } else { crossing(all[first - 1], all[first]) };
        let to =
            if last + 1 == all.len() { all[last].0 } else { crossing(all[last + 1], all[last]) };
        to - from
    }

    /// Centroid, um.
    pub fn centre_um(&self) -> f64 {
        self.integral(self.span_um(), &[], |um| um) / self.area()
    }

    /// Emissivity of a spectrum as the band sees it: the mean weighted by the response, exact for
    /// tabulated spectra.
    ///
    /// # Errors
    /// A spectrum that does not hold all of the band.
    pub fn band_mean(&self, spectrum: &Spectrum) -> Result<f64, SpectrumError> {
        let span = self.span_um();
        spectrum.covers(span)?;
        let steps: Vec<f64> = if let Spectrum::Tabulated(points) = spectrum {
            points.wavelength_um.clone()
        } else if spectrum.range_um().is_none() {
            // It is the same at every wavelength.
            Vec::new()
        } else {
            // The curves are smooth on a scale of 10 nm.
            let steps = ((span[1] - span[0]) / 1e-3) as u32;
            (1..=steps).map(|i| span[0] + 1e-3 * f64::from(i)).collect()
        };
        Ok(self.try_integral(span, &steps, |um| spectrum.emissivity(um))? / self.area())
    }

    /// Least and greatest wavelength, um.
    pub fn span_um(&self) -> [f64; 2] {
        ends(&self.wavelength_um)
    }

    /// The weights of a curve's values at ascending wavelengths (um) in its mean as the band sees
    /// it: exact for straight lines between them. The wavelengths must hold all of the band.
    pub fn weights(&self, wavelengths_um: &[f64]) -> Vec<f64> {
        let area = self.area();
        (0..wavelengths_um.len())
            .map(|i| {
                // The curve that is 1 here and 0 at all others.
                let last = (i + 1).min(wavelengths_um.len() - 1);
                let near = &wavelengths_um[i.saturating_sub(1)..=last];
                let hat: Vec<f64> =
                    near.iter().map(|&um| f64::from(um == wavelengths_um[i])).collect();
                self.integral(ends(near), near, |um| interpolate(near, &hat, um)) / area
            })
            .collect()
    }

    fn area(&self) -> f64 {
        self.integral(self.span_um(), &[], |_| 1.0)
    }

    fn integral(&self, range_um: [f64; 2], further_um: &[f64], of: impl Fn(f64) -> f64) -> f64 {
        self.try_integral(range_um, further_um, |um| Ok(of(um))).expect("`of` cannot fail")
    }

    /// Integral of the response times `of` over a range of wavelengths, by Simpson's rule between
    /// the points of both: exact if both are linear there.
    fn try_integral(
        &self,
        [from_um, to_um]: [f64; 2],
        further_um: &[f64],
        of: impl Fn(f64) -> Result<f64, SpectrumError>,
    ) -> Result<f64, SpectrumError> {
        let [first_um, last_um] = self.span_um();
        let range = from_um.max(first_um)..=to_um.min(last_um);
        let ends = [*range.start(), *range.end()];
        let nodes = self.wavelength_um.iter().chain(further_um).chain(&ends);
        let mut nodes: Vec<f64> = nodes.copied().filter(|um| range.contains(um)).collect();
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        let weighted =
            |um| of(um).map(|value| value * interpolate(&self.wavelength_um, &self.weight, um));
        nodes.windows(2).try_fold(0.0, |sum, ends| {
            let middle = f64::midpoint(ends[0], ends[1]);
            let mean = (weighted(ends[0])? + 4.0 * weighted(middle)? + weighted(ends[1])?) / 6.0;
            Ok(sum + mean * (ends[1] - ends[0]))
        })
    }
}

/// The error of straight lines between the points of a resampled spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResamplingError {
    /// Root mean square, over the points of the spectrum and the midpoints of the new ones.
    pub rms: f64,
    /// The largest error, with its sign.
    pub largest: f64,
    /// Its wavelength, um.
    pub at_um: f64,
}

/// Compares points at ascending wavelengths (um, at least two) with their spectrum.
pub fn resampling_error(
    spectrum: &Spectrum,
    wavelength_um: &[f64],
    emissivity: &[f64],
) -> Result<ResamplingError, SpectrumError> {
    let [from, to] = ends(wavelength_um);
    let mut at: Vec<f64> = wavelength_um.windows(2).map(|w| f64::midpoint(w[0], w[1])).collect();
    at.extend(wavelength_um);
    if let Spectrum::Tabulated(points) = spectrum {
        at.extend(points.wavelength_um.iter().filter(|um| (from..=to).contains(*um)));
    }
    let mut found = ResamplingError { rms: 0.0, largest: 0.0, at_um: from };
    for &um in &at {
        let error = interpolate(wavelength_um, emissivity, um) - spectrum.emissivity(um)?;
        found.rms += error * error / at.len() as f64;
        if error.abs() > found.largest.abs() {
            (found.largest, found.at_um) = (error, um);
        }
    }
    found.rms = found.rms.sqrt();
    Ok(found)
}
