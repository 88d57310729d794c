//! A planned run: a pilot, and what it tells.

use std::ops::Range;

use rayon::prelude::*;

use super::results::program;
use super::{Bed, Run};
use crate::beds::own_grains::OwnGrains;
use crate::report;
use crate::scene::{Collision, Packing, SceneGeometry};
use crate::signature;
use crate::signature::budget::{Budget, Origin};
use crate::signature::depth::{self, Depth};
use crate::signature::plan::{LOOK, PILOT, Plan};
use crate::support::cache::CacheError;
use crate::support::error::Error;
use crate::support::output::{self, OutputError};
use crate::table::Prepared;
use crate::table::Table;

/// Up to this number of packings, fewer grains do not save what their pilot costs.
const FEW: usize = 4 * PILOT;

impl Run<'_> {
    /// Marks the stages from there on as those of a pilot.
    fn call_pilot(&mut self, begun: usize) {
        for stage in &mut self.folder.record.stages[begun..] {
            if !stage.name.starts_with("pilot ") {
                stage.name.insert_str(0, "pilot ");
            }
        }
    }

    /// As many packings as the tolerance takes, dropped until their fines touch if that is needed.
    pub(super) fn planned(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&OwnGrains>,
    ) -> Result<(Vec<Bed>, Vec<Table>, Plan), Error> {
        let tolerance = self.options.tolerance;
        let begun = self.folder.record.stages.len();
        let wavelengths_um = &prepared.wavelengths_um;
        let (mut prepared, mut packing) = (prepared.clone(), packing.clone());
        let made = |run: &mut Self, prepared: &Prepared, packing: &Packing| {
            let mut beds = run.drop(prepared, packing, library)?;
            let tables = run.trace(&mut beds)?;
            Ok::<_, Error>((beds, tables))
        };
        let (mut depth, mut sought, mut touching) = (None, false, false);
        let mut most = 0;
        let mut looking = Origin::of(&packing) == Origin::DrawnApart;
        if looking {
            self.packings = LOOK;
        }
        loop {
            let (mut beds, mut tables) = made(self, &prepared, &packing)?;
            let left_out = depth.map_or(0.0, |depth: Depth| depth.change);
            let found = plan_of(&tables, &packing, wavelengths_um, tolerance, left_out)?;
            let plan = Plan { depth, touching: touching || found.touching, ..found };
            if std::mem::take(&mut looking) && !plan.touching {
                self.call_pilot(begun);
                self.packings = PILOT;
                continue;
            }
            self.folder.monitor.say(&format!("plan: {}", report::plan(&plan, tolerance)));
            // Packings that touch and shallower ones have a pilot of their own.
            let mut anew = found.touching;
            if !sought && (plan.touching || plan.to_be_dropped() > FEW) {
                sought = true;
                depth = self.depth(&mut beds, &tables, &packing, &plan, wavelengths_um)?;
                if let Some(depth) = depth {
                    packing = depth.of(&packing);
                    anew = true;
                }
            }
            if found.touching {
                touching = true;
                packing.drop.collision = Collision::HullThenFines;
            }
            prepared.scene.geometry = SceneGeometry::Packing(packing.clone());
            let pilot = if anew { Some(PILOT) } else { plan.larger_pilot() };
            most = most.max(self.packings);
            if pilot.is_none() && plan.packings == self.packings {
                self.forget_packings(self.packings..most)?;
                return Ok((beds, tables, plan));
            }
            // Packings of a pilot that are dropped again come from the cache.
            self.call_pilot(begun);
            self.packings = pilot.unwrap_or(plan.packings);
            if pilot.is_none() {
                (beds, tables) = made(self, &prepared, &packing)?;
                self.forget_packings(self.packings..most)?;
                return Ok((beds, tables, plan));
            }
        }
    }

    /// Removes what a larger pilot of other beds left.
    fn forget_packings(&mut self, packings: Range<usize>) -> Result<(), Error> {
        packings.into_iter().try_for_each(|i| self.folder.remove(&self.of_packing(i, "")))
    }

    /// The number of grains that beds like those of a pilot need.
    fn depth(
        &mut self,
        beds: &mut [Bed],
        tables: &[Table],
        packing: &Packing,
        plan: &Plan,
        um: &[f64],
    ) -> Result<Option<Depth>, Error> {
        let step = self.folder.begin("depth");
        let (tolerance, monitor) = (self.options.tolerance, self.folder.monitor);
        let traced: Vec<_> =
            tables.iter().map(|table| (&table.scene_sha256, table.paths)).collect();
        let spectra = &tables[0].materials;
        let grid = &self.options.grid;
        let made_from = (program(), traced, spectra, packing, plan, grid, tolerance);
        let made = self.cache.stage("depth", &made_from, |folder| {
            beds.par_iter_mut().try_for_each(|bed| bed.tracer().map(|_| ()))?;
            let tried = |taken| {
                let rest = |(bed, table): (&Bed, &Table)| {
                    let tracer = bed.tracer.as_ref().expect("it was made ready");
                    depth::without_lowest(tracer, &bed.prepared, table, taken, monitor)
                };
                let rest: Vec<Table> =
                    beds.par_iter().zip(tables).map(rest).collect::<Result<_, _>>()?;
                let (change, at_um) = depth::change(tables, &rest, um)?;
                Ok((change, at_um, rest))
            };
            let planned = |rest: Vec<Table>, change| plan_of(&rest, packing, um, tolerance, change);
            let found = Depth::find(packing, plan, tolerance, tried, planned)?;
            let text = serde_json::to_vec(&found).expect("plain data");
            Ok(output::bytes(&folder.join(DEPTH), &text)?)
        })?;
        let path = made.folder.join(DEPTH);
        let read = std::fs::read(&path).and_then(|text| Ok(serde_json::from_slice(&text)?));
        let found: Option<Depth> =
            read.map_err(|source| CacheError(OutputError { path, source }))?;
        let note = found.map_or("all grains are needed".into(), |found| report::depth(&found));
        self.folder.end("depth", step, &note, made.cached);
        Ok(found)
    }
}

/// The file of its result in the cache.
const DEPTH: &str = "depth.json";

/// The plan by a pilot. The cells of the views replace the spread of fewer packings. `left_out` is
/// the change by grains that were left out.
fn plan_of(
    tables: &[Table],
    packing: &Packing,
    um: &[f64],
    tolerance: f64,
    left_out: f64,
) -> Result<Plan, Error> {
    let mut bands = signature::evaluate(tables, um)?;
    let budget = Budget::new(tables, &bands, Origin::of(packing))?;
    if tables.len() < PILOT {
        for (band, rho) in bands.iter_mut().zip(tables[0].reflectances(um)?) {
            band.emissivity.spread = signature::spread_by_cells(tables, &rho);
        }
    }
    let plan = Plan::new(tables.len().max(PILOT), &bands, &budget, tolerance, left_out);
    Ok(Plan { pilot: tables.len(), ..plan })
}
