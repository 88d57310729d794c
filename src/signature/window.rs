//! The mean emissivity over a window of wavelengths, with its total uncertainty.
//!
//! Bands err together. So beds and cells are compared by their own means over the window; the noise
//! of the rays and the bounds are averaged over the bands, as if fully correlated.

use std::ops::RangeInclusive;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Band;
use super::budget::{Budget, Chance, Share};
use super::cells::{self, Cells, OfCells};
use crate::histogram::{Histogram, Mean};
use crate::scene::Origin;
use crate::signature::Levels;
use crate::spectrum::features::{RESTSTRAHLEN_WINDOW_UM, TRANSPARENCY_WINDOW_UM, window_mean};
use crate::support::error::Error;
use crate::support::math;
use crate::support::statistics::{T_95, quantile_95};
use crate::table::Table;

/// The mean emissivity over a window. Every uncertainty is a half-width in emissivity at 95 %, or a
/// bound.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Window {
    /// Shortest wavelength, um.
    pub from_um: f64,
    /// Longest wavelength, um.
    pub to_um: f64,
    /// Mean emissivity.
    pub emissivity: f64,
    /// The interval of packings and rays together, and the bounds `rim`, `floor`, `given_up` and
    /// `apart`.
    pub half_width_95: f64,
    /// Noise of the rays.
    pub rays: f64,
    /// Differences between packings; `None` where the geometry is given.
    pub packings: Option<f64>,
    /// Standard deviation between packings, without the noise of the rays.
    pub packings_spread: Option<f64>,
    /// Difference between the inner cells and all: the part beyond one standard error, of five beds
    /// or more beyond the 95 % interval.
    pub rim: Option<f64>,
    /// Change by a black or a white floor.
    pub floor: f64,
    /// What given-up paths leave open, and what opaque `auto` facets let through.
    pub given_up: f64,
    /// What hulls that keep fines apart may change; `None` where fines touch, or pairs tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub apart: Option<f64>,
}

impl Window {
    /// The windows of 8 to 9.5 um and 10 to 12 um that the bands cover, else one over all bands.
    pub fn all(packings: &[Table], bands: &[Band], budget: &Budget) -> Result<Vec<Self>, Error> {
        let um: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
        let rho = packings[0].reflectances(&um)?;
        let curves = super::curves(packings, &um)?;
        let levels = Levels::of(packings);
        let cells = weights_of_cells(packings, &levels, &rho);
        let whole = um[0]..=um[um.len() - 1];
        let beds = Beds { levels: &levels, curves: &curves, cells: cells.as_deref() };
        let of = |window| Self::over(window, &um, beds, &budget.bands);
        let found: Vec<Self> =
            [RESTSTRAHLEN_WINDOW_UM, TRANSPARENCY_WINDOW_UM].into_iter().filter_map(of).collect();
        Ok(if found.is_empty() { of(whole).into_iter().collect() } else { found })
    }

    /// One window, from the emissivity of each bed in each band and the weight of its cells there;
    /// `None` where the bands do not cover it.
    fn over(
        window_um: RangeInclusive<f64>,
        um: &[f64],
        beds: Beds,
        shares: &[Share],
    ) -> Option<Self> {
        let whole = um[0]..=um[um.len() - 1];
        let mean = |values: &dyn Fn(usize) -> f64| {
            let values: Vec<f64> = (0..um.len()).map(values).collect();
            // A few bands are no curve.
            let plain = || values.iter().sum::<f64>() / values.len() as f64;
            window_mean(um, &values, &window_um).or_else(|| (window_um == whole).then(plain))
        };
        Self::of([*window_um.start(), *window_um.end()], [&mean, &mean], beds, shares)
    }

