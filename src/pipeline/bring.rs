//! Beds from Blender, copied to their places with the files that their scenes name.

use std::path::Path;
use std::time::Duration;

use super::{Bed, Run};
use crate::beds::own_grains::OwnGrains;
use crate::beds::{Order, Wanted};
use crate::blender;
use crate::scene::{Packing, Placed, Scene, SceneGeometry, Sides};
use crate::spectrum;
use crate::support::cache::Made;
use crate::support::error::Error;
use crate::support::random;
use crate::table::Prepared;

impl Run<'_> {
    /// The beds that Blender drops, as placed geometry with the scene's materials and view.
    pub(super) fn drop(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&OwnGrains>,
    ) -> Result<Vec<Bed>, Error> {
        // A recipe may have the name of the settled bed.
        self.folder.keeps_inputs(&[&self.of_packing(0, "scene.json")])?;
        let step = self.folder.begin("drop");
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
        let packings = 0..self.packings;
        let seeds: Vec<u64> = packings.map(|i| random::seed_of(packing.seed, i)).collect();
        // Files for other programs, of a single bed only.
        let mut extra = Vec::new();
        if self.packings == 1 {
            extra.extend(["scene.glb", "scene.blend", "frames.json"]);
        }
        if self.options.patch_obj {
            extra.push("patch.obj");
        }
        let order = Order {
            blender: &blender,
            beds: Wanted::of_seeds(&prepared.scene, packing, library, &seeds),
            of_first: &extra,
            time_limit: limit,
        };
        let log = |number: usize| self.folder.running_log(number);
        let made = order.beds(self.cache, &log, &step)?;
        let mut beds = Vec::new();
        for (i, made) in made.iter().enumerate() {
            beds.push(self.bring_bed(i, made, prepared, packing)?);
        }
        let cached = made.iter().all(|made| made.cached);
        self.folder.end("drop", step, "Blender", cached);
        Ok(beds)
    }

    /// Copies a settled bed to its place and gives its scene the spectra, the view and a seed.
    fn bring_bed(
        &mut self,
        packing: usize,
        made: &Made,
        prepared: &Prepared,
        recipe: &Packing,
    ) -> Result<Bed, Error> {
        let scene = &prepared.scene;
        for file in made.files.iter().filter(|file| *file != "scene.json") {
            self.folder.copy(&made.folder.join(file), &self.of_packing(packing, file))?;
        }
        let below = self.of_packing(packing, "");
        let mut placed = placed(made, scene, recipe, packing, &mut |from, name| {
            self.folder.copy(from, &format!("{below}{name}"))
        })?;
        if let (Some(particles), SceneGeometry::Placed(Placed { domain: Some(domain), .. })) =
            (self.options.field, &mut placed.geometry)
        {
            domain.sides = Sides::Field { particles, seed: packing as u64 };
        }
        let name = self.of_packing(packing, "scene.json");
        self.folder.write(&name, file_text(&placed))?;
        placed.file = self.folder.place(&name);
        Ok(Bed::new(prepared.with(placed)))
    }
}

/// The text of a scene file.
pub(crate) fn file_text(scene: &Scene) -> String {
    serde_json::to_string_pretty(scene).expect("plain data") + "\n"
}

/// The scene of a settled bed with the materials, the view and the seed of its recipe's. `copy` puts
/// each file that it names beside it, under a name of its own, so that it can stand alone.
pub(crate) fn placed(
    made: &Made,
    scene: &Scene,
    recipe: &Packing,
    packing: usize,
    copy: &mut dyn FnMut(&Path, &str) -> Result<(), Error>,
) -> Result<Scene, Error> {
    let Scene { mut geometry, .. } = Scene::read(&made.folder.join("scene.json"))?;
    if let SceneGeometry::Placed(Placed { origin, .. }) = &mut geometry {
        *origin = recipe.origin();
    }
    let seed = random::seed_of(scene.seed, packing);
    // The file that is written has the changes in it.
    let mut placed = Scene { geometry, seed, changes: Vec::new(), ..scene.clone() };
    let folder = scene.folder();
    for file in placed.files_mut() {
        for from in spectrum::format::files(&folder.join(&file.path)) {
            copy(&from, &file.copy_name(&from))?;
        }
        *file.path = file.copy_name(file.path).into();
    }
    Ok(placed)
}
