//! Bands, and the wavelengths at which curves are evaluated for them.

use super::resample::Response;

/// Spacing of the wavelengths within a band, nm. Curves bend on a scale of 10 nm or more.
const NODES_NM: f64 = 2.0;

/// Some bands.
#[derive(Debug, Clone)]
pub(crate) struct Bands {
    /// Centroids, um.
    pub centres_um: Vec<f64>,
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
    /// A response.
    Over(Response),
}

impl Bands {
    pub(crate) fn new(bands: &[Band]) -> Self {
        let mut nodes_um: Vec<f64> = bands.iter().flat_map(Band::nodes_um).collect();
        nodes_um.sort_by(f64::total_cmp);
        nodes_um.dedup();
        let weights = bands.iter().map(|band| band.weights(&nodes_um)).collect();
        let centres_um = bands.iter().map(Band::centre_um).collect();
        Self { centres_um, nodes_um, weights }
    }

    /// The band whose centroid is nearest to a wavelength, um.
    pub(crate) fn nearest(&self, um: f64) -> usize {
        let off = |band: &usize| (self.centres_um[*band] - um).abs();
        (0..self.centres_um.len())
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .expect("there is at least one band")
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
            Self::Over(response) => response.centre_um(),
        }
    }

    fn nodes_um(&self) -> Vec<f64> {
        match self {
            Self::At(um) => vec![*um],
            Self::Over(response) => {
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
            Self::Over(response) => {
                let [first, last] = response.span_um().map(place);
                let weights = response.weights(&nodes_um[first..=last]);
                (first..).zip(weights).collect()
            }
        }
    }
}