    /// A mean over bands. The second is that of half-widths: its weights are those of the first without
    /// their signs. `None` where bands are missing.
    pub(super) fn of(
        [from_um, to_um]: [f64; 2],
        [mean, mean_of_widths]: [OverBands; 2],
        Beds { levels, curves, cells }: Beds,
        shares: &[Share],
    ) -> Option<Self> {
        let rays = mean_of_widths(&|band| shares[band].rays)?;
        let floor = mean_of_widths(&|band| shares[band].floor)?;
        let given_up = mean_of_widths(&|band| shares[band].given_up)?;
        let apart = match shares[0].apart {
            Some(_) => Some(mean_of_widths(&|band| shares[band].apart.unwrap_or(0.0))?),
            None => None,
        };
        // The noise of each bed's rays, all alike.
        let squares: f64 = levels.weights().iter().map(|weight| weight * weight).sum();
        let of_rays = rays / T_95 / squares.sqrt();
        let of_bed = |curve: &Vec<f64>| {
            Some(Mean { mean: mean(&|band| curve[band])?, standard_error: of_rays, trapped: 0.0 })
        };
        let means = curves.iter().map(of_bed).collect::<Option<Vec<_>>>()?;
        let beds = levels.estimate(&means);
        let of_cells = |bed: &Vec<Cells>| {
            let mut means = Cells::default();
            for (cell, of_cell) in means.iter_mut().enumerate() {
                *of_cell = mean(&|band| bed[band][cell])?;
            }
            Some(means)
        };
        let cells: Option<Vec<Cells>> = cells.and_then(|beds| beds.iter().map(of_cells).collect());
        let cells = cells.map(|cells| OfCells::new(&cells));
        let values: Vec<f64> = means.iter().map(|mean| mean.mean).collect();
        let spread = cells.map(|cells| cells.spread);
        let by_spread = levels.half_width(&values, beds.rays_standard_error, spread);
        let by_cells = cells.and_then(|cells| cells.half_width());
        let chance = Chance::new(rays, by_spread, by_cells);
        let spread =
            if by_spread >= by_cells { beds.spread } else { cells.map(|cells| cells.spread) };
        let rim = cells.map(|cells| cells.rim);
        let of_rays = rays / T_95 * (levels.drops() as f64).sqrt();
        let without_rays = |sd: f64| (sd * sd - of_rays * of_rays).max(0.0).sqrt();
        let bounds = rim.unwrap_or(0.0) + floor + given_up + apart.unwrap_or(0.0);
        Some(Self {
            from_um,
            to_um,
            emissivity: beds.mean,
            half_width_95: chance.both + bounds,
            rays,
            packings: chance.packings,
            packings_spread: spread.map(without_rays),
            rim,
            floor,
            given_up,
            apart,
        })
    }

    /// The half-width that this number of packings would have, by the spread between them, with
    /// rays of this half-width.
    pub fn with_packings(&self, packings: usize, rays: f64) -> Option<f64> {
        let of_mean = self.packings_spread? / (packings as f64).sqrt();
        Some(self.with(quantile_95(packings) * of_mean, rays))
    }

    /// The half-width with other half-widths of packings and rays, and the same bounds.
    pub fn with(&self, packings: f64, rays: f64) -> f64 {
        let bounds = [self.rim, Some(self.floor), Some(self.given_up), self.apart];
        math::hypot(packings, rays) + bounds.into_iter().flatten().sum::<f64>()
    }
}

/// The weight of each cell of each drop in each band; `None` where cells do not tell how beds differ.
pub(super) fn weights_of_cells(
    packings: &[Table],
    levels: &Levels,
    rho: &[Vec<f64>],
) -> Option<Vec<Vec<Cells>>> {
    let beds = (Table::origin_of(packings) != Origin::Given)
        .then(|| cells::of_tables(packings, levels))
        .flatten()?;
    let of_bed = |cells: &&Histogram| rho.iter().map(|rho| cells.weight_of_groups(rho)).collect();
    Some(beds.par_iter().map(of_bed).collect())
}

/// A mean over bands, of values by the number of the band; `None` where bands are missing.
pub(super) type OverBands<'a> = &'a dyn Fn(&dyn Fn(usize) -> f64) -> Option<f64>;

/// What is known of each bed in each band.
#[derive(Clone, Copy)]
pub(super) struct Beds<'a> {
    pub(super) levels: &'a Levels,
    /// The emissivity of each table.
    pub(super) curves: &'a [Vec<f64>],
    /// The weight of the cells of each drop.
    pub(super) cells: Option<&'a [Vec<Cells>]>,
}

