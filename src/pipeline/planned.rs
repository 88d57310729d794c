//! A planned run: a pilot, and what it tells.

use std::ops::Range;

use super::{Bed, Run};
use crate::beds::own_grains::OwnGrains;
use crate::report;
use crate::scene::{Collision, Origin, Packing, SceneGeometry};
use crate::signature;
use crate::signature::budget::Budget;
use crate::signature::plan::{LOOK, PILOT, Plan};
use crate::support::error::Error;
use crate::table::Prepared;
use crate::table::Table;

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
    /// Where all of them spread more than the pilot said, more are dropped.
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
        let mut touching = false;
        let mut most = 0;
        let mut looking = packing.origin() == Origin::DrawnApart;
        if looking {
            self.packings = LOOK;
        }
        loop {
            let (beds, tables) = made(self, &prepared, &packing)?;
            let found = plan_of(&tables, wavelengths_um, tolerance)?;
            let plan = Plan { touching: touching || found.touching, ..found };
            if std::mem::take(&mut looking) && !plan.touching {
                self.call_pilot(begun);
                self.packings = PILOT;
                continue;
            }
            self.folder.monitor.say(&format!("plan: {}", report::plan(&plan, tolerance)));
            // Packings that touch have a pilot of their own.
            if found.touching {
                touching = true;
                packing.drop.collision = Collision::HullThenFines;
            }
            prepared.scene.geometry = SceneGeometry::Packing(packing.clone());
            let pilot = if found.touching { Some(PILOT) } else { plan.larger_pilot() };
            most = most.max(self.packings);
            if pilot.is_none() && plan.packings == self.packings {
                self.forget_packings(self.packings..most)?;
                return Ok((beds, tables, plan));
            }
            // Packings that are dropped again come from the cache.
            self.call_pilot(begun);
            self.packings = pilot.unwrap_or(plan.packings);
        }
    }

    /// Removes what a larger pilot of other beds left.
    fn forget_packings(&mut self, packings: Range<usize>) -> Result<(), Error> {
        packings.into_iter().try_for_each(|i| self.folder.remove(&self.of_packing(i, "")))
    }
}

/// The plan by a pilot. The cells of the views replace the spread of fewer packings.
fn plan_of(tables: &[Table], um: &[f64], tolerance: f64) -> Result<Plan, Error> {
    let mut bands = signature::evaluate(tables, um)?;
    let budget = Budget::new(tables, &bands)?;
    if tables.len() < PILOT {
        for (band, rho) in bands.iter_mut().zip(tables[0].reflectances(um)?) {
            band.emissivity.spread = signature::spread_by_cells(tables, &rho);
        }
    }
    let plan = Plan::new(tables.len().max(PILOT), &bands, &budget, tolerance);
    Ok(Plan { pilot: tables.len(), ..plan })
}
