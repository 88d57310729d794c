//! The wavelengths at which paths are traced apart, where grains refract.
//!
//! Between two nodes the weight that paths bring to the sky is a straight line. Nodes are as many as
//! the optical constants need: they are set before anything is traced, by how what one grain
//! reflects and lets through departs from straight lines.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::TableMaterial;
use crate::scene::{Scene, SceneGeometry, Sides};
use crate::spectrum::optics::unpolarised_reflectance;
use crate::spectrum::{Spectrum, SpectrumError, kirchhoff};
use crate::support::error::Failure;
use crate::support::linear::OutOfRange;
use crate::support::math;

/// Largest departure from straight lines between nodes, in reflectance and transmittance.
const DEPARTURE: f64 = 0.01;

/// Lengths of path within a grain at which its transmittance is compared, um.
const LENGTHS_UM: [f64; 4] = [10.0, 30.0, 100.0, 300.0];

/// Cosines of the angle of incidence at which its reflectance is compared.
const COSINES: [f64; 2] = [1.0, 0.4];

/// The nodes of a scene with refractive facets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nodes {
    /// The wavelengths, um, ascending.
    pub wavelength_um: Vec<f64>,
    /// Index of the floor's material, whose reflectance the weights leave out; `None` where it is a
    /// mirror, or there is no floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<usize>,
    /// Of each wavelength whether `auto` facets are opaque there; empty without such facets.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub opaque: Vec<bool>,
}

/// A scene with refractive facets cannot be traced.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NodesError {
    /// Radiances would need more than a weight at each node.
    #[error("refractive facets need one temperature of all materials and an isotropic sky")]
    Radiance,
    /// Other sides cut solids.
    #[error("refractive facets need sides of the domain that are mirrors, or open")]
    Sides,
    /// The floor lets light through.
    #[error("the floor's material {0:?} is refractive: a floor is opaque")]
    Floor(String),
    /// A mesh has no inside.
    #[error("the mesh {0:?} is refractive and not closed: it has no inside")]
    Open(String),
    /// Packings were not traced alike.
    #[error("auto facets are opaque in some beds of {0:?} and refract in others")]
    Mixed(String),
    /// An image would need a trace of each band.
    #[error("images of scenes with refractive facets cannot be made")]
    Image,
}

impl Failure for NodesError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Radiance => {
                "give temperature_k one value, leave it out of materials, and give the sky one value".into()
            }
            Self::Sides => "give \"sides\": \"mirror\"".into(),
            Self::Floor(_) => {
                "give the floor a material of its own, such as {\"constant\": 0.95}".into()
            }
            Self::Open(_) => {
                "close the mesh, or give it opaque facets: fresnel or a spectrum".into()
            }
            Self::Mixed(_) => "give them fresnel or refractive facets".into(),
            Self::Image => "use fresnel facets for images of opaque grains".into(),
        })
    }
}

impl Nodes {
    /// The nodes of a scene for some bands; `None` where no facet refracts.
    ///
    /// # Errors
    /// The scene asks for what is not traced with refraction.
    pub(super) fn of(
        scene: &Scene,
        materials: &[TableMaterial],
        wavelengths_um: &[f64],
    ) -> Result<Option<Self>, NodesError> {
        if !materials.iter().any(|m| m.spectrum.is_refractive()) {
            return Ok(None);
        }
        if scene.is_of_temperatures() || scene.sky_is_by_zenith() {
            return Err(NodesError::Radiance);
        }
        let floor = match &scene.geometry {
            SceneGeometry::Packing(packing) => Some(packing.floor_material.as_str()),
            SceneGeometry::Placed(placed) => {
                if placed.domain.as_ref().is_some_and(|domain| {
                    matches!(domain.sides, Sides::Periodic | Sides::Field { .. })
                }) {
                    return Err(NodesError::Sides);
                }
                let floor = placed.domain.as_ref().and_then(|domain| domain.floor.as_ref());
                floor.map(|floor| floor.material.as_str())
            }
        };
        let floor = floor.and_then(|name| scene.material_index(name));
        if let Some(floor) = floor.filter(|i| materials[*i].spectrum.is_refractive()) {
            return Err(NodesError::Floor(materials[floor].name.clone()));
        }
        let is_plain = |i: &usize| !materials[*i].spectrum.is_angular();
        let wavelength_um = chosen(materials, wavelengths_um);
        Ok(Some(Self { wavelength_um, floor: floor.filter(is_plain), opaque: Vec::new() }))
    }

