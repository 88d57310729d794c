//! The bands of an image, and the wavelengths at which it is evaluated.

use std::path::Path;

use super::ImageError;
use crate::scene::{Grid, Sensor, SensorBands};
use crate::spectrum::resample::Response;
use crate::support::error::Error;

/// Spacing of the wavelengths within a band, nm. Curves bend on a scale of 10 nm or more.
const NODES_NM: f64 = 2.0;

/// The bands of an image.
pub(super) struct Bands {
    /// Centroids, um, without errors of rounding.
    pub centres_um: Vec<f64>,
    /// Full widths at half maximum, um; 0 for a single wavelength.
    pub widths_um: Vec<f64>,
    /// Wavelengths at which the image is evaluated, um, ascending.
    pub nodes_um: Vec<f64>,
    /// The nodes of each band with their weights, which sum to 1.
    pub weights: Vec<Vec<(usize, f64)>>,
}

enum Band {
    /// One wavelength, um.
    At(f64),
    /// A response and its full width at half maximum, um.
    Over(Response, f64),
}

/// Most wavelengths of all bands: 400 um of spectrum.
const MOST_NODES: usize = 200_000;
/// Most weights of the wavelengths in all bands.
const MOST_WEIGHTS: usize = 20_000_000;

impl Bands {
    /// The sensor's bands, else the wavelengths of the grid. Files are relative to `folder`.
    pub(super) fn new(sensor: Option<&Sensor>, folder: &Path, grid: &Grid) -> Result<Self, Error> {
        let bands = match sensor.and_then(|sensor| sensor.bands.as_ref()) {
            None => grid.wavelengths_um().into_iter().map(Band::At).collect(),
            Some(bands) => Self::of_sensor(bands, folder)?,
        };
        let count: usize = bands.iter().map(Band::count).fold(0, usize::saturating_add);
        if count > MOST_WEIGHTS {
            return Err(ImageError::WideBands { needed: count, most: MOST_WEIGHTS }.into());
        }
        let mut nodes_um: Vec<f64> = bands.iter().flat_map(Band::nodes_um).collect();
        nodes_um.sort_by(f64::total_cmp);
        nodes_um.dedup();
        if nodes_um.len() > MOST_NODES {
            let needed = nodes_um.len();
            return Err(ImageError::WideBands { needed, most: MOST_NODES }.into());
        }
        let place = |um: f64| nodes_um.partition_point(|&node| node < um);
        let in_span = |[from, to]: [f64; 2]| 1 + place(to) - place(from);
        let needed = bands.iter().map(|band| in_span(band.span_um())).sum();
        if needed > MOST_WEIGHTS {
            return Err(ImageError::WideBands { needed, most: MOST_WEIGHTS }.into());
        }
        let weights = bands.iter().map(|band| band.weights(&nodes_um)).collect();
        let rounded = |um: f64| (um * 1e9).round() / 1e9;
        let centres_um = bands.iter().map(|band| rounded(band.centre_um())).collect();
        let widths_um = bands.iter().map(|band| rounded(band.width_um())).collect();
        Ok(Self { centres_um, widths_um, nodes_um, weights })
    }

    fn of_sensor(bands: &[SensorBands], folder: &Path) -> Result<Vec<Band>, Error> {
        let mut all = Vec::new();
        for band in bands {
            match *band {
                SensorBands::Box { centre_um, width_um: 0.0 } => all.push(Band::At(centre_um)),
                SensorBands::Box { centre_um, width_um } => {
                    let (from_um, to_um) = (centre_um - width_um / 2.0, centre_um + width_um / 2.0);
                    all.push(Band::Over(Response::boxed(from_um, to_um), width_um));
                }
                SensorBands::Gaussian { centre_um, fwhm_um } => {
                    all.push(Band::Over(Response::gaussian(centre_um, fwhm_um), fwhm_um));
                }
                SensorBands::File(ref file) => {
                    let response = Response::read(&folder.join(file))?;
                    let width_um = response.width_um();
                    all.push(Band::Over(response, width_um));
                }
                SensorBands::Grid { from_um, to_um, step_um, fwhm_um } => {
                    let grid = Grid::new(from_um, to_um, step_um).expect("the scene was checked");
                    let band =
                        |centre_um| Band::Over(Response::gaussian(centre_um, fwhm_um), fwhm_um);
                    all.extend(grid.wavelengths_um().into_iter().map(band));
                }
            }
        }
        Ok(all)
    }

    /// The band whose centroid is nearest to a wavelength, um.
    pub(super) fn nearest(&self, um: f64) -> usize {
        let off = |band: &usize| (self.centres_um[*band] - um).abs();
        (0..self.centres_um.len())
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .expect("there is at least one band")
    }

    /// The bands in which something does not hold at every wavelength, um.
    pub(super) fn where_not(&self, holds: impl Fn(f64) -> bool) -> Vec<bool> {
        let at_nodes: Vec<bool> = self.nodes_um.iter().map(|&um| holds(um)).collect();
        let in_band = |band: &Vec<(usize, f64)>| {
            band.iter().any(|&(node, weight)| weight > 0.0 && !at_nodes[node])
        };
        self.weights.iter().map(in_band).collect()
    }

