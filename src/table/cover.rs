//! What is seen of each prototype, measured on the meshes: the cover with fines.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// What is seen of one prototype. Materials that are not seen are left out.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Cover {
    /// Share of each material in its silhouette: alone, seen from afar, over all directions.
    pub silhouette: BTreeMap<String, f64>,
    /// Largest standard error of these shares.
    pub silhouette_standard_error: f64,
    /// Share of the sensor's view that is this prototype, by material.
    pub view: BTreeMap<String, f64>,
}

/// The covers of several packings of one recipe as one: means over the packings.
pub fn mean(packings: &[&BTreeMap<String, Cover>]) -> BTreeMap<String, Cover> {
    let names: BTreeSet<&String> = packings.iter().flat_map(|covers| covers.keys()).collect();
    let mean = |name: &String| {
        let of: Vec<&Cover> = packings.iter().filter_map(|covers| covers.get(name)).collect();
        let mean = |shares: fn(&Cover) -> &BTreeMap<String, f64>| {
            let mut mean: BTreeMap<String, f64> = BTreeMap::new();
            for (material, share) in of.iter().flat_map(|cover| shares(cover)) {
                *mean.entry(material.clone()).or_default() += share / of.len() as f64;
            }
            mean
        };
        let variance: f64 = of.iter().map(|c| c.silhouette_standard_error.powi(2)).sum();
        Cover {
            silhouette: mean(|cover| &cover.silhouette),
            silhouette_standard_error: variance.sqrt() / of.len() as f64,
            view: mean(|cover| &cover.view),
        }
    };
    names.into_iter().map(|name| (name.clone(), mean(name))).collect()
}
