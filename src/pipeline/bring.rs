//! Beds from Blender, copied to their places with the files that their scenes name.

use std::time::Duration;

use super::{Bed, Run};
use crate::beds::Order;
use crate::beds::own_grains::OwnGrains;
use crate::blender;
use crate::scene::{Packing, Placed, Scene, SceneGeometry, Sides};
use crate::spectrum;
use crate::support::cache::Made;
use crate::support::error::Error;
use crate::support::random;
use crate::table::Prepared;

/// Where the beds of a recipe go.
pub(super) struct Places {
    /// How many there are.
    pub(super) beds: usize,
    /// Whether these are second beds of the same drops, whose fines touch.
    pub(super) second: bool,
    /// Whether drops have such second beds.
    pub(super) in_pairs: bool,
}

impl Places {
    /// Of beds that stand alone.
    pub(super) fn of(beds: usize) -> Self {
        Self { beds, second: false, in_pairs: false }
    }

    /// The place of a bed's file, below the folder of the scene's result.
    fn file(&self, bed: usize, file: &str) -> String {
        let bed = bed + 1;
        match (self.second, self.in_pairs || self.beds > 1) {
            (true, _) => format!("packings/{bed}-touching/{file}"),
            (false, true) => format!("packings/{bed}/{file}"),
            (false, false) => file.to_owned(),
        }
    }
}

impl Run<'_> {
    /// The beds that Blender drops, as placed geometry with the scene's materials and view.
    pub(super) fn drop(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&OwnGrains>,
        places: &Places,
    ) -> Result<Vec<Bed>, Error> {
        // A recipe may have the name of the settled bed.
        self.folder.keeps_inputs(&[&places.file(0, "scene.json")])?;
        let stage = if places.second { "touch" } else { "drop" };
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
        let seeds = (0..places.beds).map(|i| random::seed_of(packing.seed, i));
        let seeds: Vec<u64> = seeds.collect();
        // Files for other programs, of the bed that is shown.
        let mut extra = Vec::new();
        if !places.second {
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
        let mut beds = Vec::new();
        for (i, made) in made.iter().enumerate() {
            beds.push(self.bring_bed(i, made, prepared, packing, places)?);
        }
        let cached = made.iter().all(|made| made.cached);
        self.folder.end(stage, step, "Blender", cached);
        Ok(beds)
    }

    /// Copies a settled bed to its place and gives its scene the spectra, the view and a seed.
    fn bring_bed(
        &mut self,
        packing: usize,
        made: &Made,
        prepared: &Prepared,
        recipe: &Packing,
        places: &Places,
    ) -> Result<Bed, Error> {
        let scene = &prepared.scene;
        for file in made.files.iter().filter(|file| *file != "scene.json") {
            self.folder.copy(&made.folder.join(file), &places.file(packing, file))?;
        }
        let placed = Scene::read(&made.folder.join("scene.json"))?;
        let seed = random::seed_of(scene.seed, packing);
        // The file that is written has the changes in it.
        let mut placed =
            Scene { geometry: placed.geometry, seed, changes: Vec::new(), ..scene.clone() };
        if let SceneGeometry::Placed(Placed { domain, origin, drop, .. }) = &mut placed.geometry {
            *origin = recipe.origin();
            *drop = places.in_pairs.then(|| random::seed_of(recipe.seed, packing));
            if let (Some(particles), Some(domain)) = (self.options.field, domain) {
                domain.sides = Sides::Field { particles, seed: packing as u64 };
            }
        }
        let below = places.file(packing, "");
        self.bring_files(&below, &mut placed)?;
        let name = format!("{below}scene.json");
        let text = serde_json::to_string_pretty(&placed).expect("plain data");
        self.folder.write(&name, text + "\n")?;
        placed.file = self.folder.place(&name);
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
