//! Beds of recipes: taken from the cache, or dropped by several Blenders in parallel, one for each
//! thread.

pub mod own_grains;
#[cfg(feature = "scans")]
pub mod scan;
mod solid;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use serde::Serialize;

use crate::beds::own_grains::OwnGrains;
use crate::blender::{self, Blender, BlenderError, Event, Job, Version};
use crate::scene::{Packing, Scene, SceneGeometry};
use crate::support::cache::{Cache, CacheError, Made};
use crate::support::error::Error;
use crate::support::monitor::{Monitor, Step};
use crate::support::output::{self, OutputError};

/// Name of a stage in the cache.
const STAGE: &str = "drop";

/// The scene where the hulls of a bed rested, beside that of a bed whose fines touch. Both are of one
/// drop: it is the bed that hulls alone give with the same seed.
pub const HULLS: &str = "hulls.json";

/// Begin of the names of folders of the user's grains beside the recipes that Blender gets.
const OWN_GRAINS: &str = "own_grains";

/// A bed that is wanted.
pub struct Wanted<'a> {
    /// The scene of its recipe.
    pub scene: &'a Scene,
    /// The recipe, with the seed of this bed.
    pub packing: Packing,
    /// The user's grains, if the recipe has any.
    pub own_grains: Option<&'a OwnGrains>,
}

impl<'a> Wanted<'a> {
    /// Beds of one recipe, one for each seed.
    pub fn of_seeds(
        scene: &'a Scene,
        packing: &Packing,
        own_grains: Option<&'a OwnGrains>,
        seeds: &[u64],
    ) -> Vec<Self> {
        let of = |&seed| Self { scene, packing: Packing { seed, ..packing.clone() }, own_grains };
        seeds.iter().map(of).collect()
    }
}

/// The beds that are wanted.
pub struct Order<'a> {
    /// The Blender that drops the grains.
    pub blender: &'a Blender,
    /// The beds.
    pub beds: Vec<Wanted<'a>>,
    /// Further files of the first bed: `scene.glb`, `scene.blend`, `frames.json`, `patch.obj`.
    pub of_first: &'a [&'a str],
    /// Time limit for each bed.
    pub time_limit: Duration,
}

/// Why an order was not carried out.
pub struct Failed {
    /// The bed of the order that Blender refused, if that is why.
    pub bed: Option<usize>,
    /// The failure.
    pub error: Error,
}

impl From<Error> for Failed {
    fn from(error: Error) -> Self {
        Self { bed: None, error }
    }
}

impl From<Failed> for Error {
    fn from(failed: Failed) -> Self {
        failed.error
    }
}

/// Everything that a bed depends on.
#[derive(Serialize)]
pub struct MadeFrom<'a> {
    packing: Packing,
    /// SHA-256 of the user's grains.
    own_grains: Option<&'a BTreeMap<String, String>>,
    materials: Vec<&'a str>,
    blender: Version,
    python: &'a str,
    numpy: &'a str,
    scripts: String,
    extra: &'a [&'a str],
}