#[cfg(test)]
mod tests {
    use super::*;

    const UM: [f64; 3] = [8.0, 9.0, 10.0];

    fn shares(rays: f64) -> Vec<Share> {
        let of = |by: f64| Share { rays, floor: 0.001 * by, given_up: 0.0004, ..Share::default() };
        [1.0, 2.0, 3.0].map(of).into()
    }

    fn over(curves: &[Vec<f64>], cells: Option<&[Vec<Cells>]>, rays: f64) -> Window {
        let beds = Beds { levels: &Levels::of_pairs(0, curves.len()), curves, cells };
        Window::over(8.0..=10.0, &UM, beds, &shares(rays)).expect("it is covered")
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-6, "{a} and {b}");
    }

    /// The trapezia of three equal steps weigh the bands by 1/4, 1/2 and 1/4.
    #[test]
    fn a_given_geometry_has_the_noise_of_its_rays_and_the_bounds() {
        let window = over(&[vec![0.8, 0.9, 0.6]], None, 0.01);
        close(window.emissivity, 0.8);
        close(window.floor, 0.002);
        close(window.half_width_95, 0.01 + 0.002 + 0.0004);
        assert_eq!((window.packings, window.rim, window.packings_spread), (None, None, None));
    }

    #[test]
    fn beds_are_compared_by_their_means_over_the_window() {
        // Means of .8 and .82: a standard error of .01, and Student's t is 12.7.
        let curves = [vec![0.8, 0.9, 0.6], vec![0.9, 0.8, 0.78]];
        let window = over(&curves, None, 0.01);
        close(window.emissivity, 0.81);
        close(window.half_width_95, 12.706_205 * 0.01 + 0.0024);
        let rays = 0.01 / T_95;
        close(window.packings_spread.expect("two beds"), (2.0 * (1e-4 - rays * rays)).sqrt());
        // Bands that differ in opposite directions leave the mean as it is: only the rays remain.
        let opposite = over(&[vec![0.8, 0.7, 0.8], vec![0.7, 0.8, 0.7]], None, 0.01);
        close(opposite.half_width_95, 12.706_205 * rays + 0.0024);
    }

    #[test]
    fn cells_give_the_interval_of_a_single_bed() {
        // Four inner cells of .5 within twelve of .25: a variance of .0125.
        let inner = |i: usize| (1..3).contains(&(i % 4)) && (1..3).contains(&(i / 4));
        let cells: Cells = std::array::from_fn(|i| if inner(i) { 0.5 } else { 0.25 });
        let window = over(&[vec![0.6875; 3]], Some(&[vec![cells; 3]]), 0.01);
        let spread = (0.0125_f64 / 16.0).sqrt();
        let rim = 0.1875 - 0.75 * (0.0125_f64 / 3.0).sqrt();
        close(window.rim.expect("cells"), rim);
        close(window.half_width_95, 2.131_45 * spread + rim + 0.0024);
        let alone = window.packings_spread.expect("cells");
        close(alone, (spread * spread - (0.01 / T_95).powi(2)).sqrt());
        // Four such beds: Student's t of three degrees of freedom.
        let chance = (3.182_446 * alone / 2.0).hypot(0.005);
        close(window.with_packings(4, 0.005).expect("a spread"), chance + rim + 0.0024);
    }

    #[test]
    fn a_window_beyond_the_bands_is_left_out_and_few_bands_have_a_plain_mean() {
        let levels = Levels::of_pairs(0, 1);
        let alone = |curves| Beds { levels: &levels, curves, cells: None };
        let curve = [vec![0.8, 0.9, 0.6]];
        assert_eq!(Window::over(10.0..=12.0, &UM, alone(&curve), &shares(0.01)), None);
        let one = Window::over(9.0..=9.0, &[9.0], alone(&[vec![0.9]]), &shares(0.01)[..1]);
        close(one.expect("all bands").emissivity, 0.9);
    }
}
