//! The uncertainty of each band's emissivity, part by part, measured on the beds of the result.
//!
//! Rays and packings give an interval. The floor, given-up paths, hulls that keep fines apart and the
//! significant part of the rim are bounds, added to it. Not included: the number and the spectra of
//! facets, and interpolation between bands. No further bed makes these smaller.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::cells::{self, OfCells};
use crate::scene::Origin;
use crate::signature::{self, Band, Levels};
use crate::spectrum::Spectrum;
use crate::support::csv::{Csv, decimals};
use crate::support::error::Error;
use crate::support::statistics::T_95;
use crate::table::{Table, TableMaterial};

/// The uncertainty of one band's emissivity. Every number is a half-width in emissivity: of a 95 %
/// interval for rays, packings and spectra, else a bound.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Share {
    /// The band, um.
    pub wavelength_um: f64,
    /// The interval of packings and rays together, and the bounds `rim`, `floor`, `given_up` and
    /// `apart`.
    pub total: f64,
    /// Noise of the rays.
    pub rays: f64,
    /// Differences between packings of the recipe: by their spread or, for fewer than five, by that
    /// between the cells of their views, whichever is more. Of five or more the cells count as three
    /// further packings. `None` where the geometry is given.
    pub packings: Option<f64>,
    /// Difference between the inner cells and all: the part beyond one standard error, of five beds
    /// or more beyond the 95 % interval.
    pub rim: Option<f64>,
    /// Change by a black or a white floor.
    pub floor: f64,
    /// What given-up paths leave open, and what opaque `auto` facets let through.
    pub given_up: f64,
    /// Effect of hulls that keep fines apart: 3 % of the reflectance, not measured on these
    /// beds. `None` where fines touch, or there are none, or pairs tell it.
    pub apart: Option<f64>,
    /// Effect of more or fewer facets on a grain: 2 % of the reflectance, not measured on
    /// these beds. `None` where the geometry is given.
    pub facets: Option<f64>,
    /// Error of linear interpolation half-way to the next band, or between the nodes of refractive
    /// facets.
    pub spectral_step: f64,
    /// Effect of the errors of the facets' spectra, as far as these are known.
    pub spectra: f64,
}

/// Beds dropped as hulls reflect less by at most this share of their reflectance: measured on the
/// shipped recipes (docs/measurements/packings.md).
const APART: f64 = 0.03;

/// Beds of grains with one rib fewer, three quarters of the facets, reflect less by up to this
/// share of their reflectance (docs/measurements/facets.md).
const FACETS: f64 = 0.02;

/// The budget of a result.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Budget {
    /// The uncertainty of each band.
    pub bands: Vec<Share>,
    /// Materials whose spectra have an error that is not, or not wholly, known.
    pub spectra_unknown: Vec<String>,
    /// Largest change of any band between a black and a white floor. `None` where there is no
    /// floor, or where something else is made of its material.
    pub floor_effect: Option<f64>,
    /// Standard deviation between beds by the cells of their views, by band, where cells tell it.
    pub(super) by_cells: Option<Vec<f64>>,
}

/// The columns of `budget.csv`, with their meanings. All numbers are half-widths in emissivity.
pub(crate) const COLUMNS: [(&str, &str); 11] = [
    ("wavelength_um", "Wavelength of the band."),
    (
        "total_half_width_95",
        "All parts up to apart: the 95 % interval of rays and beds together, plus the bounds.",
    ),
    ("rays_half_width_95", "Noise of the rays."),
    (
        "packings_half_width_95",
        "Differences between beds of the recipe; empty where the geometry is given.",
    ),
    ("rim", "What the outer ring of the view changes beyond chance."),
    ("floor", "What a black or a white floor would change."),
    ("given_up", "What paths given up leave open, and what opaque auto facets let through."),
    (
        "apart",
        "What hulls that keep fines apart may change; empty where fines touch, or pairs tell it.",
    ),
    (
        "facets",
        "What more or fewer facets of grains may change; empty where the geometry is given.",
    ),
    ("spectral_step", "What straight lines between bands, or between nodes, miss."),
    ("spectra_half_width_95", "Known errors of the facets' spectra."),
];

/// A part of a band's uncertainty.
type Part = fn(&Share) -> Option<f64>;

