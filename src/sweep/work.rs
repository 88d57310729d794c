//! The beds of a study, dropped and traced in batches on all cores.

use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::Options;
use super::bed::{BEDS, Bed, FAILED, FailedBed, SIGNATURE, failure, failure_of, folder_of};
use super::points::Points;
use super::study::{Keep, Study};
use crate::beds::own_grains::OwnGrains;
use crate::beds::{Failed, Order, Wanted};
use crate::blender::Blender;
use crate::pipeline::{self, Bed as Traced, TABLE};
use crate::radiometry::Assumed;
use crate::scene::{Packing, Scene, SceneGeometry};
use crate::signature;
use crate::signature::budget::Budget;
use crate::support::cache::Made;
use crate::support::error::{Error, Status};
use crate::support::monitor::{Interrupted, Silently, Step};
use crate::support::output::{self, OutputError};
use crate::support::scratch::{self, Scratch};
use crate::table::{Prepared, Table, Target};
use crate::tracer::trace::Request;

/// Beds that one Blender drops: at most so many, since their tables are made when all are dropped;
/// at least so many, since a start of Blender takes as long as a small bed.
const OF_BATCH: [usize; 2] = [4, 32];

/// The work on a study.
pub(super) struct Work<'a> {
    options: &'a Options<'a>,
    study: &'a Study,
    points: &'a Points,
    blender: Option<&'a Blender>,
    target: Target,
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
fn recipe(scene: &Scene) -> Option<&Packing> {
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
            for file in scene.files().iter().flat_map(|file| crate::spectrum::format::files(file)) {
                let sum = output::sha256_hex(&file)?;
                self.files.insert(file, sum);
            }
            let prepared = Prepared::new(scene.clone(), &self.study.bands.wavelengths_um())?;
            self.prepared.insert(light, prepared);
        }
        let Some(packing) = recipe(scene) else {
            let sources = crate::geometry::ingest::Sources::read(scene)?;
            for file in sources
                .files()
                .keys()
                .filter(|file| !self.files.contains_key(*file))
                .cloned()
                .collect::<Vec<_>>()
            {
                let sum = output::sha256_hex(&file)?;
                self.files.insert(file, sum);
            }
            return Ok(());
        };
        let library = of_library(packing);
        if !self.own_grains.contains_key(&library) {
            let own_grains = OwnGrains::of(packing, scene.folder())?;
            for file in own_grains.iter().flat_map(OwnGrains::files) {
                let sum = output::sha256_hex(&file)?;
                self.files.insert(file, sum);
            }
            self.own_grains.insert(library, own_grains);
        }
        Ok(())
    }

    fn prepared(&self, scene: Scene) -> Prepared {
        self.prepared[&of_light(&scene)].with(scene)
    }

    fn order<'b>(&'b self, scenes: impl Iterator<Item = &'b Scene>) -> Order<'b> {
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

    /// Drops some beds in one Blender, and traces all that depend on them.
    fn batch(&self, mut drops: Vec<Vec<usize>>, tell: &dyn Fn(bool)) -> Result<(), Error> {
        let scene_of = |bed: usize| {
            let Bed { point, seed, .. } = self.beds[bed];
            self.points.scene(point, seed)
        };
        let mut made: Vec<Option<Made>> = Vec::new();
        let mut settled = Vec::new();
        let is_recipe = recipe(&scene_of(drops[0][0])?).is_some();
        while is_recipe && !drops.is_empty() {
            let scenes: Vec<Scene> =
                drops.iter().map(|drop| scene_of(drop[0])).collect::<Result<_, _>>()?;
            let order = self.order(scenes.iter());
            let silent = Silently(self.options.monitor);
            // It stays where one of the beds fails, and is named in its reason.
            let name = format!("{}.log", self.beds[drops[0][0]].id);
            let log = |_| self.options.out.join(FAILED).join(&name);
            let dropped = order.beds(self.options.cache, &log, &Step::new(&silent, "drop"));
            let found = match dropped {
                Ok(found) => found.into_iter().map(Some).collect(),
                Err(Failed { error, .. }) if is_of_all(&error) => return Err(error),
                Err(Failed { error, .. }) => {
                    let found = order.found(self.options.cache)?;
                    let Some(at) = found.iter().position(Option::is_none) else { continue };
                    for bed in drops.remove(at) {
                        self.fail(&self.beds[bed], &error)?;
                        tell(true);
                    }
                    // Those before it are settled; the others are tried again.
                    let rest = drops.split_off(at);
                    let found = found.into_iter().take(at).collect::<Vec<_>>();
                    made.extend(found);
                    settled.append(&mut drops);
                    drops = rest;
                    continue;
                }
            };
            made.extend::<Vec<_>>(found);
            settled.append(&mut drops);
        }
        if !is_recipe {
            made = drops.iter().map(|_| None).collect();
            settled = drops;
        }
        for (drop, made) in settled.iter().zip(&made) {
            for &bed in drop {
                self.options.monitor.check()?;
                let scene = scene_of(bed)?;
                match self.trace(&self.beds[bed], scene, made.as_ref()) {
                    Ok(()) => tell(false),
                    Err(error) if is_of_all(&error) => return Err(error),
                    Err(error) => {
                        self.fail(&self.beds[bed], &error)?;
                        tell(true);
                    }
                }
            }
        }
        Ok(())
    }

    /// Traces a bed, and puts what is kept of it into its place.
    fn trace(&self, bed: &Bed, scene: Scene, made: Option<&Made>) -> Result<(), Error> {
        let Options { out, cache, monitor, .. } = *self.options;
        let work = Scratch::temporary()?;
        let copied = |from: &Path, name: &str| {
            let to = work.path().join(name);
            fs::copy(from, &to).map_err(|source| OutputError { path: to, source })?;
            Ok(())
        };
        let mut prepared = self.prepared(scene);
        if let Some(made) = made {
            let recipe = recipe(&prepared.scene).expect("it was dropped").clone();
            for file in made.files.iter().filter(|file| *file != SCENE) {
                copied(&made.folder.join(file), file)?;
            }
            let origin = recipe.origin();
            let settled = pipeline::Settled { made, file: SCENE, origin, drop: None, number: 0 };
            let mut placed =
                settled.placed(&prepared.scene, &mut |from, name| copied(from, name))?;
            placed.file = work.path().join(SCENE);
            output::scratch(&placed.file, pipeline::file_text(&placed))?;
            prepared.scene = placed;
        }
        let (grid, silent) = (&self.study.bands, Silently(monitor));
        let request = Request::new(grid, self.target);
        let table = Traced::new(prepared).table(request, cache, &silent)?;
        let new = scratch::beside(&out.join(BEDS))?;
        let keep = |from: &Path, name: &str| {
            let to = new.path().join(name);
            fs::copy(from, &to).map_err(|source| OutputError { path: to, source })
        };
        keep(&table.folder.join(TABLE), TABLE)?;
        if self.study.keep >= Keep::Signatures {
            let text = signature_text(&new.path().join(TABLE), &grid.wavelengths_um())?;
            output::scratch(&new.path().join(SIGNATURE), text)?;
        }
        if self.study.keep >= Keep::Beds {
            for name in output::list(work.path())?.iter().filter(|name| !name.starts_with('.')) {
                keep(&work.path().join(name), name)?;
            }
        }
        output::sync_all_in(new.path())?;
        let place = out.join(folder_of(&bed.id));
        output::folder(place.parent().expect("it is in a folder"))?;
        match fs::rename(new.path(), &place) {
            // Another process was first; its bed is the same.
            Err(_) if place.is_dir() => {}
            Err(source) => return Err(OutputError { path: place, source }.into()),
            Ok(()) => {}
        }
        output::remove(&out.join(failure_of(&bed.id)))?;
        Ok(())
    }

    fn fail(&self, bed: &Bed, error: &Error) -> Result<(), Error> {
        // Paths below the results hold for whoever has these.
        let out = format!("{}/", self.options.out.display());
        let below = |text: String| text.replace(&out, "");
        let failed = FailedBed {
            status: error.status() as u8,
            reason: below(error.to_string()),
            hint: error.hint().map(below),
        };
        let text = serde_json::to_vec_pretty(&failed).expect("plain data");
        Ok(output::bytes(&self.options.out.join(failure_of(&bed.id)), &text)?)
    }
}

/// The scene file of a bed.
const SCENE: &str = "scene.json";

/// Whether an error is none of the bed: the next bed would meet it as well.
fn is_of_all(error: &Error) -> bool {
    use Status::{BlenderMissing, BlenderNumpy, BlenderVersion, Files, Interrupted, Usage};
    [BlenderMissing, BlenderNumpy, BlenderVersion, Files, Interrupted, Usage]
        .contains(&error.status())
}

fn signature_text(table: &Path, um: &[f64]) -> Result<String, Error> {
    let tables = [Table::read(table)?];
    let bands = signature::evaluate(&tables, um)?;
    let budget = Budget::new(&tables, &bands)?;
    Ok(signature::csv_text(&bands, &budget, tables[0].temperature(), Assumed::EXACT))
}
