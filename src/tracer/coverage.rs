//! What of each prototype is seen: how much of its silhouette is of each material, and how much of the sensor's
//! view it fills.
//!
//! Rays on the meshes that are traced, so it holds for any placed scene. Of a dusty grain the share of the fines'
//! material is its cover with fines.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::support::random::{Purpose, Source};
use crate::table::cover::Cover;
use crate::tracer::Tracer;

/// Rays for all silhouettes together, and least and most for one of them.
const SILHOUETTE_RAYS: u64 = 1 << 15;
const FEWEST: u64 = 1 << 9;
const MOST: u64 = 1 << 12;

/// Rays into the sensor's view.
const VIEW_RAYS: u64 = 1 << 13;

/// The cover of every prototype of a traced bed by its name; `materials` are the scene's names. Meshes of one
/// name are taken together.
pub fn measure(tracer: &Tracer, materials: &[&str], seed: u64) -> BTreeMap<String, Cover> {
    let source = Source::new(seed, Purpose::Coverage);
    let meshes = &tracer.bed().meshes;
    let rays = (SILHOUETTE_RAYS / meshes.len().max(1) as u64).clamp(FEWEST, MOST);
    let view: Vec<_> = (0..VIEW_RAYS)
        .into_par_iter()
        .filter_map(|number| tracer.first(source.stream(number).pair()))
        .collect();
    let mut covers: BTreeMap<String, Cover> = BTreeMap::new();
    for name in meshes.iter().map(|mesh| &mesh.name) {
        if covers.contains_key(name) {
            continue;
        }
        let ours = |mesh: &usize| meshes[*mesh].name == *name;
        let silhouette: Vec<u16> = (0..meshes.len())
            .filter(ours)
            .flat_map(|mesh| self::silhouette(tracer, mesh, rays, &source))
            .collect();
        let seen = view.iter().filter(|(mesh, _)| mesh.as_ref().is_some_and(ours));
        let cover = Cover {
            silhouette_standard_error: 0.0,
            view: shares(seen.map(|(_, material)| *material), view.len(), materials),
            silhouette: shares(silhouette.iter().copied(), silhouette.len(), materials),
        };
        let variance = cover.silhouette.values().map(|p| p * (1.0 - p)).fold(0.0, f64::max);
        let error = (variance / silhouette.len().max(1) as f64).sqrt();
        covers.insert(name.clone(), Cover { silhouette_standard_error: error, ..cover });
    }
    covers
}

/// The materials that lines meet first which are spread evenly over all that meet a mesh's bounding sphere.
fn silhouette(tracer: &Tracer, mesh: usize, rays: u64, source: &Source) -> Vec<u16> {
    let alone = tracer.accelerator().alone(tracer.bed(), mesh);
    let radius = alone.radius_um();
    let materials = &tracer.bed().meshes[mesh].materials;
    (0..rays)
        .into_par_iter()
        .filter_map(|number| {
            // Meshes and the view have numbers of their own.
            let mut random = source.stream((mesh as u64 + 1) << 32 | number);
            let direction = even_direction(random.pair());
            let (right, up) = direction.any_orthonormal_pair();
            let [u, v] = random.pair();
            let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
            let aside = radius * u.sqrt() * (cos * right + sin * up);
            let hit = alone.closest(aside - 2.0 * radius * direction, direction)?;
            Some(materials[hit])
        })
        .collect()
}

/// A direction drawn evenly from the sphere.
fn even_direction([u, v]: [f64; 2]) -> DVec3 {
    let height = 2.0 * u - 1.0;
    let ring = (1.0 - height * height).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
    DVec3::new(ring * cos, ring * sin, height)
}

/// How often each material comes up, as a share of `all`.
fn shares(
    hits: impl Iterator<Item = u16>,
    all: usize,
    materials: &[&str],
) -> BTreeMap<String, f64> {
    let mut shares = BTreeMap::new();
    for material in hits {
        *shares.entry(materials[usize::from(material)].to_owned()).or_default() += 1.0;
    }
    for share in shares.values_mut() {
        *share /= all as f64;
    }
    shares
}
