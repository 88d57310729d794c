//! What is seen of each prototype: the materials of its silhouette, and its share of the sensor's
//! view.
//!
//! It is measured by rays on the traced meshes, so it holds for any placed scene. The share of the
//! fines' material on a dusty grain is its cover with fines.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;

use crate::support::math;
use crate::support::random::{Purpose, Source};
use crate::table::cover::Cover;
use crate::tracer::Tracer;

/// Rays for all silhouettes together; the least and the most for one of them.
const SILHOUETTE_RAYS: u64 = 1 << 15;
const FEWEST: u64 = 1 << 9;
const MOST: u64 = 1 << 12;

/// Rays into the sensor's view.
const VIEW_RAYS: u64 = 1 << 13;

/// The cover of every prototype of a traced bed, by its name. `materials` are the scene's names.
/// Meshes with one name count together.
pub fn measure(tracer: &Tracer, materials: &[&str], seed: u64) -> BTreeMap<String, Cover> {
    let source = Source::new(seed, Purpose::Coverage);
    let meshes = &tracer.bed().meshes;
    let rays = (SILHOUETTE_RAYS / meshes.len().max(1) as u64).clamp(FEWEST, MOST);
    let view: Vec<_> = (0..VIEW_RAYS)
        .into_par_iter()
        .filter_map(|number| tracer.first_hit(source.stream(number).pair()))
        .collect();
    let mut covers: BTreeMap<String, Cover> = BTreeMap::new();
    for name in meshes.iter().map(|mesh| &mesh.name).collect::<BTreeSet<_>>() {
        let ours = |mesh: &usize| meshes[*mesh].name == *name;
        let silhouette: Vec<u16> = (0..meshes.len())
            .filter(ours)
            .flat_map(|mesh| self::silhouette(tracer, mesh, rays, &source))
            .collect();
        let seen = view.iter().filter(|hit| hit.mesh.as_ref().is_some_and(ours));
        let view = shares(seen.map(|hit| hit.material), view.len(), materials);
        let rays = silhouette.len();
        let silhouette = shares(silhouette.into_iter(), rays, materials);
        let variance = silhouette.values().map(|p| p * (1.0 - p)).fold(0.0, f64::max);
        let silhouette_standard_error = (variance / rays.max(1) as f64).sqrt();
        covers.insert(name.clone(), Cover { silhouette, silhouette_standard_error, view });
    }
    covers
}

/// The materials that isotropic lines through a mesh's bounding sphere meet first.
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
            let (sin, cos) = math::sin_cos(std::f64::consts::TAU * v);
            let aside = radius * u.sqrt() * (cos * right + sin * up);
            let hit = alone.closest(aside - 2.0 * radius * direction, direction)?;
            Some(materials[hit])
        })
        .collect()
}

/// A direction, uniform on the sphere.
fn even_direction([u, v]: [f64; 2]) -> DVec3 {
    let height = 2.0 * u - 1.0;
    let ring = (1.0 - height * height).sqrt();
    let (sin, cos) = math::sin_cos(std::f64::consts::TAU * v);
    DVec3::new(ring * cos, ring * sin, height)
}

/// The share of each material in `all` rays.
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
