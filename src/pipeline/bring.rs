//! Beds from Blender, copied to their places with the files that their scenes name.

use std::ops::Range;
use std::time::Duration;

use super::{Bed, Run};
use crate::beds::own_grains::OwnGrains;
use crate::beds::{HULLS, Order};
use crate::blender;
use crate::scene::{Origin, Packing, Placed, Scene, SceneGeometry, Sides};
use crate::spectrum;
use crate::support::cache::Made;
use crate::support::error::Error;
use crate::support::random;
use crate::table::Prepared;

/// Some of the beds of a recipe, by number, and how they are kept.
#[derive(Clone)]
pub(super) struct Wanted {
    pub(super) beds: Range<usize>,
    pub(super) kept: Kept,
}

/// How the beds of a result are kept.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kept {
    /// One bed, in the folder of the result.
    One,
    /// Several beds, each in a folder of its own.
    Several,
    /// Several, of which some are there as hulls and with fines that touch: these are hulls alone.
    Hulls,
    /// The same: these are both, from one drop.
    Pairs,
}

impl Wanted {
    /// This number of beds.
    pub(super) fn of(beds: usize) -> Self {
        Self { beds: 0..beds, kept: if beds == 1 { Kept::One } else { Kept::Several } }
    }

    /// The folder of a bed below that of the scene's result.
    fn below(&self, bed: usize) -> String {
        if self.kept == Kept::One { String::new() } else { format!("packings/{}/", bed + 1) }
    }
}

impl Run<'_> {
    /// The beds that Blender drops, as placed geometry with the scene's materials and view. Of
    /// pairs the beds whose fines touch come first.
    pub(super) fn drop(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&OwnGrains>,
        wanted: &Wanted,
    ) -> Result<Vec<Bed>, Error> {
        // A recipe may have the name of the settled bed.
        self.folder.keeps_inputs(&[&format!("{}scene.json", wanted.below(0))])?;
        let stage = if wanted.kept == Kept::Pairs { "touch" } else { "drop" };
        let step = self.folder.begin(stage);
        let monitor = self.folder.monitor;
        let limit = Duration::from_secs(self.options.blender_timeout_s);
        let blender =
            blender::find(self.options.blender.as_deref(), self.cache.blenders(), limit, monitor)?;
        if let Some(warning) = blender.warning() {
            monitor.say(&format!("warning: {warning}"));
        }
        for (name, version) in [
            ("blender", blender.version.to_string()),
            ("python", blender.python.clone()),
            ("numpy", blender.numpy.clone()),
            ("scripts", blender::scripts_sha256()),
        ] {
            self.folder.record.versions.insert(name.into(), version);
        }
        let seeds = wanted.beds.clone().map(|i| random::seed_of(packing.seed, i));
        let seeds: Vec<u64> = seeds.collect();
        // Files for other programs, of the bed that is shown.
        let mut extra = Vec::new();
        if wanted.beds.start == 0 {
            extra.extend(["scene.glb", "scene.blend", "frames.json"]);
            extra.extend(self.options.patch_obj.then_some("patch.obj"));
        }
        let order = Order {
            blender: &blender,
            scene: &prepared.scene,
            packing,
            own_grains: library,
            seeds: &seeds,
            of_first: &extra,
            time_limit: limit,
        };
        let log = |number: usize| self.folder.running_log(number);
        let made = order.beds(self.cache, &log, &step)?;
        let (mut beds, mut hulls) = (Vec::new(), Vec::new());
        for (number, made) in wanted.beds.clone().zip(&made) {
            let below = wanted.below(number);
            let mut bring = |below: &str, file: &str, origin: Origin| {
                let scene = Scene::read(&made.folder.join(file))?;
                let drop = random::seed_of(packing.seed, number);
                let drop = [Kept::Hulls, Kept::Pairs].contains(&wanted.kept).then_some(drop);
                self.bring_bed(number, below, scene, prepared, (origin, drop))
            };
            match wanted.kept {
                Kept::Pairs => {
                    let touching = format!("packings/{}-touching/", number + 1);
                    beds.push(bring(&touching, "scene.json", Origin::Drawn)?);
                    hulls.push(bring(&below, HULLS, Origin::DrawnApart)?);
                    self.bring_files_of(made, &touching, |_| true)?;
                    self.bring_files_of(made, &below, |file| file.starts_with("prototypes."))?;
                }
                _ => {
                    beds.push(bring(&below, "scene.json", packing.origin())?);
                    self.bring_files_of(made, &below, |_| true)?;
                }
            }
        }
        beds.extend(hulls);
        let cached = made.iter().all(|made| made.cached);
        self.folder.end(stage, step, "Blender", cached);
        Ok(beds)
    }

    /// Copies the files of a drop beside its scene.
    fn bring_files_of(
        &mut self,
        made: &Made,
        below: &str,
        which: impl Fn(&str) -> bool,
    ) -> Result<(), Error> {
        for file in made.files.iter().filter(|file| !["scene.json", HULLS].contains(&&***file)) {
            if which(file) {
                self.folder.copy(&made.folder.join(file), &format!("{below}{file}"))?;
            }
        }
        Ok(())
    }

    /// Gives the scene of a settled bed the spectra, the view and a seed, and writes it to its place.
    fn bring_bed(
        &mut self,
        number: usize,
        below: &str,
        placed: Scene,
        prepared: &Prepared,
        (of, dropped): (Origin, Option<u64>),
    ) -> Result<Bed, Error> {
        let scene = &prepared.scene;
        let seed = random::seed_of(scene.seed, number);
        // The file that is written has the changes in it.
        let mut placed =
            Scene { geometry: placed.geometry, seed, changes: Vec::new(), ..scene.clone() };
        if let SceneGeometry::Placed(Placed { domain, origin, drop, .. }) = &mut placed.geometry {
            (*origin, *drop) = (of, dropped);
            if let (Some(particles), Some(domain)) = (self.options.field, domain) {
                domain.sides = Sides::Field { particles, seed: number as u64 };
            }
        }
        self.bring_files(below, &mut placed)?;
        let name = format!("{below}scene.json");
        let text = serde_json::to_string_pretty(&placed).expect("plain data");
        self.folder.write(&name, text + "\n")?;
        placed.file = self.folder.place(&name);
        let below = below.to_owned();
        Ok(Bed { prepared: prepared.with(placed), below, sources: None, tracer: None })
    }

    /// Copies the files that a scene names beside the placed scene, so that it can stand alone.
    fn bring_files(&mut self, below: &str, scene: &mut Scene) -> Result<(), Error> {
        let folder = scene.folder().to_owned();
        for file in scene.files_mut() {
            for from in spectrum::format::files(&folder.join(&file.path)) {
                self.folder.copy(&from, &format!("{below}{}", file.copy_name(&from)))?;
            }
            *file.path = file.copy_name(file.path).into();
        }
        Ok(())
    }
}
