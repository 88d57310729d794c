//! The beds of a study: what they need, and their batches on all cores.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::Options;
use super::bed::{BEDS, Bed, FAILED, failure, folder_of};
use super::points::Points;
use super::study::Study;
use crate::beds::own_grains::OwnGrains;
use crate::beds::{Order, Wanted};
use crate::blender::Blender;
use crate::pipeline;
use crate::scene::{Packing, Scene, SceneGeometry};
use crate::support::error::Error;
use crate::support::monitor::{Interrupted, Step};
use crate::support::output;
use crate::table::{Prepared, Target};

/// Beds that one Blender drops: at most so many, since their tables are made when all are dropped;
/// at least so many, since a start of Blender takes as long as a small bed.
const OF_BATCH: [usize; 2] = [4, 32];

/// The work on a study.
pub(super) struct Work<'a> {
    pub(super) options: &'a Options<'a>,
    pub(super) study: &'a Study,
    pub(super) points: &'a Points,
    blender: Option<&'a Blender>,
    pub(super) target: Target,
    /// Scenes whose materials and sky are alike have theirs in common.
    prepared: BTreeMap<String, Prepared>,
    /// Grains of the user's own, by folder and names.
    own_grains: BTreeMap<String, Option<OwnGrains>>,
    /// Files that the scenes name.
    pub(super) files: BTreeMap<PathBuf, String>,
    pub(super) beds: Vec<Bed>,
    /// Beds of the same drop, in the order of the study.
    drops: Vec<Vec<usize>>,
}

/// A recipe's part of a scene.
pub(super) fn recipe(scene: &Scene) -> Option<&Packing> {
    match &scene.geometry {
        SceneGeometry::Packing(packing) => Some(packing),
        SceneGeometry::Placed(_) => None,
    }
}

fn text(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("plain data")
}

/// Scenes with this text in common have the same materials, sky and atmosphere.
fn of_light(scene: &Scene) -> String {
    let mut value = serde_json::to_value(scene).expect("plain data");
    let keys = value.as_object_mut().expect("a scene has keys");
    for key in ["name", "description", "seed", "view", "sensor", "geometry"] {
        keys.remove(key);
    }
    let floor = match &scene.geometry {
        SceneGeometry::Packing(packing) => text(&packing.floor_material),
        SceneGeometry::Placed(placed) => text(&placed.domain),
    };
    value.to_string() + &floor
}

fn of_library(packing: &Packing) -> String {
    text(&(&packing.library, packing.shapes().map(|(_, shape, _)| shape).collect::<Vec<_>>()))
}

impl<'a> Work<'a> {
    /// Checks the scenes of all points. Whatever is wrong with one is known before any work.
    pub(super) fn of(
        options: &'a Options,
        study: &'a Study,
        points: &'a Points,
        blender: Option<&'a Blender>,
    ) -> Result<Self, Error> {
        let target = Target {
            max_paths: study.max_paths,
            ..pipeline::target_of(study.tolerance, study.seeds.len())
        };
        let mut work = Self {
            options,
            study,
            points,
            blender,
            target,
            prepared: BTreeMap::new(),
            own_grains: BTreeMap::new(),
            files: BTreeMap::new(),
            beds: Vec::new(),
            drops: Vec::new(),
        };
        let mut drops: BTreeMap<String, usize> = BTreeMap::new();
        for point in 0..points.len() {
            options.monitor.check()?;
            for &seed in &study.seeds {
                let scene = points.scene(point, seed)?;
                work.prepare(&scene)?;
                let (id, drop) = work.identities(&scene)?;
                let bed = work.beds.len();
                work.beds.push(Bed { point, seed, id });
                let drop = *drops.entry(drop).or_insert_with(|| {
                    work.drops.push(Vec::new());
                    work.drops.len() - 1
                });
                work.drops[drop].push(bed);
            }
        }
        Ok(work)
    }

    /// Reads what a scene names, unless a scene before named the same.
    fn prepare(&mut self, scene: &Scene) -> Result<(), Error> {
        let light = of_light(scene);
        if !self.prepared.contains_key(&light) {
            let files = scene.files();
            self.sum(files.iter().flat_map(|file| crate::spectrum::format::files(file)))?;
            let prepared = Prepared::new(scene.clone(), &self.study.bands.wavelengths_um())?;
            self.prepared.insert(light, prepared);
        }
        let Some(packing) = recipe(scene) else {
            let sources = crate::geometry::ingest::Sources::read(scene)?;
            self.sum(sources.files().keys().cloned())?;
            return Ok(());
        };
        let library = of_library(packing);
        if !self.own_grains.contains_key(&library) {
            let own_grains = OwnGrains::of(packing, scene.folder())?;
            self.sum(own_grains.iter().flat_map(OwnGrains::files))?;
            self.own_grains.insert(library, own_grains);
        }
        Ok(())
    }

    /// Takes the SHA-256 of files that are not known yet.
    fn sum(&mut self, files: impl Iterator<Item = PathBuf>) -> Result<(), Error> {
        for file in files {
            if let Entry::Vacant(new) = self.files.entry(file) {
                let sum = output::sha256_hex(new.key())?;
                new.insert(sum);
            }
        }
        Ok(())
    }

