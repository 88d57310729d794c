//! The beds of a match: of full cover, and dropped anew at lower covers.

use std::path::PathBuf;
use std::time::Duration;

use super::soil::{FullBed, LargeShare, Role, Soil};
use super::thinning::{self, Fines, Paths, Roles, Thinned};
use crate::beds::own_grains::OwnGrains;
use crate::beds::{Order, Wanted};
use crate::blender;
use crate::geometry::ingest::Sources;
use crate::histogram::kept::{COSINES, Kept};
use crate::pipeline::program;
use crate::scene::{Cover, Packing, Scene, SceneGeometry, shipped};
use crate::support::cache::{Cache, CacheError};
use crate::support::error::Error;
use crate::support::monitor::{Monitor, Silently, Step};
use crate::support::output::{self, OutputError};
use crate::support::random;
use crate::support::scratch::Scratch;
use crate::table::TableMaterial;
use crate::tracer::Tracer;
use crate::tracer::rules::{Facet, TracingRules};

/// Shares of the fines that are left in the steps: the covers lie evenly.
const KEPT: [f64; 9] = [0.0, 0.04, 0.09, 0.16, 0.25, 0.37, 0.53, 0.74, 1.0];

/// Covers at which beds are dropped anew beside the answer.
pub const FRESH: [f64; 2] = [0.0, 0.5];

/// Where the effect of the large fines is traced: shares of the fines that are left, of which
/// fewer are large.
const WITH_FEWER_LARGE: [f64; 3] = [0.12, 0.45, 0.95];
const FEWER_LARGE: f64 = 0.4;

/// Paths of a bed of Lambertian facets: the noise of the rays is then below .001.
const PATHS: u64 = 1 << 15;
/// Paths of a bed with facets that reflect by angle: each is a state of its own.
const PATHS_BY_ANGLE: u64 = 1 << 11;

/// The least weight of a path in the brightest band that is followed further.
const LEAST_WEIGHT: f64 = 1e-4;

/// How beds are come by.
pub struct Source<'a> {
    /// The recipe of full cover, or a bed as it is.
    pub scene: &'a Scene,
    /// Whether the recipe is the shipped one, for which covers have their own trays.
    pub is_shipped: bool,
    /// Beds of each cover.
    pub beds: usize,
    /// The Blender asked for.
    pub blender: Option<PathBuf>,
    /// Its time limit for each bed.
    pub time_limit: Duration,
    /// The cache.
    pub cache: &'a Cache,
    /// Told of progress.
    pub monitor: &'a dyn Monitor,
}

/// A settled bed.
pub struct Settled {
    scene: Scene,
    tracer: Tracer,
    /// Whether it is a bed of full cover, to be thinned.
    is_full: bool,
}

impl Settled {
    /// Reads a placed scene.
    pub fn read(scene: Scene, is_full: bool) -> Result<Self, Error> {
        let tracer = Tracer::of(&Sources::read(&scene)?)?;
        Ok(Self { scene, tracer, is_full })
    }
}

impl<'a> Source<'a> {
    /// The beds of a match.
    pub fn of(options: &'a super::Options) -> Self {
        Self {
            scene: &options.scene,
            is_shipped: options.is_shipped,
            beds: options.beds,
            blender: options.blender.clone(),
            time_limit: options.time_limit,
            cache: options.cache,
            monitor: options.monitor,
        }
    }

    /// The beds of full cover and, of a recipe, those of lower covers.
    pub fn settle(&self) -> Result<Vec<Settled>, Error> {
        let SceneGeometry::Packing(_) = &self.scene.geometry else {
            return Ok(vec![Settled::read(self.scene.clone(), true)?]);
        };
        let step = Step::new(self.monitor, "drop");
        let limit = self.time_limit;
        let blender =
            blender::find(self.blender.as_deref(), self.cache.blenders(), limit, self.monitor)?;
        let recipes: Vec<(Scene, bool)> = std::iter::once((self.scene.clone(), true))
            .chain(FRESH.map(|cover| (self.covered(cover), false)))
            .collect();
        // Blender has one thread for each bed. So recipes are dropped side by side.
        let silent = Silently(self.monitor);
        let dropped: Vec<Result<Vec<Settled>, Error>> = std::thread::scope(|scope| {
            let running: Vec<_> = (recipes.iter())
                .map(|(scene, is_full)| {
                    let (blender, silent) = (&blender, &silent);
                    scope.spawn(move || self.drop(blender, scene, *is_full, silent))
                })
                .collect();
            running.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        });
        let beds: Vec<Settled> =
            dropped.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        step.done(&format!("{} beds", beds.len()));
        Ok(beds)
    }

