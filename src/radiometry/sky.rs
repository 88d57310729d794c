//! Radiance of the sky from a file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::columns::BRIGHTEST;
use super::{Columns, RadiometryError};
use crate::support::linear::{OutOfRange, ends, interpolate, locate};

/// Radiance of the sky by wavelength and, if it depends on it, by zenith angle. It is linear
/// between the points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkyTable {
    /// Name of its file.
    pub file: String,
    /// Wavelengths, um, ascending, at least two.
    pub wavelength_um: Vec<f64>,
    /// Zenith angles, degrees, ascending from 0 to 90; only 0 for an isotropic sky.
    pub zenith_deg: Vec<f64>,
    /// Radiance by zenith angle and then by wavelength, W m-2 sr-1 um-1, 0 or more.
    pub l_sky: Vec<Vec<f64>>,
}

impl SkyTable {
    /// Reads a CSV file with the columns `wavelength_um` and `l_downwelling_w_m2_sr_um`. A sky that
    /// depends on the zenith angle has a column `zenith_deg` too, with all wavelengths at each
    /// angle.
    pub fn read(path: &Path) -> Result<Self, RadiometryError> {
        let columns = Columns::read(path)?;
        let l = columns.needed_radiance("l_downwelling")?;
        let um = columns.wavelength_um()?;
        let given = columns.column("zenith_deg")?;
        let is_by_zenith = given.is_some();
        let zenith = given.unwrap_or_else(|| vec![0.0; um.len()]);
        let [wavelength_um, zenith_deg] = [&um, &zenith].map(|column| {
            let mut values = column.clone();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        });
        let [first, last] = ends(&zenith_deg);
        if is_by_zenith && [first, last] != [0.0, 90.0] {
            let problem = format!("zenith_deg goes from {first} to {last}, not from 0 to 90");
            return Err(columns.wrong_file(problem));
        }
        columns.two_at_least(&wavelength_um)?;
        let named = |um: f64, zenith: f64| {
            if is_by_zenith { format!("{um} um at {zenith} degrees") } else { format!("{um} um") }
        };
        let mut l_sky = vec![vec![f64::NAN; wavelength_um.len()]; zenith_deg.len()];
        let place = |values: &[f64], value: f64| values.partition_point(|&v| v < value);
        for row in 0..um.len() {
            let at = &mut l_sky[place(&zenith_deg, zenith[row])][place(&wavelength_um, um[row])];
            if !at.is_nan() {
                let problem = format!("{} appears twice", named(um[row], zenith[row]));
                return Err(columns.wrong(row, problem));
            }
            *at = l[row];
        }
        for (values, &zenith) in l_sky.iter().zip(&zenith_deg) {
            if let Some(gap) = values.iter().position(|l| l.is_nan()) {
                let problem = format!("a row for {} is missing", named(wavelength_um[gap], zenith));
                return Err(columns.wrong_file(problem));
            }
        }
        Ok(Self { file: columns.file(), wavelength_um, zenith_deg, l_sky })
    }

    /// Whether its radiance depends on the zenith angle.
    pub fn is_by_zenith(&self) -> bool {
        self.zenith_deg.len() > 1
    }

    /// Radiance at a wavelength, um, and a zenith angle from 0 to 90 degrees.
    ///
    /// # Errors
    /// A wavelength outside the range.
    pub fn l_sky(&self, wavelength_um: f64, zenith_deg: f64) -> Result<f64, RadiometryError> {
        self.covers([wavelength_um; 2])?;
        let at_zenith = |i: usize| interpolate(&self.wavelength_um, &self.l_sky[i], wavelength_um);
        Ok(locate(&self.zenith_deg, |zenith| *zenith, zenith_deg).value(at_zenith))
    }

    /// An error unless it holds all wavelengths from one to another, um.
    pub fn covers(&self, needed_um: [f64; 2]) -> Result<(), RadiometryError> {
        Ok(OutOfRange::check(|| self.file.clone(), needed_um, ends(&self.wavelength_um))?)
    }

    /// Whether it is valid: its table may be of another origin.
    pub(crate) fn is_sound(&self) -> bool {
        let ascends = |values: &[f64]| values.is_sorted_by(|a, b| a < b);
        let zeniths = match self.zenith_deg[..] {
            [0.0] => true,
            [0.0, .., last] => last == 90.0 && ascends(&self.zenith_deg),
            _ => false,
        };
        zeniths
            && self.wavelength_um.len() >= 2
            && ascends(&self.wavelength_um)
            && self.l_sky.len() == self.zenith_deg.len()
            && self.l_sky.iter().all(|l| l.len() == self.wavelength_um.len())
            && self.l_sky.iter().flatten().all(|l| (0.0..=BRIGHTEST).contains(l))
    }
}
