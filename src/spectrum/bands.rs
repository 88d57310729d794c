//! Bands, and the wavelengths at which curves are evaluated for them.

use super::resample::Response;
use crate::support::error::Failure;

/// Spacing of the wavelengths within a band, nm. Curves bend on a scale of 10 nm or more.
const NODES_NM: f64 = 2.0;
/// Most wavelengths of all bands: 400 um of spectrum.
const MOST_NODES: usize = 200_000;
/// Most weights of the wavelengths in all bands.
const MOST_WEIGHTS: usize = 20_000_000;

/// The bands are so wide or so many that curves cannot be evaluated for them.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the sensor's bands take {needed} wavelengths 2 nm apart; {most} are the most")]
pub struct WideBandsError {
    /// The number that they take.
    pub needed: usize,
    /// The most.
    pub most: usize,
}

impl Failure for WideBandsError {
    fn hint(&self) -> Option<String> {
        Some("make the sensor's bands narrower or fewer".into())
    }
}

/// Some bands.
#[derive(Debug, Clone)]
pub(crate) struct Bands {
    /// Centroids, um, without errors of rounding.
    pub centres_um: Vec<f64>,
    /// Full widths at half maximum, um; 0 for a single wavelength.
    pub widths_um: Vec<f64>,
    /// Wavelengths at which curves are evaluated, um, ascending.
    pub nodes_um: Vec<f64>,
    /// The nodes of each band with their weights, which sum to 1.
    pub weights: Vec<Vec<(usize, f64)>>,
}

/// One band.
#[derive(Debug, Clone)]
pub(crate) enum Band {
    /// One wavelength, um.
    At(f64),
    /// A response and its full width at half maximum, um.
    Over(Response, f64),
}

impl Bands {
    /// Of bands in any order.
    ///
    /// # Errors
    /// They take too many wavelengths.
    pub(crate) fn new(bands: &[Band]) -> Result<Self, WideBandsError> {
        let count: usize = bands.iter().map(Band::count).fold(0, usize::saturating_add);
        if count > MOST_WEIGHTS {
            return Err(WideBandsError { needed: count, most: MOST_WEIGHTS });
        }
        let mut nodes_um: Vec<f64> = bands.iter().flat_map(Band::nodes_um).collect();
        nodes_um.sort_by(f64::total_cmp);
        nodes_um.dedup();
        if nodes_um.len() > MOST_NODES {
            let needed = nodes_um.len();
            return Err(WideBandsError { needed, most: MOST_NODES });
        }
        let place = |um: f64| nodes_um.partition_point(|&node| node < um);
        let in_span = |[from, to]: [f64; 2]| 1 + place(to) - place(from);
        let needed = bands.iter().map(|band| in_span(band.span_um())).sum();
        if needed > MOST_WEIGHTS {
            return Err(WideBandsError { needed, most: MOST_WEIGHTS });
        }
        let weights = bands.iter().map(|band| band.weights(&nodes_um)).collect();
        let rounded = |um: f64| (um * 1e9).round() / 1e9;
        let centres_um = bands.iter().map(|band| rounded(band.centre_um())).collect();
        let widths_um = bands.iter().map(|band| rounded(band.width_um())).collect();
        Ok(Self { centres_um, widths_um, nodes_um, weights })
    }

    /// The band whose centroid is nearest to a wavelength, um.
    pub(crate) fn nearest(&self, um: f64) -> usize {
        let off = |band: &usize| (self.centres_um[*band] - um).abs();
        (0..self.centres_um.len())
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .expect("there is at least one band")
    }

    /// The bands in which something does not hold at every wavelength, um.
    pub(crate) fn where_not(&self, holds: impl Fn(f64) -> bool) -> Vec<bool> {
        let at_nodes: Vec<bool> = self.nodes_um.iter().map(|&um| holds(um)).collect();
        let in_band = |band: &Vec<(usize, f64)>| {
            band.iter().any(|&(node, weight)| weight > 0.0 && !at_nodes[node])
        };
        self.weights.iter().map(in_band).collect()
    }

    /// The mean over a band of a curve given at the nodes.
    pub(crate) fn mean(&self, band: usize, at_nodes: &[f64]) -> f64 {
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
