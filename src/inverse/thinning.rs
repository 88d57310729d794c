//! A bed of full cover whose fines are taken away step by step, traced by the same paths.
//!
//! This is the tuning loop of the paper, without Blender. The order is random and the same for every
//! step: fewer fines are always part of more. A path that no lost fine had met stays the same, so
//! curves over the cover are smooth.

use std::collections::BTreeSet;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::InverseError;
use crate::geometry::{Bed, Mesh, Parts};
use crate::histogram::Histogram;
use crate::histogram::tally::Tally;
use crate::scene::Scene;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::random::{Purpose, Source};
use crate::tracer::Tracer;
use crate::tracer::rules::TracingRules;
use crate::tracer::trace;

/// What a bed consists of, by its materials' numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Roles {
    /// Materials of fines.
    pub fines: BTreeSet<u16>,
    /// Materials of the grains' bodies.
    pub grains: BTreeSet<u16>,
}

/// The fines of a bed's meshes.
pub struct Fines {
    /// The parts of each mesh.
    parts: Vec<Parts>,
    /// The fines of each mesh, in the order of the sizes and then at random: the first stay longest.
    kept_first: Vec<[Vec<u32>; 2]>,
    /// The materials.
    pub roles: Roles,
}

impl Fines {
    /// Finds the fines of a bed: in each mesh all parts but the largest. Their order is drawn from
    /// the seed.
    ///
    /// # Errors
    /// The bed has no fines, or a material is that of grains and fines.
    pub fn of(bed: &Bed, scene: &Scene, seed: u64) -> Result<Self, Error> {
        let source = Source::new(seed, Purpose::Thinning);
        let parts: Vec<Parts> = bed.meshes.par_iter().map(Parts::of).collect();
        let mut roles = Roles { fines: BTreeSet::new(), grains: BTreeSet::new() };
        for parts in &parts {
            for (part, &material) in (0..).zip(&parts.materials) {
                let is_body = parts.largest() == Some(part);
                if is_body { &mut roles.grains } else { &mut roles.fines }.insert(material);
            }
        }
        let unfit = |problem: &str| {
            let (scene, problem) = (scene.file.clone(), problem.to_owned());
            Err(InverseError::Bed { scene, problem }.into())
        };
        if roles.fines.is_empty() {
            return unfit("its grains have no fines that could be taken away");
        }
        if !roles.fines.is_disjoint(&roles.grains) {
            return unfit("fines and grains have one material, so their spectra cannot differ");
        }
        let fines_of = |(mesh, parts): (u64, &Parts)| {
            let mut random = source.stream(mesh);
            let body = parts.largest();
            let fines: Vec<u32> =
                (0..parts.diameters_um.len() as u32).filter(|part| Some(*part) != body).collect();
            let mut drawn: Vec<(f64, u32)> =
                fines.into_iter().map(|part| (random.pair()[0], part)).collect();
            drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
            let is_large = large(parts, body);
            let (large, small): (Vec<u32>, Vec<u32>) =
                drawn.into_iter().map(|(_, part)| part).partition(|&part| is_large(part));
            [small, large]
        };
        let kept_first = (0..).zip(&parts).map(fines_of).collect();
        Ok(Self { parts, kept_first, roles })
    }

    /// The meshes with these shares of their small and of their large fines.
    pub fn keep(&self, bed: &Bed, shares: [f64; 2]) -> Vec<Mesh> {
        let of = |(mesh, (parts, fines)): (&Mesh, (&Parts, &[Vec<u32>; 2]))| {
            let mut keeps = vec![false; parts.diameters_um.len()];
            if let Some(body) = parts.largest() {
                keeps[body as usize] = true;
            }
            for (fines, share) in fines.iter().zip(shares) {
                let number = (share * fines.len() as f64).round() as usize;
                fines[..number].iter().for_each(|&part| keeps[part as usize] = true);
            }
            mesh.with_parts(parts, |part| keeps[part as usize])
        };
        let all = self.parts.par_iter().zip(&self.kept_first);
        bed.meshes.par_iter().zip(all).map(of).collect()
    }

