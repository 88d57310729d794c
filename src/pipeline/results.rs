//! From beds to results: the stages trace, signature, picture.

use std::path::PathBuf;
use std::time::Duration;

use rayon::prelude::*;

use super::folder::Folder;
use super::page::{self, Told};
use super::planned::Dropped;
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

impl<'a> Run<'a> {
    /// Traces beds whose number was given.
    pub(super) fn traced(&mut self, beds: Vec<Bed>) -> Result<Dropped, Error> {
        let tables = self.trace(&beds, false)?;
        Ok(Dropped { beds, tables, plan: None, refused: Vec::new() })
    }

    /// Traces every packing into a table of its own.
    pub(super) fn trace(&mut self, beds: &[Bed], is_planned: bool) -> Result<Vec<Table>, Error> {
        let step = self.folder.begin("trace");
        let refracts = beds.iter().any(|bed| bed.prepared.nodes.is_some());
        let target = self.options.target(beds.len(), is_planned, refracts);
        let (cache, grid, number) = (self.cache, &self.options.grid, beds.len());
        let monitor = self.folder.monitor;
        // Side by side, since one thread does much of reading a bed.
        let made: Vec<Made> = beds
            .par_iter()
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
                    bed.close();
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
    pub(super) fn picture(&mut self, bed: &Bed) -> Result<(), Error> {
        let step = self.folder.begin("picture");
        let Pictures { view, drop } = self.pen(bed).draw()?;
        for file in [page::PATCH, page::LIGHT] {
            self.folder.copy(&view.folder.join(file), file)?;
        }
        let mut cached = view.cached;
        if let Some(drop) = drop {
            cached &= drop.cached;
            self.folder.copy(&drop.folder.join(page::DROP), page::DROP)?;
        }
        self.folder.end("picture", step, "", cached);
        Ok(())
    }

    fn pen<'b>(&self, bed: &'b Bed) -> Pen<'b>
    where
        'a: 'b,
    {
        let frames = self.folder.key(&format!("{}frames.json", bed.below));
        let is_recorded = self.folder.record.outputs.contains_key(&frames);
        Pen { bed, is_recorded, cache: self.cache, monitor: self.folder.monitor }
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

/// The pictures of a bed, in the cache.
struct Pictures {
    /// As the sensor sees it.
    view: Made,
    /// From the release to the rest, where the drop was recorded.
    drop: Option<Made>,
}

/// Draws a bed.
struct Pen<'a> {
    bed: &'a Bed,
    /// Whether its drop was recorded.
    is_recorded: bool,
    cache: &'a Cache,
    monitor: &'a dyn Monitor,
}

impl Pen<'_> {
    fn draw(&self) -> Result<Pictures, Error> {
        let Self { bed, monitor, .. } = *self;
        let (scene, sum) = (&bed.prepared.scene, bed.sha256()?);
        let view = self.cache.stage("picture", &(program(), &sum), |folder| {
            let files = [page::PATCH, page::LIGHT].map(|file| folder.join(file));
            picture::sensor_view(scene, bed.tracer()?.bed(), [&files[0], &files[1]], monitor)
        })?;
        let drop = self.is_recorded.then(|| {
            self.cache.stage("picture", &(program(), &sum, "drop"), |folder| {
                let file = folder.join(page::DROP);
                picture::small_drop(scene, bed.tracer()?.bed(), &file, monitor)
            })
        });
        Ok(Pictures { view, drop: drop.transpose()? })
    }
}

impl Bed {
    /// Its bounce table, traced or from the cache.
    pub(crate) fn table(
        &self,
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
            let table = trace::trace(&*self.tracer()?, &prepared, request, monitor)?;
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