    /// Whether beds can be dropped.
    pub fn is_recipe(&self) -> bool {
        matches!(self.scene.geometry, SceneGeometry::Packing(_))
    }

    /// The recipe with a lower cover.
    pub fn covered(&self, cover: f64) -> Scene {
        let mut scene = if self.is_shipped {
            Scene { seed: self.scene.seed, ..shipped::with_cover(cover) }
        } else {
            self.scene.clone()
        };
        if let SceneGeometry::Packing(packing) = &mut scene.geometry {
            packing.seed = self.scene.seed;
            if !self.is_shipped {
                for class in &mut packing.grains {
                    class.fines = crate::scene::Fines::Cover(Cover { silhouette: cover });
                }
            }
        }
        scene
    }

    fn drop(
        &self,
        blender: &blender::Blender,
        scene: &Scene,
        is_full: bool,
        monitor: &dyn Monitor,
    ) -> Result<Vec<Settled>, Error> {
        let SceneGeometry::Packing(packing) = &scene.geometry else {
            unreachable!("recipes are dropped")
        };
        let packing = Packing { seed: self.scene.seed, ..packing.clone() };
        let own_grains = OwnGrains::of(&packing, scene.folder())?;
        let seeds: Vec<u64> = (0..self.beds).map(|i| random::seed_of(packing.seed, i)).collect();
        let order = Order {
            blender,
            beds: Wanted::of_seeds(scene, &packing, own_grains.as_ref(), &seeds),
            of_first: &[],
            time_limit: self.time_limit,
        };
        let folder = Scratch::temporary()?;
        let log = |i: usize| folder.path().join(format!("{i}.log"));
        let made = order.beds(self.cache, &log, &Step::new(monitor, "drop"))?;
        made.iter()
            .map(|made| Settled::read(Scene::read(&made.folder.join("scene.json"))?, is_full))
            .collect()
    }
}

/// The beds as the model takes them, and the roles of their materials.
pub struct Traced {
    /// Beds of full cover, thinned.
    pub full: Vec<FullBed>,
    /// Beds dropped anew.
    pub fresh: Vec<Thinned>,
    /// The role of each material.
    pub roles: Vec<Role>,
    /// Share of the large fines of the recipe, by number.
    pub large_share: f64,
}

/// Traces beds with facets of these materials; `bands` are reflectances of each material.
pub fn trace(
    beds: &[Settled],
    materials: &[TableMaterial],
    bands: &[Vec<f64>],
    seed: u64,
    cache: &Cache,
    monitor: &dyn Monitor,
) -> Result<Traced, Error> {
    let by_angle = materials.iter().any(|m| m.spectrum.is_angular());
    let rules = rules(materials, by_angle, bands);
    let number = if by_angle { PATHS_BY_ANGLE } else { PATHS };
    let mut roles = None;
    let mut large_share = 0.0;
    let (mut full, mut fresh) = (Vec::new(), Vec::new());
    for (i, bed) in (0..).zip(beds) {
        let fines = if bed.is_full {
            let fines = Fines::of(bed.tracer.bed(), &bed.scene, seed)?;
            large_share = fines.large_share();
            roles = Some(fines.roles.clone());
            Some(fines)
        } else {
            None
        };
        let roles = roles.as_ref().expect("beds of full cover come first");
        let paths = Paths { rules: &rules, seed: random::seed_of(seed, i), number };
        let steps = steps(bed, fines.as_ref(), roles, paths, cache, monitor)?;
        match fines {
            Some(fines) => full.push(full_bed(steps, fines.large_share())),
            None => fresh.extend(steps),
        }
    }
    let found = roles.expect("there is a bed of full cover");
    Ok(Traced { full, fresh, roles: self::roles(materials, &found), large_share })
}