/// The columns beyond the wavelength.
const PARTS: [Part; 10] = [
    |share| Some(share.total),
    |share| Some(share.rays),
    |share| share.packings,
    |share| share.rim,
    |share| Some(share.floor),
    |share| Some(share.given_up),
    |share| share.apart,
    |share| share.facets,
    |share| Some(share.spectral_step),
    |share| Some(share.spectra),
];

/// The 95 % interval of rays and packings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chance {
    /// Half-width of both together.
    pub(super) both: f64,
    /// Half-width without the rays; `None` where the geometry is given.
    pub(super) packings: Option<f64>,
}

impl Chance {
    /// From the half-width of the rays, and those by the spread between beds and between cells,
    /// which hold the noise of the rays. A few beds may agree by luck, so the wider one counts.
    pub(super) fn new(rays: f64, by_spread: Option<f64>, by_cells: Option<f64>) -> Self {
        let both = [by_spread, by_cells].into_iter().flatten().fold(rays, f64::max);
        let packings = (both * both - rays * rays).max(0.0).sqrt();
        Self { both, packings: by_spread.or(by_cells).map(|_| packings) }
    }
}

impl Share {
    /// The bounds in the total.
    pub(super) fn bounds(&self) -> f64 {
        self.rim.unwrap_or(0.0) + self.floor + self.given_up + self.apart.unwrap_or(0.0)
    }
}

impl Budget {
    /// The budget of a signature.
    pub fn new(packings: &[Table], bands: &[Band]) -> Result<Self, Error> {
        let table = &packings[0];
        let (origin, levels) = (Table::origin_of(packings), Levels::of(packings));
        let um: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
        let reflectances = table.reflectances(&um)?;
        let steps = steps(packings, &reflectances, &um)?;
        // Where paths were traced by the spectra, their errors cannot be told apart.
        let sources = if table.nodes.is_some() { Vec::new() } else { sources(table) };
        let cells =
            (origin != Origin::Given).then(|| cells::of_tables(packings, &levels)).flatten();
        let curves = signature::curves(packings, &um)?;
        let share = |(i, ((band, rho), step)): (usize, ((&Band, &Vec<f64>), &f64))| {
            let e = band.emissivity;
            let rays = T_95 * e.rays_standard_error;
            let of_cells = cells.as_deref().map(|cells| OfCells::of_weights(cells, rho));
            let of_band: Vec<f64> = curves.iter().map(|curve| curve[i]).collect();
            let spread = of_cells.map(|cells| cells.spread);
            let by_spread = levels.half_width(&of_band, e.rays_standard_error, spread);
            let by_cells = of_cells.and_then(|cells| cells.half_width());
            let chance = Chance::new(rays, by_spread, by_cells);
            let rim = of_cells.map(|of_cells| of_cells.rim);
            let by_floor = table.floor.map(|floor| floor_changes(packings, floor, rho, e.mean));
            let floor = by_floor.map_or(0.0, |[black, white]| black.abs().max(white.abs()));
            let apart = (origin == Origin::DrawnApart).then_some(APART * (1.0 - e.mean));
            let share = Share {
                wavelength_um: band.wavelength_um,
                total: 0.0,
                rays,
                packings: chance.packings,
                rim,
                floor,
                given_up: e.trapped + e.mean * lets_through(packings, band.wavelength_um),
                apart,
                facets: (origin != Origin::Given).then_some(FACETS * (1.0 - e.mean)),
                spectral_step: *step,
                spectra: spectra(packings, &sources, band.wavelength_um, rho)?,
            };
            let share = Share { total: chance.both + share.bounds(), ..share };
            let floor = by_floor.map_or(0.0, |[black, white]| black - white);
            Ok::<_, Error>((share, floor, spread))
        };
        let of_bands: Vec<_> = bands.iter().zip(&reflectances).zip(&steps).enumerate().collect();
        let unknown = |m: &&TableMaterial| {
            let is_constant = matches!(m.spectrum, Spectrum::Constant(_));
            !m.spectrum.has_error() || (table.nodes.is_some() && !is_constant)
        };
        let of_bands: Vec<(Share, f64, Option<f64>)> =
            of_bands.into_par_iter().map(share).collect::<Result<_, _>>()?;
        let by_floor = of_bands.iter().map(|(_, floor, _)| *floor);
        Ok(Self {
            bands: of_bands.iter().map(|(share, ..)| *share).collect(),
            by_cells: of_bands.iter().map(|(.., spread)| *spread).collect(),
            floor_effect: table.floor.map(|_| by_floor.fold(0.0, f64::max)),
            spectra_unknown: table
                .materials
                .iter()
                .filter(unknown)
                .map(|m| m.name.clone())
                .collect(),
        })
    }