    /// The mean over a band of a curve given at the nodes.
    pub(super) fn mean(&self, band: usize, at_nodes: &[f64]) -> f64 {
        self.weights[band].iter().map(|&(node, weight)| weight * at_nodes[node]).sum()
    }
}

impl Band {
    fn centre_um(&self) -> f64 {
        match self {
            Self::At(um) => *um,
            Self::Over(response, _) => response.centre_um(),
        }
    }

    fn width_um(&self) -> f64 {
        match self {
            Self::At(_) => 0.0,
            Self::Over(_, width_um) => *width_um,
        }
    }

    fn span_um(&self) -> [f64; 2] {
        match self {
            Self::At(um) => [*um; 2],
            Self::Over(response, _) => response.span_um(),
        }
    }

    /// About the number of its nodes.
    fn count(&self) -> usize {
        let [from_um, to_um] = self.span_um();
        2 + ((to_um - from_um) * 1e3 / NODES_NM) as usize
    }

    fn nodes_um(&self) -> Vec<f64> {
        match self {
            Self::At(um) => vec![*um],
            Self::Over(response, _) => {
                let [from_um, to_um] = response.span_um();
                let numbers = (from_um * 1e3 / NODES_NM).ceil() as u64
                    ..=(to_um * 1e3 / NODES_NM).floor() as u64;
                let mut nodes = vec![from_um, to_um];
                nodes.extend(numbers.map(|number| number as f64 * NODES_NM / 1e3));
                nodes
            }
        }
    }

    fn weights(&self, nodes_um: &[f64]) -> Vec<(usize, f64)> {
        let place = |um: f64| nodes_um.partition_point(|&node| node < um);
        match self {
            Self::At(um) => vec![(place(*um), 1.0)],
            Self::Over(response, _) => {
                let [first, last] = response.span_um().map(place);
                let weights = response.weights(&nodes_um[first..=last]);
                (first..).zip(weights).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bands(bands: Vec<SensorBands>) -> Bands {
        let sensor = Sensor { pixels: [1, 1], bands: Some(bands), ..Sensor::default() };
        Bands::new(Some(&sensor), Path::new(""), &Grid::PAPER).expect("sound bands")
    }

    #[test]
    fn bands_that_take_too_many_wavelengths_are_refused_before_they_are_made() {
        for (centre_um, width_um) in [(500.0, 900.0), (5e8, 9e8)] {
            let bands = Some(vec![SensorBands::Box { centre_um, width_um }]);
            let sensor = Sensor { pixels: [1, 1], bands, ..Sensor::default() };
            assert!(Bands::new(Some(&sensor), Path::new(""), &Grid::PAPER).is_err());
        }
    }

    /// Means of um squared, which are known exactly.
    #[test]
    fn bands_weigh_a_curve_as_their_responses_ask() {
        let all = bands(vec![
            SensorBands::Box { centre_um: 9.0, width_um: 0.5 },
            SensorBands::Gaussian { centre_um: 10.3, fwhm_um: 0.2 },
            SensorBands::Box { centre_um: 8.9371, width_um: 0.0 },
            SensorBands::Box { centre_um: 8.9371, width_um: 1e-7 },
            SensorBands::Grid { from_um: 8.0, to_um: 12.0, step_um: 0.5, fwhm_um: 0.03 },
        ]);
        assert_eq!(all.centres_um.len(), 13);
        let curve: Vec<f64> = all.nodes_um.iter().map(|um| um * um).collect();
        let sigma = |fwhm_um: f64| fwhm_um / (8.0 * std::f64::consts::LN_2).sqrt();
        let exact = [
            81.0 + 0.25 / 12.0,
            10.3 * 10.3 + sigma(0.2).powi(2),
            8.9371 * 8.9371,
            8.9371 * 8.9371,
        ];
        for (band, exact) in exact.into_iter().enumerate() {
            let mean = all.mean(band, &curve);
            // The Gaussian ends at 1e-4 of its maximum.
            assert!((mean - exact).abs() < 2e-5, "band {band}: {mean}, exact {exact}");
            let sum: f64 = all.weights[band].iter().map(|(_, weight)| weight).sum();
            assert!(
                (sum - 1.0).abs() < 1e-12 && (all.centres_um[band].powi(2) - exact).abs() < 0.1
            );
        }
        assert_eq!(all.centres_um[..3], [9.0, 10.3, 8.9371], "without errors of rounding");
        assert_eq!(all.widths_um[..5], [0.5, 0.2, 0.0, 1e-7, 0.03]);
        assert_eq!(all.weights[2].len(), 1, "a box of no width is a point");
        assert_eq!(all.nodes_um[all.weights[2][0].0], 8.9371);
        assert_eq!(all.nearest(10.06), 8, "that of the grid at 10");
    }
}