/// The steps of a bed of full cover; a fresh bed is its own only step.
fn steps(
    bed: &Settled,
    fines: Option<&Fines>,
    roles: &Roles,
    paths: Paths,
    cache: &Cache,
    monitor: &dyn Monitor,
) -> Result<Vec<Thinned>, Error> {
    let sum = bed.tracer.scene_sha256();
    let kept: Vec<[f64; 2]> = match fines {
        Some(fines) => kept(fines.large_share()),
        None => vec![[1.0; 2]],
    };
    let rules = format!("{:?}", paths.rules);
    let made_from = (program(), sum, &kept, paths.seed, paths.number, rules, fines.is_some());
    let made = cache.stage("thin", &made_from, |folder| {
        let (tracer, scene) = (&bed.tracer, &bed.scene);
        let steps = if let Some(fines) = fines {
            thinning::steps(tracer, scene, fines, paths, &kept, monitor)?
        } else {
            vec![thinning::traced(tracer, scene, roles, paths, [1.0; 2], monitor)?]
        };
        let text = serde_json::to_vec(&steps).expect("plain data");
        Ok(output::bytes(&folder.join(STEPS), &text)?)
    })?;
    let path = made.folder.join(STEPS);
    let read = std::fs::read(&path).and_then(|text| Ok(serde_json::from_slice(&text)?));
    Ok(read.map_err(|source| CacheError::Output(OutputError { path, source }))?)
}

/// The file of a bed's steps in the cache.
const STEPS: &str = "steps.json";

/// Shares of small and large fines that are left: the steps, then those with fewer large fines.
fn kept(large_share: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = KEPT.map(|share| [share; 2]).to_vec();
    if large_share > 0.0 {
        kept.extend(WITH_FEWER_LARGE.map(|share| [share, FEWER_LARGE * share]));
    }
    kept
}

/// Sorts the traced steps of a bed of full cover.
fn full_bed(mut steps: Vec<Thinned>, usual: f64) -> FullBed {
    let others = steps.split_off(KEPT.len());
    // Where grains have few fines, a step may have lost none.
    steps.dedup_by(|next, step| next.cover <= step.cover);
    let of = |step: Thinned| {
        let [small, large] = [(1.0 - usual) * step.kept[0], usual * step.kept[1]];
        (step, LargeShare { here: large / (small + large), usual })
    };
    FullBed { steps, fewer_large: others.into_iter().map(of).collect() }
}

/// The rules of a trace: what is recorded and where paths end depends on the facets.
fn rules(materials: &[TableMaterial], by_angle: bool, bands: &[Vec<f64>]) -> TracingRules {
    let facet =
        |m: &TableMaterial| Facet { specular: m.specular, by_angle: m.spectrum.is_angular() };
    let facets: Vec<Facet> = materials.iter().map(facet).collect();
    let kept = Kept { cosines: if by_angle { COSINES } else { 1 }, ..Kept::PLAIN };
    let greatest = |material: usize| {
        let of_bands = bands.iter().map(|band| band[material]).fold(0.0, f64::max);
        // At grazing incidence any mirror reflects all light.
        if facets[material].by_angle { 1.0 } else { of_bands }
    };
    let greatest: Vec<f64> = (0..materials.len())
        .flat_map(|material| vec![greatest(material); kept.of_material()])
        .collect();
    TracingRules { greatest, least_weight: LEAST_WEIGHT, ..TracingRules::of_facets(kept, facets) }
}

/// The role of each material. What has the fines' spectrum, as the floor of shipped scenes, counts
/// as fines.
fn roles(materials: &[TableMaterial], found: &Roles) -> Vec<Role> {
    let is_fines = |m: usize| found.fines.contains(&(m as u16));
    let of = |m: usize| {
        let alike = |other: &usize| materials[*other].spectrum == materials[m].spectrum;
        if found.grains.contains(&(m as u16)) {
            Role::Grains
        } else if is_fines(m) || (0..materials.len()).filter(|i| is_fines(*i)).any(|i| alike(&i)) {
            Role::Fines
        } else {
            Role::Other
        }
    };
    (0..materials.len()).map(of).collect()
}

/// The covers that the beds reach.
pub fn covers(traced: &Traced) -> [f64; 2] {
    Soil::covers(&traced.full)
}

/// The roles of materials before anything is traced.
pub fn found(beds: &[Settled], seed: u64) -> Result<Roles, Error> {
    let first = beds.first().expect("there is a bed of full cover");
    Ok(Fines::of(first.tracer.bed(), &first.scene, seed)?.roles)
}
