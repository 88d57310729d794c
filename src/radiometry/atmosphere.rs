//! The atmosphere between target and sensor.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::columns::BRIGHTEST;
use super::{Columns, RadiometryError};
use crate::support::linear::{OutOfRange, ends, interpolate, rounded_within};

/// Transmittance and path radiance between target and sensor, linear between the points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Atmosphere {
    /// Name of its file.
    pub file: String,
    /// Wavelengths, um, ascending, at least two.
    pub wavelength_um: Vec<f64>,
    /// Transmittance, 0 to 1.
    pub transmittance: Vec<f64>,
    /// Path radiance, W m-2 sr-1 um-1, 0 or more.
    pub l_path: Vec<f64>,
}

impl Atmosphere {
    /// Reads a CSV file with the columns `wavelength_um`, `transmittance` and
    /// `l_path_w_m2_sr_um`, or the output of MODTRAN or libRadtran.
    pub fn read(path: &Path) -> Result<Self, RadiometryError> {
        let columns = Columns::read(path)?;
        let (wavelength_um, rows) = columns.ascending_um()?;
        columns.two_at_least(&wavelength_um)?;
        let mut transmittance = columns.needed("transmittance")?;
        for tau in &mut transmittance {
            *tau = rounded_within(*tau, [0.0, 1.0]);
        }
        let l_path = columns.needed_radiance("l_path")?;
        if let Some(row) = transmittance.iter().position(|tau| !(0.0..=1.0).contains(tau)) {
            let problem = format!("a transmittance of {} is not within 0 to 1", transmittance[row]);
            return Err(columns.wrong(row, problem));
        }
        Ok(Self {
            file: columns.file(),
            wavelength_um,
            transmittance: rows.iter().map(|&row| transmittance[row]).collect(),
            l_path: rows.iter().map(|&row| l_path[row]).collect(),
        })
    }

    /// Transmittance and path radiance at a wavelength, um.
    ///
    /// # Errors
    /// A wavelength outside the range.
    pub fn at(&self, wavelength_um: f64) -> Result<(f64, f64), RadiometryError> {
        self.covers([wavelength_um; 2])?;
        let of = |y| interpolate(&self.wavelength_um, y, wavelength_um);
        Ok((of(&self.transmittance), of(&self.l_path)))
    }

    /// An error unless it holds all wavelengths from one to another, um.
    pub fn covers(&self, needed_um: [f64; 2]) -> Result<(), RadiometryError> {
        Ok(OutOfRange::check(|| self.file.clone(), needed_um, ends(&self.wavelength_um))?)
    }

    /// Whether it is valid: its table may be of another origin.
    pub(crate) fn is_sound(&self) -> bool {
        let points = self.wavelength_um.len();
        points >= 2
            && self.wavelength_um.is_sorted_by(|a, b| a < b)
            && [self.transmittance.len(), self.l_path.len()] == [points; 2]
            && self.transmittance.iter().all(|tau| (0.0..=1.0).contains(tau))
            && self.l_path.iter().all(|l| (0.0..=BRIGHTEST).contains(l))
    }
}
