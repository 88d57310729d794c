//! What was measured: emissivity, or radiance with its sky and atmosphere.

use std::path::Path;

use crate::products::retrieve::{self, Known, Target};
use crate::radiometry::{Measured, Method, Temperature};
use crate::spectrum::format::{self, Reading};
use crate::support::error::Error;

/// The bands that are fitted.
#[derive(Debug, Clone, PartialEq)]
pub enum Seen {
    /// Emissivity.
    Emissivity {
        /// Wavelengths, um.
        um: Vec<f64>,
        /// Emissivity of each band.
        bands: Vec<f64>,
        /// Standard errors, if the file has any.
        errors: Option<Vec<f64>>,
    },
    /// Radiance.
    Radiance {
        /// Radiance and sky in each band.
        measured: Vec<Measured>,
        /// A first temperature of the target.
        first: Temperature,
        /// Relative standard error of the sky's radiance.
        downwelling_error: f64,
    },
}

/// The least distance of fitted bands, um. Quartz has nothing finer, and a discrepancy of the model
/// makes nearer bands tell the same.
pub const STEP_UM: f64 = 0.03;

impl Seen {
    /// Wavelengths of the bands, um.
    pub fn um(&self) -> Vec<f64> {
        match self {
            Self::Emissivity { um, .. } => um.clone(),
            Self::Radiance { measured, .. } => measured.iter().map(|m| m.wavelength_um).collect(),
        }
    }

    /// Reads emissivity within a range, um.
    pub fn emissivity(path: &Path, range_um: [f64; 2]) -> Result<Self, Error> {
        let reading = Reading { range_um: Some(range_um), ..Reading::default() };
        let spectrum = format::read_one(path, &reading)?;
        let places = picked(&spectrum.wavelength_um, range_um);
        let of = |values: &[f64]| -> Vec<f64> { places.iter().map(|&i| values[i]).collect() };
        let (um, bands) = (of(&spectrum.wavelength_um), of(&spectrum.emissivity));
        Ok(Self::Emissivity { um, bands, errors: None })
    }

    /// Reads radiance within a range, um. `known` has the sky, the atmosphere and the target's
    /// temperature; without one it is taken from the Christiansen bands, else from the warmest band.
    pub fn radiance(
        path: &Path,
        error: Option<f64>,
        known: &Known,
        range_um: [f64; 2],
    ) -> Result<Self, Error> {
        let read = match retrieve::spectrum(path, error, known) {
            Err(_) if known.target == Target::By(Method::Christiansen) => {
                // The bands may begin beyond the Christiansen wavelength.
                let warmest = Temperature { k: 300.0, error_k: 0.0 };
                let given = Known { target: Target::Given(warmest), ..known.clone() };
                let mut read = retrieve::spectrum(path, error, &given)?;
                read.temperature = warmest_of(&read.measured);
                read
            }
            read => read?,
        };
        let limit = known.assumed.amplification_limit;
        let first = read.temperature;
        let tells = |m: &&Measured| m.amplification(first.k) <= limit;
        let measured: Vec<Measured> = read.measured.iter().filter(tells).copied().collect();
        let um: Vec<f64> = measured.iter().map(|m| m.wavelength_um).collect();
        let measured = picked(&um, range_um).into_iter().map(|i| measured[i]).collect();
        let downwelling_error = known.assumed.downwelling_error;
        Ok(Self::Radiance { measured, first, downwelling_error })
    }
}

/// The temperature of the warmest band, with an error that a fit can correct.
fn warmest_of(measured: &[Measured]) -> Temperature {
    let kelvin = measured.iter().filter_map(|m| Some(m.brightness_temperature()?.k));
    Temperature { k: kelvin.fold(1.0, f64::max), error_k: 2.0 }
}

/// Places of bands within a range that are at least [`STEP_UM`] apart.
fn picked(um: &[f64], [from, to]: [f64; 2]) -> Vec<usize> {
    let mut picked: Vec<usize> = Vec::new();
    for (i, &at) in um.iter().enumerate().filter(|(_, at)| (from..=to).contains(*at)) {
        if picked.last().is_none_or(|&last| at - um[last] >= STEP_UM - 1e-9) {
            picked.push(i);
        }
    }
    picked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_picked_within_the_range_and_apart() {
        let um: Vec<f64> = (0..1000).map(|i| 7.0 + 0.01 * f64::from(i)).collect();
        let places = picked(&um, [7.5, 8.5]);
        assert_eq!(places.len(), 34);
        assert!(places.windows(2).all(|pair| pair[1] - pair[0] == 3));
        assert_eq!(picked(&[8.0, 9.0, 12.0], [7.5, 10.0]), [0, 1]);
    }
}
