//! How paths are traced, and what is recorded of each.

use glam::DVec3;

use crate::geometry::to_sensor;
use crate::histogram::kept::Kept;
use crate::scene::{Layers, Sun, View};
use crate::support::random::Sampler;
use crate::table::{Prepared, TableMaterial};
use crate::tracer::media::Node;

/// Hits after which a path is given up, whatever its weight: two mirrors face to face would hold it
/// for ever.
pub const MOST_HITS: u16 = 128;

/// How a facet scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facet {
    /// The share that is specular, 0 to 1; the rest is Lambertian.
    pub specular: f64,
    /// Whether its reflectance depends on the angle of the hit.
    pub by_angle: bool,
}

impl Facet {
    /// Reflects all light diffusely, whatever its direction.
    pub const LAMBERTIAN: Self = Self { specular: 0.0, by_angle: false };
}

/// How paths are traced, and what is recorded of each.
#[derive(Debug, Clone, PartialEq)]
pub struct TracingRules {
    /// What is recorded of each path.
    pub kept: Kept,
    /// The facets of each material.
    pub facets: Vec<Facet>,
    /// The source of random numbers.
    pub sampler: Sampler,
    /// Hits after which a path is given up.
    pub most_hits: u16,
    /// The greatest reflectance of each symbol in any band.
    pub greatest: Vec<f64>,
    /// Weight below which a path is given up: the product of these reflectances, times the share of
    /// the path that has not ended and the paths that it stands for.
    pub least_weight: f64,
    /// What light does at each node, where facets are refractive.
    pub nodes: Vec<Node>,
    /// Layers of temperature, if there are any.
    pub layers: Option<LayersOf>,
}

/// Layers of temperature, made ready for tracing.
#[derive(Debug, Clone, PartialEq)]
pub struct LayersOf {
    /// The layers.
    pub layers: Layers,
    /// The direction to the sun.
    pub to_sun: Option<DVec3>,
    /// Of each material whether it has them: others have a temperature of their own.
    pub has: Vec<bool>,
}

impl LayersOf {
    fn of(prepared: &Prepared) -> Option<Self> {
        let layers = prepared.scene.temperature_k.layers()?.clone();
        let to_sun = layers
            .sun()
            .map(|Sun { zenith_deg, azimuth_deg, .. }| to_sensor(View { zenith_deg, azimuth_deg }));
        let has = prepared.materials.iter().map(|m| m.temperature_k.is_none()).collect();
        Some(Self { layers, to_sun, has })
    }
}

impl TracingRules {
    /// The rules of a scene. They record the least that it needs, and give up no path for its
    /// weight.
    pub fn new(prepared: &Prepared) -> Self {
        let of =
            |m: &TableMaterial| Facet { specular: m.specular, by_angle: m.spectrum.is_angular() };
        let facets = prepared.materials.iter().map(of).collect();
        let nodes = prepared.nodes.as_ref();
        let nodes = nodes.map_or(Vec::new(), |nodes| Node::of(nodes, &prepared.materials));
        let layers = LayersOf::of(prepared);
        Self { nodes, layers, ..Self::of_facets(prepared.kept, facets) }
    }

    /// The rules for opaque facets of each material, all of one temperature or in order. No path is
    /// given up for its weight.
    pub fn of_facets(kept: Kept, facets: Vec<Facet>) -> Self {
        Self {
            kept,
            sampler: Sampler::Even,
            most_hits: MOST_HITS,
            greatest: vec![1.0; kept.symbols(facets.len())],
            facets,
            least_weight: 0.0,
            nodes: Vec::new(),
            layers: None,
        }
    }

    /// Gives up paths whose weight is below `least_weight` in each of the bands, which are given as
    /// one reflectance for each symbol.
    #[must_use]
    pub fn ending_below(mut self, least_weight: f64, bands: &[Vec<f64>]) -> Self {
        for (symbol, greatest) in self.greatest.iter_mut().enumerate() {
            *greatest = bands.iter().map(|band| band[symbol]).fold(0.0, f64::max);
        }
        self.least_weight = least_weight;
        self
    }
}
