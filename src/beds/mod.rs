//! Beds of one recipe, a packing for each seed: from the cache, or dropped by as many Blenders side by
//! side as there are threads.

pub mod own_grains;
mod solid;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use serde::Serialize;

use crate::beds::own_grains::Library;
use crate::blender::{self, Blender, Event, Job, Version};
use crate::scene::{Packing, Scene, SceneGeometry};
use crate::support::cache::{Cache, CacheError, Made};
use crate::support::error::Error;
use crate::support::monitor::{Monitor, Step};
use crate::support::output::{self, OutputError};

/// Name of a stage in the cache.
const STAGE: &str = "drop";

/// Folder of the user's grains beside the recipe that Blender gets.
const LIBRARY: &str = "library";

/// What is to be dropped.
pub struct Order<'a> {
    /// The Blender that drops it.
    pub blender: &'a Blender,
    /// The scene.
    pub scene: &'a Scene,
    /// Its recipe.
    pub packing: &'a Packing,
    /// The user's grains, if the recipe has any.
    pub library: Option<&'a Library>,
    /// A seed for each packing.
    pub seeds: &'a [u64],
    /// Further files, of the first packing alone: `scene.glb`, `scene.blend`, `frames.json`, `patch.obj`.
    pub of_first: &'a [&'a str],
    /// Longest that a Blender may take.
    pub time_limit: Duration,
}

/// All that a bed depends on.
#[derive(Serialize)]
struct MadeFrom<'a> {
    packing: Packing,
    /// SHA-256 of the grains of the library.
    library: Option<&'a BTreeMap<String, String>>,
    materials: Vec<&'a str>,
    blender: Version,
    python: &'a str,
    numpy: &'a str,
    scripts: String,
    extra: &'a [&'a str],
}

impl Order<'_> {
    /// The folders of the beds, in the order of the seeds. Beds that are not in the cache are dropped; what a
    /// Blender says is logged at `log` of the first packing that it has to make.
    pub fn beds(
        &self,
        cache: &Cache,
        log: &(dyn Fn(usize) -> PathBuf + Sync),
        step: &Step,
    ) -> Result<Vec<Made>, Error> {
        let inputs: Vec<MadeFrom> = (0..self.seeds.len()).map(|i| self.made_from(i)).collect();
        let beds =
            || inputs.iter().map(|inputs| cache.look(STAGE, inputs)).collect::<Result<Vec<_>, _>>();
        let found = beds()?;
        let missing: Vec<usize> = (0..found.len()).filter(|&i| found[i].is_none()).collect();
        let blenders = rayon::current_num_threads().min(missing.len());
        let done = AtomicU64::new(0);
        let results: Vec<Result<(), Error>> = std::thread::scope(|scope| {
            let running: Vec<_> = (0..blenders)
                .map(|first| {
                    let lot: Vec<usize> =
                        missing.iter().copied().skip(first).step_by(blenders).collect();
                    let (inputs, done, total) = (&inputs, &done, missing.len() as u64);
                    scope.spawn(move || {
                        let on_event = |event: &Event| tell(event, done, total, step);
                        self.make(&lot, inputs, cache, &log(lot[0]), step.monitor, &on_event)
                    })
                })
                .collect();
            running.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        });
        results.into_iter().collect::<Result<(), Error>>()?;
        let made = beds()?.into_iter().zip(&found);
        made.map(|(made, before)| {
            let made = made.ok_or_else(|| {
                let source =
                    std::io::Error::other("a bed vanished from the cache while it was used");
                CacheError(OutputError { path: cache.root().to_owned(), source })
            })?;
            Ok(Made { cached: before.is_some(), ..made })
        })
        .collect()
    }

    fn extra(&self, packing: usize) -> &[&str] {
        if packing == 0 { self.of_first } else { &[] }
    }

    fn made_from(&self, packing: usize) -> MadeFrom<'_> {
        MadeFrom {
            packing: Packing { seed: self.seeds[packing], library: None, ..self.packing.clone() },
            library: self.library.map(Library::sha256),
            materials: self.scene.materials.iter().map(|m| m.name.as_str()).collect(),
            blender: self.blender.version,
            python: &self.blender.python,
            numpy: &self.blender.numpy,
            scripts: blender::scripts_sha256(),
            extra: self.extra(packing),
        }
    }

    /// Drops a lot of packings in one Blender. Those that were made before it failed are kept.
    fn make(
        &self,
        lot: &[usize],
        inputs: &[MadeFrom],
        cache: &Cache,
        log: &Path,
        monitor: &dyn Monitor,
        on_event: &dyn Fn(&Event),
    ) -> Result<(), Error> {
        let scratch = cache.scratch()?;
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| CacheError(OutputError { path, source })
        };
        let recipe = scratch.path().join("recipe.json");
        let mut scene = self.scene.clone();
        if let (Some(library), SceneGeometry::Packing(packing)) =
            (self.library, &mut scene.geometry)
        {
            library.copy_to(&scratch.path().join(LIBRARY))?;
            packing.library = Some(LIBRARY.into());
        }
        output::bytes(&recipe, &serde_json::to_vec(&scene).expect("plain data"))?;
        let mut args: Vec<OsString> = vec!["--scene".into(), recipe.into()];
        for &packing in lot {
            args.extend(["--bed".into(), self.seeds[packing].to_string().into()]);
        }
        for file in self.extra(lot[0]) {
            args.extend(["--also".into(), file.into()]);
        }
        let job = Job {
            script: "drop.py",
            args,
            out: scratch.path(),
            log,
            time_limit: self.time_limit * lot.len() as u32,
            monitor,
        };
        let finished = self.blender.run(&job, &mut |event| on_event(event));
        for &packing in lot {
            let made = scratch.path().join(self.seeds[packing].to_string());
            if !made.is_dir() {
                continue;
            }
            cache.stage(STAGE, &inputs[packing], |folder| {
                for file in output::list(&made)? {
                    let from = made.join(&file);
                    fs::rename(&from, folder.join(&file)).map_err(failed(&from))?;
                }
                Ok(output::copy(log, &folder.join("blender.log"))?)
            })?;
        }
        finished?;
        Ok(())
    }
}

/// Shows how a Blender gets on: a single packing by its stages, several by how many are done.
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