impl Order<'_> {
    /// The folders of the beds that are in the cache.
    pub fn found(&self, cache: &Cache) -> Result<Vec<Option<Made>>, Error> {
        (0..self.beds.len()).map(|bed| cache.look(STAGE, &self.made_from(bed))).collect()
    }

    /// The folders of the beds in their order. Drops the beds that are not in the cache. Each
    /// Blender writes its output to `log` of the first bed that it makes, which is removed after a
    /// success. If one fails the others are stopped. Finished beds stay in the cache.
    pub fn beds(
        &self,
        cache: &Cache,
        log: &(dyn Fn(usize) -> PathBuf + Sync),
        step: &Step,
    ) -> Result<Vec<Made>, Failed> {
        let found = self.found(cache)?;
        let missing: Vec<usize> = (0..found.len()).filter(|&i| found[i].is_none()).collect();
        let lots = self.lots(&missing, rayon::current_num_threads());
        let done = AtomicU64::new(0);
        let monitor = OneForAll { monitor: step.monitor, failed: AtomicBool::new(false) };
        let results: Vec<Result<(), Failed>> = std::thread::scope(|scope| {
            let running: Vec<_> = lots
                .iter()
                .map(|lot| {
                    let (done, total) = (&done, missing.len() as u64);
                    let monitor = &monitor;
                    scope.spawn(move || {
                        let on_event = |event: &Event| tell(event, done, total, step);
                        let made = self.make(lot, cache, &log(lot[0]), monitor, &on_event);
                        if made.is_err() {
                            monitor.failed.store(true, Ordering::Relaxed);
                        }
                        made
                    })
                })
                .collect();
            running.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        });
        // That one failed is why the others were interrupted.
        let mut failures: Vec<Failed> = results.into_iter().filter_map(Result::err).collect();
        failures.sort_by_key(|failed| failed.error.is_interruption());
        if let Some(failed) = failures.into_iter().next() {
            return Err(failed);
        }
        let made = self.found(cache)?.into_iter().zip(&found);
        made.map(|(made, before)| {
            let made = made.ok_or_else(|| {
                let removed = io::Error::other("a bed was removed from the cache during use");
                Error::from(failed(cache.root())(removed))
            })?;
            Ok(Made { cached: before.is_some(), ..made })
        })
        .collect()
    }

    /// The beds of each Blender, in their order: the dearest are given out first, each to the
    /// Blender that has least to do.
    fn lots(&self, beds: &[usize], blenders: usize) -> Vec<Vec<usize>> {
        let cost = |bed: usize| self.beds[bed].packing.drop.collision.cost();
        let mut order = beds.to_vec();
        order.sort_by(|&a, &b| cost(b).total_cmp(&cost(a)));
        let mut lots = vec![(0.0_f64, Vec::new()); blenders.min(beds.len())];
        for bed in order {
            let least = lots.iter_mut().min_by(|(a, _), (b, _)| a.total_cmp(b));
            let (sum, lot) = least.expect("there is a bed, so there is a lot");
            *sum += cost(bed);
            lot.push(bed);
        }
        lots.into_iter()
            .map(|(_, mut lot)| {
                lot.sort_unstable();
                lot
            })
            .collect()
    }

    fn extra(&self, bed: usize) -> &[&str] {
        if bed == 0 { self.of_first } else { &[] }
    }

    /// All that a bed depends on.
    pub fn made_from(&self, bed: usize) -> MadeFrom<'_> {
        let Wanted { scene, packing, own_grains } = &self.beds[bed];
        MadeFrom {
            packing: Packing { library: None, ..packing.clone() },
            own_grains: own_grains.map(OwnGrains::sha256),
            materials: scene.materials.iter().map(|m| m.name.as_str()).collect(),
            blender: self.blender.version,
            python: &self.blender.python,
            numpy: &self.blender.numpy,
            scripts: blender::scripts_sha256(),
            extra: self.extra(bed),
        }
    }

    /// Writes the recipe of a bed for Blender.
    fn write_recipe(&self, bed: usize, folder: &Path) -> Result<PathBuf, Error> {
        let Wanted { scene, packing, own_grains } = &self.beds[bed];
        let mut packing = packing.clone();
        if let Some(own_grains) = own_grains {
            // Beds of the same grains have one copy of them.
            let same =
                |other: &Wanted| other.own_grains.is_some_and(|o| std::ptr::eq(o, *own_grains));
            let first = self.beds.iter().position(same).unwrap_or(bed);
            let library = format!("{OWN_GRAINS}_{first}");
            if !folder.join(&library).is_dir() {
                own_grains.copy_to(&folder.join(&library))?;
            }
            packing.library = Some(library.into());
        }
        let scene = Scene { geometry: SceneGeometry::Packing(packing), ..(*scene).clone() };
        let path = folder.join(format!("{bed}.json"));
        output::scratch(&path, serde_json::to_vec(&scene).expect("plain data"))
            .map_err(CacheError::Output)?;
        Ok(path)
    }

    /// Drops some beds in one Blender. If it fails, the finished beds are kept.
    fn make(
        &self,
        lot: &[usize],
        cache: &Cache,
        log: &Path,
        monitor: &dyn Monitor,
        on_event: &dyn Fn(&Event),
    ) -> Result<(), Failed> {
        let scratch = cache.scratch()?;
        let mut args: Vec<OsString> = Vec::new();
        for &bed in lot {
            args.extend(["--scene".into(), self.write_recipe(bed, scratch.path())?.into()]);
        }
        for file in self.extra(lot[0]) {
            args.extend(["--also".into(), file.into()]);
        }
        let job = Job {
            script: "drop.py",
            args,
            out: scratch.path(),
            log,
            time_limit: self.time_limit.saturating_mul(lot.len() as u32),
            monitor,
        };
        // Each bed goes into the cache when it is whole: what is killed later does not lose it.
        let mut left = lot.iter().copied().peekable();
        let mut kept = Ok(());
        let mut keep = || -> Result<(), Error> {
            while let Some(&bed) = left.peek() {
                let made = scratch.path().join(bed.to_string());
                if !made.is_dir() {
                    break;
                }
                cache.stage(STAGE, &self.made_from(bed), |folder| {
                    for file in output::list(&made)? {
                        let (from, to) = (made.join(&file), folder.join(&file));
                        let linked = fs::hard_link(&from, &to);
                        linked
                            .or_else(|_| fs::copy(&from, &to).map(|_| ()))
                            .map_err(failed(&from))?;
                    }
                    Ok(output::copy(log, &folder.join("blender.log"))?)
                })?;
                left.next();
            }
            Ok(())
        };
        let finished = self.blender.run(&job, &mut |event| {
            if matches!(event, Event::Progress { stage, .. } if stage == "bed") && kept.is_ok() {
                kept = keep();
            }
            on_event(event);
        });
        kept?;
        keep()?;
        if matches!(finished, Ok(_) | Err(BlenderError::Interrupted)) {
            output::remove(log).map_err(Error::from)?;
        }
        match (finished, left.peek()) {
            (Ok(_), _) => Ok(()),
            (Err(error), next) => {
                let bed = next.filter(|_| matches!(error, BlenderError::Refused { .. })).copied();
                Err(Failed { bed, error: error.into() })
            }
        }
    }
}

