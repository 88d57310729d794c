//! Beds from Blender, copied to their places with the files that their scenes name.

use std::path::Path;
use std::time::Duration;

use super::{Bed, Run};
use crate::beds::own_grains::OwnGrains;
use crate::beds::{Failed, HULLS, Order, Wanted};
use crate::blender;
use crate::scene::{Collision, Origin, Packing, Placed, Scene, SceneGeometry, Sides};
use crate::spectrum;
use crate::support::cache::Made;
use crate::support::error::Error;
use crate::support::random;
use crate::table::Prepared;

/// Beds of a recipe, by number, each with how it is kept. The first is bed 0.
pub(super) type Lot = Vec<(usize, Kept)>;

/// How a bed of a result is kept.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kept {
    /// In the folder of the result, as the only bed.
    One,
    /// In a folder of its own.
    Several,
    /// The same, as hulls, beside pairs.
    Hulls,
    /// As hulls and with fines that touch, from one drop.
    Pair,
}

/// This number of beds by the recipe.
pub(super) fn lot(beds: usize) -> Lot {
    let kept = if beds == 1 { Kept::One } else { Kept::Several };
    (0..beds).map(|bed| (bed, kept)).collect()
}

impl Kept {
    /// The folder of a bed below that of the scene's result.
    fn folder(self, bed: usize) -> String {
        if self == Self::One { String::new() } else { format!("packings/{}/", bed + 1) }
    }
}

impl Run<'_> {
    /// The beds that Blender drops, as placed geometry with the scene's materials and view. Of a
    /// pair the hulls come first.
    pub(super) fn drop(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&OwnGrains>,
        lot: &[(usize, Kept)],
    ) -> Result<Vec<Bed>, Failed> {
        // A recipe may have the name of the settled bed.
        self.folder.keeps_inputs(&[&format!("{}scene.json", lot[0].1.folder(0))])?;
        let step = self.folder.begin("drop");
        let monitor = self.folder.monitor;
        let limit = Duration::from_secs(self.options.blender_timeout_s);
        let blender =
            blender::find(self.options.blender.as_deref(), self.cache.blenders(), limit, monitor)
                .map_err(Error::from)?;
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
        // Files for other programs, of the bed that is shown.
        let mut extra = vec!["scene.glb", "scene.blend", "frames.json"];
        extra.extend(self.options.patch_obj.then_some("patch.obj"));
        let wanted = |&(number, kept): &(usize, Kept)| {
            let mut packing =
                Packing { seed: random::seed_of(packing.seed, number), ..packing.clone() };
            if kept == Kept::Pair {
                packing.drop.collision = Collision::HullThenFines;
            }
            Wanted { scene: &prepared.scene, packing, own_grains: library }
        };
        let order = Order {
            blender: &blender,
            beds: lot.iter().map(wanted).collect(),
            of_first: &extra,
            time_limit: limit,
        };
        let log = |number: usize| self.folder.running_log(number);
        let made = order.beds(self.cache, &log, &step)?;
        let mut beds = Vec::new();
        for (&(number, kept), made) in lot.iter().zip(&made) {
            let below = kept.folder(number);
            let seed = random::seed_of(packing.seed, number);
            let drop = [Kept::Hulls, Kept::Pair].contains(&kept).then_some(seed);
            let bed = |file, origin| Settled { made, file, origin, drop, number };
            if kept == Kept::Pair {
                let touching = format!("packings/{}-touching/", number + 1);
                let [second, first] =
                    [bed("scene.json", Origin::Drawn), bed(HULLS, Origin::DrawnApart)];
                beds.push(self.bring_bed(&below, prepared, &first)?);
                beds.push(self.bring_bed(&touching, prepared, &second)?);
                self.bring_files_of(made, &touching, |_| true)?;
                self.bring_files_of(made, &below, |file| file.starts_with("prototypes."))?;
            } else {
                let bed = bed("scene.json", packing.origin());
                beds.push(self.bring_bed(&below, prepared, &bed)?);
                self.bring_files_of(made, &below, |_| true)?;
            }
        }
        let cached = made.iter().all(|made| made.cached);
        self.folder.end("drop", step, "Blender", cached);
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
    fn bring_bed(&mut self, below: &str, prepared: &Prepared, bed: &Settled) -> Result<Bed, Error> {
        let mut placed = bed.placed(&prepared.scene, &mut |from, name| {
            self.folder.copy(from, &format!("{below}{name}"))
        })?;
        if let (Some(particles), SceneGeometry::Placed(Placed { domain: Some(domain), .. })) =
            (self.options.field, &mut placed.geometry)
        {
            domain.sides = Sides::Field { particles, seed: bed.number as u64 };
        }
        let name = format!("{below}scene.json");
        self.folder.write(&name, file_text(&placed))?;
        placed.file = self.folder.place(&name);
        Ok(Bed { below: below.to_owned(), ..Bed::new(prepared.with(placed)) })
    }
}

/// The text of a scene file.
pub(crate) fn file_text(scene: &Scene) -> String {
    serde_json::to_string_pretty(scene).expect("plain data") + "\n"
}

/// A bed that Blender made.
pub(crate) struct Settled<'a> {
    pub(crate) made: &'a Made,
    /// Its scene among the files.
    pub(crate) file: &'a str,
    pub(crate) origin: Origin,
    /// Seed of the drop, if another bed may be of the same drop.
    pub(crate) drop: Option<u64>,
    /// Its number among the beds of the recipe.
    pub(crate) number: usize,
}

impl Settled<'_> {
    /// The scene of the bed with the materials, the view and the seed of its recipe's. `copy` puts
    /// each file that it names beside it, under a name of its own, so that it can stand alone.
    pub(crate) fn placed(
        &self,
        scene: &Scene,
        copy: &mut dyn FnMut(&Path, &str) -> Result<(), Error>,
    ) -> Result<Scene, Error> {
        let Scene { mut geometry, .. } = Scene::read(&self.made.folder.join(self.file))?;
        if let SceneGeometry::Placed(Placed { origin, drop, .. }) = &mut geometry {
            (*origin, *drop) = (self.origin, self.drop);
        }
        let seed = random::seed_of(scene.seed, self.number);
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
}