    /// In each band the factor of each symbol: those of the nodes give the straight line between the
    /// two nodes beside it.
    ///
    /// # Errors
    /// A band is beyond the nodes, or the floor's spectrum does not hold it.
    pub fn reflectances(
        &self,
        materials: &[TableMaterial],
        wavelengths_um: &[f64],
    ) -> Result<Vec<Vec<f64>>, SpectrumError> {
        let nodes = &self.wavelength_um;
        let last = nodes.len() - 1;
        let of_band = |&um: &f64| {
            let held_um = [nodes[0], nodes[last]];
            OutOfRange::check(|| "the trace".into(), [um; 2], held_um)?;
            // Paths are counted once for each node, so that a node has a share of them.
            let whole = nodes.len() as f64;
            let mut factors = vec![0.0; nodes.len() + 1];
            for (node, share) in self.shares(um) {
                factors[node] += whole * share;
            }
            factors[last + 1] = match self.floor {
                Some(floor) => kirchhoff(materials[floor].spectrum.emissivity(um)?),
                None => 1.0,
            };
            Ok(factors)
        };
        wavelengths_um.iter().map(of_band).collect()
    }

    /// The two nodes of which a band between them is made, with their shares.
    fn shares(&self, um: f64) -> [(usize, f64); 2] {
        let nodes = &self.wavelength_um;
        let after = nodes.partition_point(|node| *node < um).min(nodes.len() - 1);
        if after == 0 || nodes[after] == um {
            return [(after, 1.0), (after, 0.0)];
        }
        let [a, b] = [nodes[after - 1], nodes[after]];
        let beyond = (um - a) / (b - a);
        [(after - 1, 1.0 - beyond), (after, beyond)]
    }

    /// The share of a band for which `auto` facets were opaque; `None` without such facets.
    pub(super) fn opaque_share(&self, um: f64) -> Option<f64> {
        let of = |(node, share): (usize, f64)| if self.opaque[node] { share } else { 0.0 };
        (!self.opaque.is_empty()).then(|| self.shares(um).map(of).iter().sum())
    }

    /// Whether two beds have the same nodes. In some `auto` facets may be opaque that refract in the
    /// other.
    pub(super) fn are_those_of(&self, other: &Self) -> bool {
        self.wavelength_um == other.wavelength_um && self.floor == other.floor
    }

    /// The error of straight lines at each wavelength, um, by the values at the nodes.
    ///
    /// A node departs from the line between its neighbours by f'' h1 h2 / 2, and the line over an
    /// interval h from the curve by f'' h^2 / 8.
    pub fn line_errors(&self, values: &[f64], wavelengths_um: &[f64]) -> Vec<f64> {
        let nodes = &self.wavelength_um;
        let curvature = |i: usize| {
            if i == 0 || i + 1 >= nodes.len() {
                return 0.0;
            }
            let (before, after) = (nodes[i] - nodes[i - 1], nodes[i + 1] - nodes[i]);
            let line = (values[i - 1] * after + values[i + 1] * before) / (before + after);
            (values[i] - line).abs() / (before * after)
        };
        let of = |um: &f64| {
            let after = nodes.partition_point(|node| node < um).clamp(1, nodes.len().max(2) - 1);
            if nodes.contains(um) || nodes.len() < 2 {
                return 0.0;
            }
            let width = nodes[after] - nodes[after - 1];
            curvature(after - 1).max(curvature(after)) * width * width / 4.0
        };
        wavelengths_um.iter().map(of).collect()
    }

    /// Why they are not nodes of so many materials, if they are not.
    pub(super) fn problem(&self, materials: usize) -> Option<String> {
        let um = &self.wavelength_um;
        let is_sound = !um.is_empty() && um.windows(2).all(|pair| pair[0] < pair[1]);
        let has_floor = self.floor.is_none_or(|floor| floor < materials);
        let is_whole = self.opaque.is_empty() || self.opaque.len() == um.len();
        (!is_sound || !has_floor || !is_whole)
            .then(|| "the nodes are not ascending, or lack the floor".into())
    }
}

