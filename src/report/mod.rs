//! The report of a result: its numbers, its text, its chart.

#[cfg(feature = "plots")]
mod chart;
pub mod compare;
mod details;
mod limit;
#[cfg(feature = "plots")]
pub mod page;
mod reached;
mod retrieval;
pub mod terminal;
pub mod warnings;

use crate::radiometry::Assumed;
use crate::signature::budget::Budget;
use crate::signature::plan::Plan;
use crate::signature::{Band, Levels, Window, curves, evaluate, not_valid_um};
use crate::spectrum::features::{Features, features};
use crate::support::error::Error;
use crate::support::statistics::{half_width, wanted};
use crate::table::field::FieldSummary;
use crate::table::{Table, cover, feature_windows};

#[cfg(feature = "plots")]
pub use chart::chart;
pub use details::{first_beds, plan};
pub use limit::{Cost, duration};
pub use reached::{FeatureErrors, Reached, ToleranceOf};
pub use retrieval::Retrieval;

/// A result: its bands, their uncertainty, and the numbers for the record.
#[derive(Debug, Clone)]
pub struct Report {
    /// The signature.
    pub bands: Vec<Band>,
    /// Its uncertainty.
    pub budget: Budget,
    /// The numbers for the record.
    pub reached: Reached,
}

impl Report {
    /// Of the tables of a recipe's packings. The tolerance is a half-width of their mean in emissivity.
    ///
    /// # Errors
    /// A spectrum does not cover a wavelength.
    pub fn new(
        packings: &[Table],
        wavelengths_um: &[f64],
        (tolerance, tolerance_of): (f64, ToleranceOf),
        plan: Option<Plan>,
    ) -> Result<Self, Error> {
        let bands = evaluate(packings, wavelengths_um)?;
        let budget = Budget::new(packings, &bands)?;
        let windows = Window::all(packings, &bands, &budget)?;
        let paths: u64 = packings.iter().map(|table| table.paths).sum();
        let met: u64 = packings.iter().map(Table::met).sum();
        let share =
            |count: &dyn Fn(&Table) -> f64| packings.iter().map(count).sum::<f64>() / paths as f64;
        let emissivity: Vec<f64> = bands.iter().map(|band| band.emissivity.mean).collect();
        let widest = bands
            .iter()
            .max_by(|a, b| a.emissivity.half_width.total_cmp(&b.emissivity.half_width))
            .expect("there is at least one band");
        let e = widest.emissivity;
        let rays_reached = packings.iter().all(|table| table.stop.reached.tolerance);
        let (half_width, at_um) = match tolerance_of {
            ToleranceOf::Interval | ToleranceOf::Rays => (e.half_width, widest.wavelength_um),
            ToleranceOf::Total => (budget.widest().total, budget.widest().wavelength_um),
        };
        let is_reached = match tolerance_of {
            ToleranceOf::Rays => rays_reached,
            _ => half_width <= tolerance && (packings.len() > 1 || rays_reached),
        };
        let of_materials = packings[0].materials.iter();
        let seen_first = of_materials.clone().enumerate().map(|(i, material)| {
            let hits: u64 = packings.iter().map(|table| table.materials[i].first_hits).sum();
            (material.name.clone(), hits as f64 / met as f64)
        });
        let reached = Reached {
            windows,
            packings: Levels::of(packings).drops(),
            plan,
            half_width,
            widest_at_um: at_um,
            spread: e.spread,
            rays_share: if e.standard_error > 0.0 {
                (e.rays_standard_error / e.standard_error).powi(2)
            } else {
                1.0
            },
            trapped_half_width: e.trapped,
            packings_wanted: e.spread.and_then(|spread| wanted(spread, tolerance - e.trapped)),
            tolerance,
            tolerance_of,
            tolerance_reached: is_reached,
            paths,
            facets: of_materials.map(|m| (m.name.clone(), m.spectrum.facets())).collect(),
            not_valid_um: not_valid_um(&bands),
            seen_first: seen_first.collect(),
            coverage: cover::mean(&packings.iter().map(|t| &t.coverage).collect::<Vec<_>>()),
            missed: share(&|table| table.missed as f64),
            escaped_downward: share(&|table| {
                table.escaped_downward as f64 / table.histogram.parts as f64
            }),
            trapped: share(&|table| table.histogram.paths_given_up()),
            kept: packings[0].histogram.kept,
            ended_by: packings[0].stop.reached.reason,
            inside: share(&|table| table.inside.iter().map(|inside| inside.paths as f64).sum()),
            field: FieldSummary::mean(packings),
            budget: budget.widest(),
            spectra_unknown: budget.spectra_unknown.clone(),
            floor_effect: budget.floor_effect,
            warnings: warnings::of_result(packings, &bands, tolerance, budget.floor_effect),
            retrieval: Retrieval::new(&packings[0], &bands, Assumed::EXACT),
            soil: None,
            refused: Vec::new(),
            features: features(wavelengths_um, &emissivity, feature_windows(packings)),
            features_half_width: feature_errors(packings, wavelengths_um)?,
        };
        Ok(Self { bands, budget, reached })
    }
}

/// The spread of the features of each packing alone; `None` for a single packing.
fn feature_errors(packings: &[Table], um: &[f64]) -> Result<Option<FeatureErrors>, Error> {
    let levels = Levels::of(packings);
    if levels.drops() < 2 {
        return Ok(None);
    }
    // How drops differ; what touching fines change differs far less.
    let curves = curves(packings, um)?;
    let windows = feature_windows(packings);
    let of_each: Vec<Features> =
        levels.first(&curves).map(|curve| features(um, curve, windows)).collect();
    let error = |of: &dyn Fn(&Features) -> Option<f64>| {
        half_width(&of_each.iter().map(of).collect::<Option<Vec<f64>>>()?)
    };
    Ok(Some(FeatureErrors {
        reststrahlen_contrast: error(&|f| f.reststrahlen.map(|doublet| doublet.contrast)),
        mean_8_to_9p5_um: error(&|f| f.mean_8_to_9p5_um),
        mean_10_to_12_um: error(&|f| f.mean_10_to_12_um),
    }))
}
