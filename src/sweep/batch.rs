//! A batch of beds: dropped by one Blender, traced, and each put into its place.

use std::fs;
use std::path::Path;

use super::Options;
use super::bed::{BEDS, Bed, FAILED, FailedBed, SIGNATURE, failure_of, folder_of};
use super::study::Keep;
use super::work::{Work, recipe};
use crate::beds::Failed;
use crate::pipeline::{self, Bed as Traced, TABLE};
use crate::radiometry::Assumed;
use crate::scene::Scene;
use crate::signature;
use crate::signature::budget::Budget;
use crate::support::cache::Made;
use crate::support::error::{Error, Status};
use crate::support::monitor::{Silently, Step};
use crate::support::output::{self, OutputError};
use crate::support::scratch::{self, Scratch};
use crate::table::Table;
use crate::tracer::trace::Request;

impl Work<'_> {
    /// Drops some beds in one Blender, and traces all that depend on them.
    pub(super) fn batch(
        &self,
        mut drops: Vec<Vec<usize>>,
        tell: &dyn Fn(bool),
    ) -> Result<(), Error> {
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
