//! From beds to results: the stages trace, signature, picture.

use std::path::PathBuf;
use std::time::Duration;

use rayon::prelude::*;

use super::folder::Folder;
use super::page::{self, Told};
use super::{Bed, Run};
use crate::draw::picture;
use crate::draw::plot::{self, Chart};
use crate::radiometry::Assumed;
use crate::report::{self, Report};
use crate::scene::Scene;
use crate::signature;
use crate::signature::plan::Plan;
use crate::support::cache::{Cache, Made};
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::table::{Prepared, Table};
use crate::tracer::trace::{self, Request};

impl Run<'_> {
    /// Traces every packing into a table of its own.
    pub(super) fn trace(
        &mut self,
        beds: &mut [Bed],
        is_planned: bool,
    ) -> Result<Vec<Table>, Error> {
        let step = self.folder.begin("trace");
        let refracts = beds.iter().any(|bed| bed.prepared.nodes.is_some());
        let target = self.options.target(beds.len(), is_planned, refracts);
        let (cache, grid, number) = (self.cache, &self.options.grid, beds.len());
        let monitor = self.folder.monitor;
        // Side by side, since one thread does much of reading a bed.
        let made: Vec<Made> = beds
            .par_iter_mut()
            .enumerate()
            .map(|(i, bed)| {
                let what = if number == 1 { "paths".into() } else { format!("packing {}", i + 1) };
                let made = bed.table(
                    Request { what: &what, ..Request::new(grid, target) },
                    cache,
                    monitor,
                )?;
                if i > 0 {
                    // Only the first bed is needed again, for its picture.
                    (bed.sources, bed.tracer) = (None, None);
                }
                Ok(made)
            })
            .collect::<Result<_, Error>>()?;
        let mut tables = Vec::new();
        for (i, made) in made.iter().enumerate() {
            let name = format!("{}table.json", beds[i].below);
            self.folder.copy(&made.folder.join("table.json"), &name)?;
            tables.push(Table::read(&self.folder.place(&name))?);
        }
        let cached = made.iter().all(|made| made.cached);
        let paths: u64 = tables.iter().map(|table| table.paths).sum();
        self.folder.end("trace", step, &format!("{paths} paths"), cached);
        Ok(tables)
    }

    /// Evaluates the tables and writes the signature, its chart and its budget.
    pub(super) fn signature(
        &mut self,
        scene: &Scene,
        tables: &[Table],
        plan: Option<Plan>,
    ) -> Result<Report, Error> {
        let step = self.folder.begin("signature");
        let options = self.options;
        let um = options.grid.wavelengths_um();
        let asked = (options.tolerance(), options.tolerance_of(&scene.geometry));
        let report = Report::new(tables, &um, asked, plan)?;
        let bands = &report.bands;
        let temperature = tables[0].temperature();
        let csv = signature::csv_text(bands, &report.budget, temperature, Assumed::EXACT);
        self.folder.write("signature.csv", csv)?;
        #[cfg(feature = "netcdf")]
        self.folder.write("signature.nc", {
            let budget = &report.budget;
            signature::netcdf::bytes(&tables[0], bands, budget, temperature, Assumed::EXACT)
        })?;
        self.folder.write("budget.csv", report.budget.csv_text())?;
        let title = scene.description.as_ref().unwrap_or(&scene.name);
        let chart = report::chart(title, &[(tables, &report)], &self.folder.record.versions);
        self.draw(&chart, "signature")?;
        self.folder.end("signature", step, &format!("{} bands", bands.len()), false);
        Ok(report)
    }

    /// Draws the sensor's view of the first packing and, where it was recorded, its drop.
    pub(super) fn picture(&mut self, bed: &mut Bed, table: &Table) -> Result<(), Error> {
        let step = self.folder.begin("picture");
        let made_from = (program(), &table.scene_sha256);
        let scene = bed.prepared.scene.clone();
        let monitor = self.folder.monitor;
        let made = self.cache.stage("picture", &made_from, |folder| {
            let bed = bed.tracer()?.bed();
            let files = [page::PATCH, page::LIGHT].map(|file| folder.join(file));
            picture::sensor_view(&scene, bed, [&files[0], &files[1]], monitor)
        })?;
        let mut cached = made.cached;
        for file in [page::PATCH, page::LIGHT] {
            self.folder.copy(&made.folder.join(file), file)?;
        }
        let frames = self.folder.key(&format!("{}frames.json", bed.below));
        if self.folder.record.outputs.contains_key(&frames) {
            let made_from = (program(), &table.scene_sha256, "drop");
            let made = self.cache.stage("picture", &made_from, |folder| {
                let bed = bed.tracer()?.bed();
                picture::small_drop(&scene, bed, &folder.join(page::DROP), monitor)
            })?;
            cached &= made.cached;
            self.folder.copy(&made.folder.join(page::DROP), page::DROP)?;
        }
        self.folder.end("picture", step, "", cached);
        Ok(())
    }

    /// Writes the page of a scene's result.
    pub(super) fn page(&mut self, scene: &Scene, of: &Told) -> Result<(), Error> {
        let heading = scene.description.as_ref().unwrap_or(&scene.name);
        let Folder { record, new, below, .. } = &self.folder;
        let run = page::of_folder(record, new, below, heading, of);
        let html = report::page::html(&scene.name, &[run]);
        self.folder.write(page::PAGE, html)
    }

    /// Writes the page that compares all coverages.
    pub(super) fn page_of_all(&mut self, results: &[Told]) -> Result<(), Error> {
        let runs = page::side_by_side(self.folder.record, self.folder.new, results);
        let html = report::page::html("Quartz soil by its cover with fines", &runs);
        self.folder.write(page::PAGE, html)
    }

    /// Draws all coverages in one chart: the paper's Fig. 6.
    pub(super) fn draw_all(&mut self, results: &[Told]) -> Result<(), Error> {
        let curves: Vec<_> = results.iter().map(|of| (&of.tables[..], &of.report)).collect();
        let title = "Emissivity of quartz soil by its cover with fines";
        let chart = report::chart(title, &curves, &self.folder.record.versions);
        self.draw(&chart, "signatures")
    }

    /// Writes a chart as `STEM.svg` and `STEM.png`.
    fn draw(&mut self, chart: &Chart, stem: &str) -> Result<(), Error> {
        let svg = plot::emissivity_svg(chart)?;
        self.folder.write(&format!("{stem}.svg"), &svg)?;
        self.folder.write(&format!("{stem}.png"), plot::png(&svg, plot::PIXELS_PER_UNIT)?)
    }
}