    /// Share of the large ones among all fines of the bed, by number.
    pub fn large_share(&self) -> f64 {
        let count = |class: usize| {
            self.kept_first.iter().map(|fines| fines[class].len()).sum::<usize>() as f64
        };
        count(1) / (count(0) + count(1)).max(1.0)
    }
}

/// Whether a fine is one of the larger class: the sizes are split where they leave the widest gap.
fn large(parts: &Parts, body: Option<u32>) -> impl Fn(u32) -> bool {
    let all = 0..parts.diameters_um.len() as u32;
    let mut sizes: Vec<f64> = all
        .filter(|part| Some(*part) != body)
        .map(|part| parts.diameters_um[part as usize])
        .collect();
    sizes.sort_by(f64::total_cmp);
    let gap = |pair: &&[f64]| pair[1] / pair[0];
    let widest = sizes.windows(2).max_by(|a, b| gap(a).total_cmp(&gap(b)));
    // One class has no gap.
    let split = widest.filter(|pair| gap(pair) > SPLIT).map_or(f64::INFINITY, |pair| pair[1]);
    let sizes = parts.diameters_um.clone();
    move |part| sizes[part as usize] >= split
}

/// The least ratio of neighbouring sizes that splits fines into two classes.
const SPLIT: f64 = 1.1;

/// A bed with some of its fines, traced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thinned {
    /// Shares of the small and of the large fines that are left.
    pub kept: [f64; 2],
    /// Share of the grains' silhouettes that is fines: the mean over the grains.
    pub cover: f64,
    /// What the paths did.
    pub histogram: Histogram,
    /// The same by cells of the view, where the bed fills it.
    pub cells: Option<Histogram>,
}

/// How beds are traced.
#[derive(Clone, Copy)]
pub struct Paths<'a> {
    /// The rules.
    pub rules: &'a TracingRules,
    /// Seed of the paths.
    pub seed: u64,
    /// Their number.
    pub number: u64,
}

/// Traces a bed, and measures its cover. Beds of one seed are traced by the same paths.
pub fn traced(
    tracer: &Tracer,
    scene: &Scene,
    roles: &Roles,
    paths: Paths,
    kept: [f64; 2],
    monitor: &dyn Monitor,
) -> Result<Thinned, Error> {
    let check = |_| monitor.check();
    let tally: Tally =
        tracer.trace(paths.rules, paths.seed, Purpose::Result, 0..paths.number, &check)?;
    let (histogram, cells) = (Histogram::of(&tally), Histogram::by_cell(&tally));
    Ok(Thinned { kept, cover: cover(tracer, scene, roles), histogram, cells })
}

/// The share of the grains' silhouettes that is fines, the mean over the grains.
pub fn cover(tracer: &Tracer, scene: &Scene, roles: &Roles) -> f64 {
    let by_mesh = trace::coverage(tracer, scene);
    let bed = tracer.bed();
    let names: Vec<&str> =
        roles.fines.iter().map(|&m| scene.materials[usize::from(m)].name.as_str()).collect();
    let of_mesh = |mesh: &Mesh| {
        let silhouette = &by_mesh[&mesh.name].silhouette;
        names.iter().filter_map(|name| silhouette.get(*name)).sum::<f64>()
    };
    let covers: Vec<f64> = bed.meshes.iter().map(of_mesh).collect();
    let sum: f64 = bed.placements.iter().map(|place| covers[place.mesh]).sum();
    // A sum of nothing is -0.
    (sum / bed.placements.len() as f64).abs()
}

/// The bed with these shares of its fines, each traced by the same paths.
pub fn steps(
    tracer: &Tracer,
    scene: &Scene,
    fines: &Fines,
    paths: Paths,
    kept: &[[f64; 2]],
    monitor: &dyn Monitor,
) -> Result<Vec<Thinned>, Error> {
    let mut done = Vec::new();
    for (number, &shares) in kept.iter().enumerate() {
        let meshes = fines.keep(tracer.bed(), shares);
        let thinned = Tracer::new(Bed { meshes, ..tracer.bed().clone() });
        done.push(traced(&thinned, scene, &fines.roles, paths, shares, monitor)?);
        monitor.at(number as u64 + 1, kept.len() as u64, "covers");
    }
    Ok(done)
}