/// The bands that are nodes: the first, the last, and in between the band that departs most from a
/// straight line, until none departs by more than [`DEPARTURE`].
fn chosen(materials: &[TableMaterial], wavelengths_um: &[f64]) -> Vec<f64> {
    let rows: Vec<Vec<f64>> = wavelengths_um.iter().map(|&um| compared(materials, um)).collect();
    let mut is_node = vec![false; rows.len()];
    let mut spans = vec![(0, rows.len() - 1)];
    while let Some((from, to)) = spans.pop() {
        (is_node[from], is_node[to]) = (true, true);
        let departure = |i: usize| {
            let beyond = (wavelengths_um[i] - wavelengths_um[from])
                / (wavelengths_um[to] - wavelengths_um[from]);
            let parts = rows[i].iter().zip(&rows[from]).zip(&rows[to]);
            parts.map(|((v, a), b)| (v - a - beyond * (b - a)).abs()).fold(0.0, f64::max)
        };
        let worst = (from + 1..to).map(|i| (departure(i), i)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((departure, i)) = worst
            && departure > DEPARTURE
        {
            spans.extend([(from, i), (i, to)]);
        }
    }
    wavelengths_um.iter().zip(is_node).filter(|(_, is)| *is).map(|(um, _)| *um).collect()
}

/// What a wavelength does to light at one face of each material and within it.
fn compared(materials: &[TableMaterial], um: f64) -> Vec<f64> {
    let mut row = Vec::new();
    for material in materials {
        let Spectrum::Refractive(_, crystal) = &material.spectrum else {
            row.push(material.spectrum.emissivity(um).unwrap_or(0.0));
            continue;
        };
        for (_, axis) in crystal.axes.each() {
            let eps = axis.dielectric(um);
            row.extend(COSINES.map(|cosine| unpolarised_reflectance(eps, cosine)));
            let absorbed_per_um = 4.0 * PI * eps.sqrt().im / um;
            row.extend(LENGTHS_UM.map(|length| math::exp(-absorbed_per_um * length)));
        }
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grain(constants: &str) -> TableMaterial {
        TableMaterial {
            name: "grain".into(),
            spectrum: Spectrum::refractive(constants).expect("shipped"),
            auto: false,
            temperature_k: None,
            specular: 1.0,
            mean_chord_um: None,
            first_hits: 0,
        }
    }

    fn grid() -> Vec<f64> {
        (750..=1400).map(|i| f64::from(i) / 100.0).collect()
    }

    #[test]
    fn between_nodes_reflectance_and_transmittance_are_straight_within_a_hundredth() {
        let materials = [grain("quartz_zeidler")];
        let um = chosen(&materials, &grid());
        assert!(um.len() > 40 && um.len() < 250, "{}", um.len());
        assert_eq!((um[0], um[um.len() - 1]), (7.5, 14.0));
        let nodes = Nodes { wavelength_um: um.clone(), floor: None, opaque: Vec::new() };
        let factors = nodes.reflectances(&materials, &grid()).expect("within");
        for (um, factors) in grid().iter().zip(factors) {
            let exact = compared(&materials, *um);
            let mut line = vec![0.0; exact.len()];
            for (node, factor) in nodes.wavelength_um.iter().zip(&factors) {
                for (sum, v) in line.iter_mut().zip(compared(&materials, *node)) {
                    *sum += factor / nodes.wavelength_um.len() as f64 * v;
                }
            }
            let worst = exact.iter().zip(line).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst <= DEPARTURE + 1e-12, "{um}: {worst}");
        }
    }

    #[test]
    fn line_errors_are_those_of_a_parabola() {
        let wavelength_um = vec![8.0, 8.5, 9.5, 10.0];
        let nodes = Nodes { wavelength_um, floor: None, opaque: Vec::new() };
        let of = |um: f64| 0.1 * um * um;
        let values: Vec<f64> = nodes.wavelength_um.iter().map(|um| of(*um)).collect();
        let errors = nodes.line_errors(&values, &[8.0, 9.0, 9.5]);
        // Half-way the line is f'' h^2 / 8 = 0.2 / 8 off.
        assert!((errors[1] - 0.025).abs() < 1e-12 && errors[0] == 0.0 && errors[2] == 0.0);
        assert!(nodes.reflectances(&[], &[7.9]).is_err());
    }
}
