//! Where a result's uncertainty comes from, band by band, each part measured on the very beds of the result.
//!
//! What is drawn at random, rays and packings, makes an interval. What leaves a thing open, the floor and paths given up,
//! is a bound, and so is of the rim what is beyond its standard error: bounds are added to the interval. What hulls that
//! keep fines apart, the number and the spectra of facets, and straight lines between bands bring is told beside: no bed makes
//! these smaller.

use std::fmt::Write as _;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::cells::OfCells;
use crate::histogram::Histogram;
use crate::scene::{Collision, Packing};
use crate::signature::{self, Band};
use crate::spectrum::Spectrum;
use crate::support::error::Error;
use crate::support::statistics::{T_95, quantile_95};
use crate::table::Table;

/// What the emissivity of one band is uncertain by. Every number is a half-width in emissivity: of a 95 % interval where
/// chance is at work, else a bound.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// The band, um.
    pub wavelength_um: f64,
    /// All of the following up to `given_up`: the interval of packings and rays together, and the bounds.
    pub total: f64,
    /// Noise of the rays.
    pub rays: f64,
    /// What packings of the recipe differ by: by their spread, or by that between the cells of their views where it is
    /// more or there is only one. `None` where the geometry is as given, and no draw.
    pub packings: Option<f64>,
    /// What the bed differs by within the ring of the outer cells: of the difference what is more than its standard error.
    pub rim: Option<f64>,
    /// What a black or a white floor would change.
    pub floor: f64,
    /// What paths that were given up leave open.
    pub given_up: f64,
    /// What hulls that keep fines apart may make: [`APART`] of the reflectance, not measured on these beds. `None` where
    /// fines touch, or there are none.
    pub apart: Option<f64>,
    /// What grains of more or fewer facets may make: [`FACETS`] of the reflectance, not measured on these beds. `None` where
    /// the geometry is as given.
    pub facets: Option<f64>,
    /// What straight lines from this band to its neighbours miss half-way.
    pub spectral_step: f64,
    /// What the errors of the facets' spectra make, as far as these are known.
    pub spectra: f64,
}

/// Where the geometry of a result comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// It is as given.
    Given,
    /// Its beds are draws of a recipe.
    Drawn,
    /// The same, and hulls keep the fines of neighbours apart.
    DrawnApart,
}

impl Origin {
    /// Of tables of which nothing else is known: a single one is taken as given.
    pub fn of_tables(number: usize) -> Self {
        if number > 1 { Self::Drawn } else { Self::Given }
    }

    /// Of beds of a recipe.
    pub fn of(packing: &Packing) -> Self {
        let dusted = packing.grains.iter().any(|class| !class.fines.is_none());
        let hulls = packing.drop.collision == Collision::Hull;
        if dusted && hulls { Self::DrawnApart } else { Self::Drawn }
    }
}

/// Beds dropped as hulls reflect too little by so much of their reflectance, at most: measured on the shipped recipes
/// (docs/geometry.md).
const APART: f64 = 0.03;

/// Beds of grains with one rib fewer, and so three quarters of the facets, reflect less by up to so much of their reflectance;
/// fines of another number of ribs change less (docs/geometry.md).
const FACETS: f64 = 0.02;

/// The budget of a result.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// By band.
    pub bands: Vec<Share>,
    /// Materials whose spectra come without an error.
    pub spectra_unknown: Vec<String>,
    /// Most that any band changes between a black and a white floor: what is left of the tray in the result. `None` where
    /// there is no floor, or where something else is made of its material.
    pub floor_effect: Option<f64>,
}

/// Headings of a budget's CSV file.
const COLUMNS: &str = "wavelength_um,total_half_width_95,rays_half_width_95,packings_half_width_95,rim,floor,given_up,apart,facets,\
                       spectral_step,spectra_half_width_95";