impl Bed {
    /// Its bounce table, traced or from the cache.
    pub(crate) fn table(
        &mut self,
        request: Request,
        cache: &Cache,
        monitor: &dyn Monitor,
    ) -> Result<Made, Error> {
        let sum = self.sha256()?;
        let prepared = self.prepared.clone();
        let Prepared { scene, materials, air, .. } = &prepared;
        let Request { grid, target, .. } = request;
        let made_from = (program(), &sum, scene.seed, &materials[..], &**air, grid, &target);
        cache.stage("trace", &made_from, |folder| {
            let table = trace::trace(self.tracer()?, &prepared, request, monitor)?;
            Ok(table.write(&folder.join(TABLE))?)
        })
    }
}

/// The file of a bounce table.
pub(crate) const TABLE: &str = "table.json";

/// Identifies this build of the program, so that it does not use what another one traced.
pub(crate) fn program() -> Option<(u64, Duration)> {
    let file = file_of_program().and_then(std::fs::metadata).ok()?;
    let age = file.modified().ok()?.duration_since(std::time::UNIX_EPOCH).ok()?;
    Some((file.len(), age))
}

/// The file that holds this code: the program, or the module of a Python.
fn file_of_program() -> std::io::Result<PathBuf> {
    let here = program as *const () as usize;
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let holds = |line: &&str| {
        let (from, to) = line.split_once(' ')?.0.split_once('-')?;
        let hex = |text| usize::from_str_radix(text, 16).ok();
        (hex(from)?..hex(to)?).contains(&here).then_some(())
    };
    let line = maps.lines().find(|line| holds(line).is_some());
    // Its columns are range, rights, offset, device, inode, path.
    match line.and_then(|line| line.find('/').map(|at| &line[at..])) {
        Some(path) => Ok(path.into()),
        None => std::env::current_exe(),
    }
}
