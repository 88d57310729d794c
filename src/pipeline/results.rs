//! From beds to results: the stages trace, signature, picture.

use std::time::Duration;

use rayon::prelude::*;

use super::{Bed, Options, Run};
use crate::draw::picture;
use crate::radiometry::Assumed;
use crate::report;
use crate::scene::Scene;
use crate::signature::{self, Band};
use crate::support::cache::Made;
use crate::support::error::Error;
use crate::support::monitor::Step;
use crate::support::output;
use crate::table::Prepared;
use crate::table::{Table, Target};
use crate::tracer::trace::{self, Request};

impl Run<'_> {
    /// Every packing into a table of its own. Together their rays are to make no more than half of the
    /// tolerance where there are several packings, whose spread needs the rest.
    pub(super) fn trace(&mut self, beds: &mut [Bed]) -> Result<Vec<Table>, Error> {
        let step = Step::new(self.monitor, &self.key("trace"));
        let tolerance = match beds.len() {
            1 => self.options.tolerance,
            n => (self.options.tolerance * (n as f64).sqrt() / 2.0).min(0.5),
        };
        let Options { max_paths, max_seconds, .. } = *self.options;
        // What paths given up leave open is the same in every bed: more beds do not lessen it.
        let whole = Target::of(self.options.tolerance);
        let target = Target { tolerance, max_paths, max_seconds, ..whole };
        let (cache, grid, number) = (self.cache, &self.options.grid, beds.len());
        let monitor = self.monitor;
        // Side by side, since much of reading a bed is the work of one thread.
        let made: Vec<Made> = beds
            .par_iter_mut()
            .enumerate()
            .map(|(i, bed)| {
                let sum = bed.sha256()?;
                let prepared = bed.prepared.clone();
                let Prepared { scene, materials, air, .. } = &prepared;
                let made_from =
                    (program(), &sum, scene.seed, &materials[..], &**air, grid, &target);
                let what = if number == 1 { "paths".into() } else { format!("packing {}", i + 1) };
                let made = cache.stage("trace", &made_from, |folder| {
                    let request = Request { what: &what, ..Request::new(grid, target) };
                    let table = trace::trace(bed.tracer()?, &prepared, request, monitor)?;
                    Ok(table.write(&folder.join("table.json"))?)
                })?;
                if i > 0 {
                    // Only the first is looked at again, for its picture.
                    (bed.sources, bed.tracer) = (None, None);
                }
                Ok(made)
            })
            .collect::<Result<_, Error>>()?;
        self.begin_to_write()?;
        let mut tables = Vec::new();
        for (i, made) in made.iter().enumerate() {
            let name = self.of_packing(i, "table.json");
            output::copy(&made.folder.join("table.json"), &self.place(&name))?;
            self.wrote(&name)?;
            tables.push(Table::read(&self.place(&name))?);
        }
        let cached = made.iter().all(|made| made.cached);
        let paths: u64 = tables.iter().map(|table| table.paths).sum();
        let note = if cached { "from the cache".into() } else { format!("{paths} paths") };
        let seconds = step.done(&note);
        self.stage("trace", seconds, cached);
        Ok(tables)
    }

    pub(super) fn signature(
        &mut self,
        scene: &Scene,
        tables: &[Table],
        wavelengths_um: &[f64],
    ) -> Result<Vec<Band>, Error> {
        let step = Step::new(self.monitor, &self.key("signature"));
        let bands = signature::evaluate(tables, wavelengths_um)?;
        let csv = self.place("signature.csv");
        signature::write_csv(&bands, tables[0].temperature(), Assumed::EXACT, &csv)?;
        self.wrote("signature.csv")?;
        let title = scene.description.as_ref().unwrap_or(&scene.name);
        let chart = report::chart(title, &[(tables, &bands)], &self.record.versions);
        report::draw(&chart, &self.place("signature"))?;
        self.wrote("signature.svg")?;
        self.wrote("signature.png")?;
        let seconds = step.done(&format!("{} bands", bands.len()));
        self.stage("signature", seconds, false);
        Ok(bands)
    }

    /// The sensor's view of the first packing.
    pub(super) fn picture(&mut self, bed: &mut Bed, table: &Table) -> Result<(), Error> {
        let step = Step::new(self.monitor, &self.key("picture"));
        let made_from = (program(), &table.scene_sha256);
        let made = self.cache.stage("picture", &made_from, |folder| {
            picture::sensor_view(bed.tracer()?.bed(), &folder.join("patch.png"), self.monitor)
        })?;
        output::copy(&made.folder.join("patch.png"), &self.place("patch.png"))?;
        self.wrote("patch.png")?;
        let seconds = step.done(if made.cached { "from the cache" } else { "" });
        self.stage("picture", seconds, made.cached);
        Ok(())
    }

    /// All coverages in one chart: the paper's Fig. 6.
    pub(super) fn draw_all(&mut self, curves: &[(Vec<Table>, Vec<Band>)]) -> Result<(), Error> {
        let curves: Vec<_> =
            curves.iter().map(|(tables, bands)| (&tables[..], &bands[..])).collect();
        let title = "Emissivity of quartz soil by its cover with fines";
        let chart = report::chart(title, &curves, &self.record.versions);
        report::draw(&chart, &self.out.join("signatures"))?;
        self.wrote("signatures.svg")?;
        self.wrote("signatures.png")
    }
}

/// What tells this build of the program from another: what it traced before is not taken for its own.
pub(super) fn program() -> Option<(u64, Duration)> {
    let file = std::env::current_exe().and_then(std::fs::metadata).ok()?;
    let age = file.modified().ok()?.duration_since(std::time::UNIX_EPOCH).ok()?;
    Some((file.len(), age))
}