impl Budget {
    /// The budget of a signature.
    pub fn new(packings: &[Table], bands: &[Band], origin: Origin) -> Result<Self, Error> {
        let table = &packings[0];
        let um: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
        let reflectances = table.reflectances(&um)?;
        let steps = steps(packings, &reflectances, &um)?;
        let sources = sources(table);
        let cells: Option<Vec<&Histogram>> = (origin != Origin::Given)
            .then(|| packings.iter().map(|table| table.cells.as_ref()).collect())
            .flatten();
        let share = |((band, rho), step): ((&Band, &Vec<f64>), &f64)| -> Result<_, Error> {
            let e = band.emissivity;
            let rays = T_95 * e.rays_standard_error;
            let of_cells = cells.as_deref().map(|cells| OfCells::new(cells, rho));
            // A few packings may agree by luck: the cells of their views know better. Both hold the noise of the rays.
            let by_spread = e.spread.map(|_| quantile_95(packings.len()) * e.standard_error);
            let by_cells = of_cells.map(|of_cells| of_cells.half_width());
            let drawn = by_spread.is_some() || by_cells.is_some();
            let chance = [by_spread, by_cells].into_iter().flatten().fold(rays, f64::max);
            let packings_alone = drawn.then(|| (chance * chance - rays * rays).max(0.0).sqrt());
            let rim = of_cells.map(|of_cells| of_cells.rim);
            let by_floor = table.floor.map(|floor| floor_changes(packings, floor, rho, e.mean));
            let floor = by_floor.map_or(0.0, |[black, white]| black.abs().max(white.abs()));
            let share = Share {
                wavelength_um: band.wavelength_um,
                total: chance + rim.unwrap_or(0.0) + floor + e.trapped,
                rays,
                packings: packings_alone,
                rim,
                floor,
                given_up: e.trapped,
                apart: (origin == Origin::DrawnApart).then_some(APART * (1.0 - e.mean)),
                facets: (origin != Origin::Given).then_some(FACETS * (1.0 - e.mean)),
                spectral_step: *step,
                spectra: spectra(packings, &sources, band.wavelength_um, rho)?,
            };
            Ok((share, by_floor.map_or(0.0, |[black, white]| black - white)))
        };
        let of_bands: Vec<_> = bands.iter().zip(&reflectances).zip(&steps).collect();
        let unknown = |m: &&crate::table::TableMaterial| !m.spectrum.has_error();
        let (shares, by_floor): (Vec<Share>, Vec<f64>) =
            of_bands.into_par_iter().map(share).collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
        Ok(Self {
            bands: shares,
            floor_effect: table.floor.map(|_| by_floor.into_iter().fold(0.0, f64::max)),
            spectra_unknown: table
                .materials
                .iter()
                .filter(unknown)
                .map(|m| m.name.clone())
                .collect(),
        })
    }

    /// The band whose total is widest.
    ///
    /// # Panics
    /// Without a band.
    pub fn widest(&self) -> Share {
        let widest = self.bands.iter().max_by(|a, b| a.total.total_cmp(&b.total));
        *widest.expect("there is at least one band")
    }

    /// The budget as CSV; what does not apply has empty fields.
    pub fn csv_text(&self) -> String {
        let mut text = COLUMNS.to_owned();
        for share in &self.bands {
            let _ = write!(text, "\n{}", share.wavelength_um);
            for value in [
                Some(share.total),
                Some(share.rays),
                share.packings,
                share.rim,
                Some(share.floor),
                Some(share.given_up),
                share.apart,
                share.facets,
                Some(share.spectral_step),
                Some(share.spectra),
            ] {
                let _ = match value {
                    Some(value) => write!(text, ",{value:.7}"),
                    None => write!(text, ","),
                };
            }
        }
        text + "\n"
    }
}

/// By how much a black and a white floor change the emissivity: what lies deeper than the bed is between them.
fn floor_changes(
    packings: &[Table],
    floor: usize,
    reflectance: &[f64],
    emissivity: f64,
) -> [f64; 2] {
    let cosines = usize::from(packings[0].histogram.kept.cosines);
    [0.0, 1.0].map(|rho| {
        let mut changed = reflectance.to_vec();
        changed[floor * cosines..(floor + 1) * cosines].fill(rho);
        signature::emissivity(packings, &changed).mean - emissivity
    })
}

/// What straight lines between bands miss half-way, the more of both sides.
fn steps(packings: &[Table], reflectances: &[Vec<f64>], um: &[f64]) -> Result<Vec<f64>, Error> {
    let middles: Vec<f64> = um.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect();
    let of = |reflectances: &[Vec<f64>]| -> Vec<f64> {
        reflectances.par_iter().map(|rho| signature::emissivity(packings, rho).mean).collect()
    };
    let (at_bands, between) = (of(reflectances), of(&packings[0].reflectances(&middles)?));
    let missed: Vec<f64> = at_bands
        .windows(2)
        .zip(between)
        .map(|(pair, between)| (between - f64::midpoint(pair[0], pair[1])).abs())
        .collect();
    let at = |i: usize| missed.get(i).copied().unwrap_or(0.0);
    Ok((0..um.len()).map(|i| at(i).max(if i > 0 { at(i - 1) } else { 0.0 })).collect())
}

/// The distinct spectra of a table, each with the materials that have it: their errors go together.
fn sources(table: &Table) -> Vec<(&Spectrum, Vec<usize>)> {
    let mut sources: Vec<(&Spectrum, Vec<usize>)> = Vec::new();
    for (i, material) in table.materials.iter().enumerate() {
        match sources.iter_mut().find(|(spectrum, _)| **spectrum == material.spectrum) {
            Some((_, materials)) => materials.push(i),
            None => sources.push((&material.spectrum, vec![i])),
        }
    }
    sources
}