fn failed(path: &Path) -> impl FnOnce(io::Error) -> CacheError {
    let path = path.to_owned();
    move |source| CacheError::Output(OutputError { path, source })
}

/// Several Blenders: what stops one stops all, be it the user or the failure of another.
struct OneForAll<'a> {
    monitor: &'a dyn Monitor,
    failed: AtomicBool,
}

impl Monitor for OneForAll<'_> {
    fn begin(&self, step: &str) {
        self.monitor.begin(step);
    }

    fn at(&self, done: u64, total: u64, what: &str) {
        self.monitor.at(done, total, what);
    }

    fn say(&self, text: &str) {
        self.monitor.say(text);
    }

    fn end(&self, step: &str, seconds: f64, note: &str) {
        self.monitor.end(step, seconds, note);
    }

    fn is_cancelled(&self) -> bool {
        self.failed.load(Ordering::Relaxed) || self.monitor.is_cancelled()
    }
}

/// Shows the progress: the stages of a single packing, or the number of finished packings.
fn tell(event: &Event, done: &AtomicU64, total: u64, step: &Step) {
    match event {
        Event::Progress { stage, .. } if stage == "bed" => {
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            if total > 1 {
                step.monitor.at(done, total, "packings");
            }
        }
        Event::Progress { stage, done, total: steps } if total == 1 => {
            step.monitor.at(*done, *steps, stage);
        }
        Event::Warning { message } => step.monitor.say(&format!("warning: {message}")),
        _ => {}
    }
}
