//! Radiance of the sky from a file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::columns::{covers, on_line};
use super::{Columns, RadiometryError};

/// Radiance of the sky by wavelength, and by zenith angle where it depends on it; with straight lines between the
/// points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkyTable {
    /// The file that it comes from.
    pub file: String,
    /// Wavelengths, um, ascending, at least two.
    pub wavelength_um: Vec<f64>,
    /// Zenith angles, degrees, ascending from 0 to 90; one alone, 0, of an isotropic sky.
    pub zenith_deg: Vec<f64>,
    /// Radiance at each zenith angle and, within, each wavelength, W m-2 sr-1 um-1, 0 or more.
    pub l_sky: Vec<Vec<f64>>,
}

impl SkyTable {
    /// Reads a CSV file with the columns `wavelength_um`, `l_downwelling_w_m2_sr_um` and, of a sky that depends on
    /// it, `zenith_deg`: then each zenith angle has a row for each wavelength.
    pub fn read(path: &Path) -> Result<Self, RadiometryError> {
        let columns = Columns::read(path)?;
        let l = columns.needed_radiance("l_downwelling")?;
        let file = columns.file();
        let Some(zenith) = columns.column("zenith_deg")? else {
            let (wavelength_um, rows) = columns.ascending_um()?;
            columns.two_at_least(&wavelength_um)?;
            let l_sky = vec![rows.iter().map(|&row| l[row]).collect()];
            return Ok(Self { file, wavelength_um, zenith_deg: vec![0.0], l_sky });
        };
        let um = columns.wavelength_um()?;
        let [wavelength_um, zenith_deg] = [&um, &zenith].map(|column| {
            let mut values = column.clone();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        });
        if zenith_deg[0] != 0.0 || zenith_deg[zenith_deg.len() - 1] != 90.0 {
            let [first, last] = [zenith_deg[0], zenith_deg[zenith_deg.len() - 1]];
            return Err(columns.wrong_file(format!(
                "zenith_deg goes from {first} to {last}, and 0 to 90 is wanted"
            )));
        }
        columns.two_at_least(&wavelength_um)?;
        let mut l_sky = vec![vec![f64::NAN; wavelength_um.len()]; zenith_deg.len()];
        let place = |values: &[f64], value: f64| values.partition_point(|&v| v < value);
        for row in 0..um.len() {
            let at = &mut l_sky[place(&zenith_deg, zenith[row])][place(&wavelength_um, um[row])];
            if !at.is_nan() {
                let problem = format!("{} um at {} degrees stands twice", um[row], zenith[row]);
                return Err(columns.wrong(row, problem));
            }
            *at = l[row];
        }
        for (values, zenith) in l_sky.iter().zip(&zenith_deg) {
            if let Some(gap) = values.iter().position(|l| l.is_nan()) {
                let um = wavelength_um[gap];
                let problem = format!("there is no row for {um} um at {zenith} degrees");
                return Err(columns.wrong_file(problem));
            }
        }
        Ok(Self { file, wavelength_um, zenith_deg, l_sky })
    }

    /// Whether its radiance depends on the zenith angle.
    pub fn is_by_zenith(&self) -> bool {
        self.zenith_deg.len() > 1
    }

    /// Radiance at a wavelength in um and a zenith angle from 0 to 90 degrees; an error outside the range held.
    pub fn l_sky(&self, wavelength_um: f64, zenith_deg: f64) -> Result<f64, RadiometryError> {
        self.covers([wavelength_um; 2])?;
        let of = |l: &Vec<f64>| on_line(&self.wavelength_um, l, wavelength_um);
        if !self.is_by_zenith() {
            return Ok(of(&self.l_sky[0]));
        }
        let above = self.zenith_deg.partition_point(|&z| z < zenith_deg);
        let above = above.clamp(1, self.zenith_deg.len() - 1);
        let ends = [above - 1, above];
        Ok(on_line(
            &ends.map(|i| self.zenith_deg[i]),
            &ends.map(|i| of(&self.l_sky[i])),
            zenith_deg,
        ))
    }

    /// Whether it holds all wavelengths from one to another, um.
    pub fn covers(&self, wanted_um: [f64; 2]) -> Result<(), RadiometryError> {
        covers(&self.file, &self.wavelength_um, wanted_um)
    }

    /// Whether it is one: a table may have been written by other hands.
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
            && self.l_sky.iter().flatten().all(|l| l.is_finite() && *l >= 0.0)
    }
}