/// What known errors of spectra make of the emissivity, those of different spectra independent.
fn spectra(
    packings: &[Table],
    sources: &[(&Spectrum, Vec<usize>)],
    um: f64,
    reflectance: &[f64],
) -> Result<f64, Error> {
    let cosines = usize::from(packings[0].histogram.kept.cosines);
    let of = |rho: &[f64]| signature::emissivity(packings, rho).mean;
    let mut squares = 0.0;
    for (spectrum, materials) in sources {
        let error = spectrum.error(um)?.unwrap_or(0.0);
        if error > 0.0 {
            let changed = |by: f64| {
                let mut rho = reflectance.to_vec();
                for &material in materials {
                    for rho in &mut rho[material * cosines..(material + 1) * cosines] {
                        *rho = (*rho + by).clamp(0.0, 1.0);
                    }
                }
                of(&rho)
            };
            squares += ((changed(error) - changed(-error)) / 2.0).powi(2);
        }
    }
    // Normally distributed, for want of a better.
    Ok(1.96 * squares.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::histogram::tally::{CELLS, Kept, PARTS};

    /// A bed whose paths hit so many facets in each cell, of a reflectance that tests put at a half.
    fn cells(hits: impl Fn(u16, u16) -> u16) -> Histogram {
        let of = |n: u16| {
            let its = |cell: &u16| hits(cell % CELLS, cell / CELLS) == n;
            let counts = (0..CELLS * CELLS).filter(its).map(|cell| (cell, 10)).collect();
            ([n].into(), counts)
        };
        Histogram {
            kept: Kept::PLAIN,
            parts: PARTS,
            escaped: vec![of(1), of(2)],
            given_up: Vec::new(),
            rouletted: Vec::new(),
        }
    }

    fn rim_and_middle() -> Histogram {
        cells(|x, y| if (1..3).contains(&x) && (1..3).contains(&y) { 1 } else { 2 })
    }

    /// Four cells of .5 within twelve of .25: their mean is .3125, their variance .0125.
    #[test]
    fn a_rim_is_what_the_inner_cells_differ_by_beyond_chance() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} and {b}");
        let one = OfCells::new(&[&rim_and_middle()], &[0.5]);
        // Student's t of 15 degrees of freedom, of three beds of 45.
        close(one.half_width(), 2.131_45 * (0.0125_f64 / 16.0).sqrt());
        let by_chance = 0.75 * (0.0125_f64 / 3.0).sqrt();
        close(one.rim, 0.1875 - by_chance);

        let bed = rim_and_middle();
        let three = OfCells::new(&[&bed, &bed, &bed], &[0.5]);
        close(three.spread, one.spread);
        close(three.half_width(), 2.014_103 * (0.0125_f64 / 48.0).sqrt());
        close(three.rim, 0.1875 - by_chance / 3.0_f64.sqrt());
    }

    /// Of a chequerboard the inner cells are as all of them.
    #[test]
    fn cells_that_differ_without_a_rim_have_none() {
        let board = OfCells::new(&[&cells(|x, y| 1 + (x + y) % 2)], &[0.5]);
        assert!(board.half_width() > 0.06, "{}", board.half_width());
        assert_eq!(board.rim, 0.0);
        // Beds whose rims differ in sign have none in common.
        let other = cells(|x, y| if (1..3).contains(&x) && (1..3).contains(&y) { 2 } else { 1 });
        assert_eq!(OfCells::new(&[&rim_and_middle(), &other], &[0.5]).rim, 0.0);
    }

    #[test]
    fn what_does_not_apply_is_empty_in_the_file_and_the_widest_band_is_found() {
        let share = Share {
            wavelength_um: 8.63,
            total: 0.25,
            rays: 0.125,
            packings: None,
            rim: None,
            floor: 0.0625,
            given_up: 0.0625,
            apart: None,
            facets: None,
            spectral_step: 0.5,
            spectra: 0.5,
        };
        let wider = Share { total: 0.3, rim: Some(0.05), wavelength_um: 9.0, ..share };
        let bands = vec![share, wider, Share { wavelength_um: 9.5, ..share }];
        let budget = Budget { bands, spectra_unknown: Vec::new(), floor_effect: None };
        assert_eq!(budget.widest(), wider);
        let text = budget.csv_text();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0].split(',').count(), lines[1].split(',').count());
        assert_eq!(
            lines[1],
            "8.63,0.2500000,0.1250000,,,0.0625000,0.0625000,,,0.5000000,0.5000000"
        );
        assert!(lines[2].contains(",0.1250000,,0.0500000,0.0625000,"), "{}", lines[2]);
        assert_eq!(lines.len(), 4);
    }
}