    pub(super) fn prepared(&self, scene: Scene) -> Prepared {
        self.prepared[&of_light(&scene)].with(scene)
    }

    pub(super) fn order<'b>(&'b self, scenes: impl Iterator<Item = &'b Scene>) -> Order<'b> {
        let wanted = |scene: &'b Scene| {
            let packing = recipe(scene).expect("recipes are dropped").clone();
            let own_grains = self.own_grains[&of_library(&packing)].as_ref();
            Wanted { scene, packing, own_grains }
        };
        Order {
            blender: self.blender.expect("recipes have one"),
            beds: scenes.map(wanted).collect(),
            of_first: &[],
            time_limit: Duration::from_secs(self.options.blender_timeout_s),
        }
    }

    /// What identifies a bed, and what identifies its drop.
    fn identities(&self, scene: &Scene) -> Result<(String, String), Error> {
        let drop = match recipe(scene) {
            Some(_) => text(&self.order([scene].into_iter()).made_from(0)),
            None => crate::geometry::ingest::Sources::read(scene)?.sha256()?,
        };
        let prepared = &self.prepared[&of_light(scene)];
        let of = (&prepared.materials[..], &*prepared.air, &self.study.bands, &self.target);
        let all = (env!("CARGO_PKG_VERSION"), &drop, scene, of, self.study.keep);
        let id = output::hex(&Sha256::digest(text(&all))[..12]);
        Ok((id, output::hex(&Sha256::digest(drop))))
    }

    /// Whether nothing is left to do for a bed.
    fn is_done(&self, bed: &Bed) -> bool {
        let out = self.options.out;
        out.join(folder_of(&bed.id)).is_dir()
            || failure(out, &bed.id).is_some_and(|failed| !failed.may_pass())
    }

    /// Drops and traces the beds of a part of the study that are not there yet.
    pub(super) fn run(&self) -> Result<(), Error> {
        let (part, parts) = self.options.part.unwrap_or((1, 1));
        let number = self.drops.len();
        let edge = |part: usize| number * part / parts;
        let mut missing: VecDeque<Vec<usize>> = VecDeque::new();
        for drop in &self.drops[edge(part - 1)..edge(part)] {
            let of_drop = drop.iter().copied().filter(|&bed| !self.is_done(&self.beds[bed]));
            let of_drop: Vec<usize> = of_drop.collect();
            if !of_drop.is_empty() {
                missing.push_back(of_drop);
            }
        }
        let total: usize = missing.iter().map(Vec::len).sum();
        if total == 0 {
            return Ok(());
        }
        output::folder(&self.options.out.join(BEDS))?;
        let step = Step::new(self.options.monitor, "sweep");
        step.monitor.at(0, total as u64, "beds");
        let workers = rayon::current_num_threads().min(missing.len());
        let done = AtomicU64::new(0);
        let failed = AtomicU64::new(0);
        let queue = Mutex::new(missing);
        let stop = Mutex::new(None);
        std::thread::scope(|scope| {
            for _ in 0..workers {
                let (queue, stop, done, failed, step) = (&queue, &stop, &done, &failed, &step);
                scope.spawn(move || {
                    // A thread of its own for each worker: Blender has one too.
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
                    let work = || {
                        while let Some(batch) = self.next(queue, stop, workers) {
                            let tell = |is_failed: bool| {
                                failed.fetch_add(u64::from(is_failed), Ordering::Relaxed);
                                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                                let text = match failed.load(Ordering::Relaxed) {
                                    0 => "beds".to_owned(),
                                    n => format!("beds, {n} failed"),
                                };
                                step.monitor.at(done, total as u64, &text);
                            };
                            if let Err(error) = self.batch(batch, &tell) {
                                let mut stop = stop.lock().unwrap_or_else(PoisonError::into_inner);
                                stop.get_or_insert(error);
                            }
                        }
                    };
                    match pool {
                        Ok(pool) => pool.install(work),
                        Err(_) => work(),
                    }
                });
            }
        });
        // It stays if there is a failure in it.
        let _ = fs::remove_dir(self.options.out.join(FAILED));
        if let Some(error) = stop.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        let note = match failed.into_inner() {
            0 => format!("{total} beds"),
            n => format!("{total} beds, {n} failed"),
        };
        step.done(&note);
        Ok(())
    }

    /// The next batch: at the end of the work smaller ones, so that no core waits long.
    fn next(
        &self,
        queue: &Mutex<VecDeque<Vec<usize>>>,
        stop: &Mutex<Option<Error>>,
        workers: usize,
    ) -> Option<Vec<Vec<usize>>> {
        let is_stopped = stop.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        if is_stopped || self.options.monitor.is_cancelled() {
            let mut stop = stop.lock().unwrap_or_else(PoisonError::into_inner);
            stop.get_or_insert(Interrupted.into());
            return None;
        }
        let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
        let [least, most] = OF_BATCH;
        let number = (2 * queue.len()).div_ceil(3 * workers).clamp(least, most);
        let number = number.min(queue.len());
        let batch: Vec<_> = queue.drain(..number).collect();
        (!batch.is_empty()).then_some(batch)
    }
}