    /// The band with the widest total.
    ///
    /// # Panics
    /// Without a band.
    pub fn widest(&self) -> Share {
        let widest = self.bands.iter().max_by(|a, b| a.total.total_cmp(&b.total));
        *widest.expect("there is at least one band")
    }

    /// The columns beyond the wavelength: heading, meaning, and a value for each band.
    pub(super) fn columns(&self) -> Vec<(&'static str, &'static str, Vec<Option<f64>>)> {
        let column = |(&(heading, meaning), value): (&(&'static str, &'static str), Part)| {
            (heading, meaning, self.bands.iter().map(value).collect())
        };
        COLUMNS[1..].iter().zip(PARTS).map(column).collect()
    }

    /// The budget as CSV; what does not apply has empty fields.
    pub fn csv_text(&self) -> String {
        let mut csv = Csv::new(&COLUMNS.map(|(heading, _)| heading));
        for share in &self.bands {
            let numbers = PARTS.map(|part| part(share));
            let um = share.wavelength_um.to_string();
            csv.row([um].into_iter().chain(numbers.map(decimals)));
        }
        csv.text()
    }
}

/// Changes of the emissivity by a black and by a white floor. Whatever lies deeper is between them.
fn floor_changes(packings: &[Table], floor: usize, rho: &[f64], emissivity: f64) -> [f64; 2] {
    [0.0, 1.0].map(|of_floor| with(packings, rho, &[floor], |_| of_floor) - emissivity)
}

/// What opaque `auto` facets let through, of the bed where it is most. It reaches the sky at most.
fn lets_through(packings: &[Table], um: f64) -> f64 {
    packings.iter().map(|table| table.lets_through(um)).fold(0.0, f64::max)
}

/// The emissivity after a change of the reflectance of some materials.
fn with(packings: &[Table], rho: &[f64], materials: &[usize], change: impl Fn(f64) -> f64) -> f64 {
    let kept = packings[0].histogram.kept;
    let mut changed = rho.to_vec();
    for material in materials {
        for rho in &mut changed[kept.symbols_of(*material)] {
            *rho = change(*rho);
        }
    }
    signature::emissivity(packings, &changed).mean
}

/// The error of linear interpolation half-way to the next band, the larger of both sides. Where paths
/// were traced apart at nodes, that of straight lines between them.
fn steps(packings: &[Table], reflectances: &[Vec<f64>], um: &[f64]) -> Result<Vec<f64>, Error> {
    let of = |reflectances: &[Vec<f64>]| -> Vec<f64> {
        reflectances.par_iter().map(|rho| signature::emissivity(packings, rho).mean).collect()
    };
    if let Some(nodes) = &packings[0].nodes {
        let at_nodes = of(&packings[0].reflectances(&nodes.wavelength_um)?);
        return Ok(nodes.line_errors(&at_nodes, um));
    }
    let middles: Vec<f64> = um.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect();
    let (at_bands, between) = (of(reflectances), of(&packings[0].reflectances(&middles)?));
    let missed: Vec<f64> = at_bands
        .windows(2)
        .zip(between)
        .map(|(pair, between)| (between - f64::midpoint(pair[0], pair[1])).abs())
        .collect();
    let at = |i: usize| missed.get(i).copied().unwrap_or(0.0);
    Ok((0..um.len()).map(|i| at(i).max(if i > 0 { at(i - 1) } else { 0.0 })).collect())
}

/// The distinct spectra of a table, each with its materials, whose errors are fully correlated.
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

/// Half-width by the known errors of spectra, which are taken as normal and independent.
fn spectra(
    packings: &[Table],
    sources: &[(&Spectrum, Vec<usize>)],
    um: f64,
    reflectance: &[f64],
) -> Result<f64, Error> {
    let mut squares = 0.0;
    for (spectrum, materials) in sources {
        let error = spectrum.error(um)?;
        if error > 0.0 {
            let [more, less] = [error, -error]
                .map(|by| with(packings, reflectance, materials, |rho| (rho + by).clamp(0.0, 1.0)));
            squares += ((more - less) / 2.0).powi(2);
        }
    }
    Ok(1.96 * squares.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_that_do_not_apply_are_empty_in_the_file_and_the_widest_band_is_found() {
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
        let budget = Budget { bands, ..Budget::default() };
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
