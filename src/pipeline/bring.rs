//! Beds from Blender, brought to their places with all that their scenes name.

use std::path::Path;
use std::time::Duration;

use super::{Bed, Run};
use crate::beds::Order;
use crate::beds::own_grains::Library;
use crate::scene::{Packing, Placed, Scene, SceneGeometry, Sides};
use crate::support::cache::Made;
use crate::support::error::Error;
use crate::support::monitor::Step;
use crate::support::{output, random};
use crate::table::Prepared;
use crate::{blender, spectrum};

impl Run<'_> {
    /// Blender's part: the beds as placed geometry, with the scene's own materials and view.
    pub(super) fn drop(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&Library>,
    ) -> Result<Vec<Bed>, Error> {
        // A recipe may be called as the settled bed is.
        self.keeps_inputs(&[&self.of_packing(0, "scene.json")])?;
        let step = Step::new(self.monitor, &self.key("drop"));
        let blender =
            blender::find(self.options.blender.as_deref(), self.cache.blenders(), self.monitor)?;
        if let Some(warning) = blender.warning() {
            self.monitor.say(&format!("warning: {warning}"));
        }
        for (name, version) in [
            ("blender", blender.version.to_string()),
            ("python", blender.python.clone()),
            ("numpy", blender.numpy.clone()),
            ("scripts", blender::scripts_sha256()),
        ] {
            self.record.versions.insert(name.into(), version);
        }
        let packings = 0..self.packings;
        let seeds: Vec<u64> = packings.map(|i| random::seed_of(packing.seed, i)).collect();
        // For other programs, of one bed: of several, that of the first seed alone has them.
        let mut extra = Vec::new();
        if self.packings == 1 {
            extra.extend(["scene.glb", "scene.blend", "frames.json"]);
        }
        if self.options.patch_obj {
            extra.push("patch.obj");
        }
        let order = Order {
            blender: &blender,
            scene: &prepared.scene,
            packing,
            library,
            seeds: &seeds,
            of_first: &extra,
            time_limit: Duration::from_secs(self.options.blender_timeout_s),
        };
        let log = |i: usize| self.place(&self.of_packing(i, "blender.log"));
        let made = order.beds(self.cache, &log, &step)?;
        self.begin_to_write()?;
        let mut beds = Vec::new();
        for (i, made) in made.iter().enumerate() {
            beds.push(self.bring_bed(i, made, prepared)?);
        }
        let cached = made.iter().all(|made| made.cached);
        let seconds = step.done(if cached { "from the cache" } else { "Blender" });
        self.stage("drop", seconds, cached);
        Ok(beds)
    }

    /// Copies a settled bed to its place and gives its scene the spectra, the view and a seed for its rays.
    fn bring_bed(
        &mut self,
        packing: usize,
        made: &Made,
        prepared: &Prepared,
    ) -> Result<Bed, Error> {
        let scene = &prepared.scene;
        for file in made.files.iter().filter(|file| *file != "scene.json") {
            let name = self.of_packing(packing, file);
            output::copy(&made.folder.join(file), &self.place(&name))?;
            self.wrote(&name)?;
        }
        let placed = Scene::read(&made.folder.join("scene.json"))?;
        let seed = random::seed_of(scene.seed, packing);
        let mut placed = Scene { geometry: placed.geometry, seed, ..scene.clone() };
        if let (Some(particles), SceneGeometry::Placed(Placed { domain: Some(domain), .. })) =
            (self.options.field, &mut placed.geometry)
        {
            domain.sides = Sides::Field { particles, seed: packing as u64 };
        }
        self.bring_spectra(packing, &mut placed)?;
        let name = self.of_packing(packing, "scene.json");
        let place = self.place(&name);
        let mut text = serde_json::to_string_pretty(&placed).expect("plain data");
        text.push('\n');
        output::bytes(&place, text.as_bytes())?;
        self.wrote(&name)?;
        placed.file = place;
        Ok(Bed { prepared: prepared.with(placed), sources: None, tracer: None })
    }

    /// Copies the files that a scene names for spectra, pure beds, sky and atmosphere beside the placed scene, so that it can stand alone.
    fn bring_spectra(&mut self, packing: usize, scene: &mut Scene) -> Result<(), Error> {
        let folder = scene.folder().to_owned();
        for (number, material) in scene.materials.iter_mut().enumerate() {
            if let Some(file) = material.spectrum.file_mut() {
                let named = |file: &Path| {
                    let name = file.file_name().unwrap_or_default().to_string_lossy();
                    format!("spectrum_{number}_{name}")
                };
                for from in spectrum::format::files(&folder.join(&file))? {
                    self.bring(packing, &from, &named(&from))?;
                }
                *file = named(file).into();
            }
            for (bed, table) in material.spectrum.tables_mut().iter_mut().enumerate() {
                // Those of several packings all bear one name.
                let name = format!("pure_bed_{number}_{bed}.json");
                self.bring(packing, &folder.join(&table), &name)?;
                *table = name.into();
            }
        }
        for (kind, file) in scene.air_files_mut() {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let name = format!("{kind}_{name}");
            let place = self.of_packing(packing, &name);
            output::copy(&folder.join(&file), &self.place(&place))?;
            self.wrote(&place)?;
            *file = name.into();
        }
        Ok(())
    }

    /// Copies a file beside the placed scene of a packing.
    fn bring(&mut self, packing: usize, from: &Path, name: &str) -> Result<(), Error> {
        let place = self.of_packing(packing, name);
        output::copy(from, &self.place(&place))?;
        self.wrote(&place)
    }
}
