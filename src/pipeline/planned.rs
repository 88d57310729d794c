//! A planned run: beds until the total is within the tolerance.

use super::bring::{Kept, Lot};
use super::{Bed, Run};
use crate::beds::own_grains::OwnGrains;
use crate::report;
use crate::scene::{Collision, Drop, Origin, Packing, SceneGeometry};
use crate::signature::budget::Budget;
use crate::signature::plan::{Beds, COST, Plan};
use crate::signature::{self, Levels};
use crate::support::error::Error;
use crate::table::{Prepared, Table};

/// Wall time of a round of beds, one for each thread, seconds.
#[derive(Clone, Copy, Default)]
struct Round {
    drop: f64,
    touch: f64,
    trace: f64,
}

/// The beds, their tables, and the plan by which they are enough.
pub(super) type Planned = (Vec<Bed>, Vec<Table>, Option<Plan>);

impl Run<'_> {
    /// As many beds as the tolerance takes, of which some are dropped on until their fines touch if
    /// hulls keep them apart.
    pub(super) fn planned(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&OwnGrains>,
    ) -> Result<Planned, Error> {
        let keeps_apart = packing.origin() == Origin::DrawnApart;
        let touch = Packing {
            drop: Drop { collision: Collision::HullThenFines, ..packing.drop.clone() },
            ..packing.clone()
        };
        let mut touching = prepared.clone();
        touching.scene.geometry = SceneGeometry::Packing(touch.clone());
        let (mut before, mut now) = (Beds { drops: 0, pairs: 0 }, Beds { drops: 1, pairs: 0 });
        let mut round = Round::default();
        loop {
            let begun = self.folder.record.stages.len();
            let mut beds = Vec::new();
            let mut hulls = Lot::of(now.drops);
            if now.pairs > 0 {
                let pairs = Lot { beds: 0..now.pairs, kept: Kept::Pairs };
                beds.extend(self.drop(&touching, &touch, library, &pairs)?);
                hulls = Lot { beds: now.pairs..now.drops, kept: Kept::Hulls };
            }
            if !hulls.beds.is_empty() {
                beds.extend(self.drop(prepared, packing, library, &hulls)?);
            }
            let tables = self.trace(&mut beds, true)?;
            let plan = self.plan_of(&tables, &prepared.wavelengths_um, keeps_apart)?;
            let told = report::plan(&plan, self.options.tolerance);
            if plan.is_done() {
                if now.drops > 1 {
                    self.folder.monitor.say(&format!("plan: {told}"));
                }
                return Ok((beds, tables, Some(plan)));
            }
            self.clock(&mut round, begun, now, before);
            let time = report::duration(round.of(plan.next, now));
            self.folder.monitor.say(&format!("plan: {told}, in about {time}"));
            // Beds that are dropped again come from the cache.
            self.folder.remove("")?;
            for stage in &mut self.folder.record.stages[begun..] {
                stage.name.insert_str(0, "pilot ");
            }
            (before, now) = (now, plan.next);
        }
    }

    fn plan_of(&self, tables: &[Table], um: &[f64], keeps_apart: bool) -> Result<Plan, Error> {
        let bands = signature::evaluate(tables, um)?;
        let budget = Budget::new(tables, &bands)?;
        let (levels, curves) = (Levels::of(tables), signature::curves(tables, um)?);
        let tolerance = self.options.tolerance;
        Ok(Plan::new(&levels, &curves, &bands, &budget, tolerance, keeps_apart))
    }

    /// Takes the times of the stages since `begun`, in which the beds beyond `before` were made.
    fn clock(&self, round: &mut Round, begun: usize, now: Beds, before: Beds) {
        let take = |of: &mut f64, name: &str, beds: usize| {
            let key = self.folder.key(name);
            let stages = &self.folder.record.stages[begun..];
            let stage = stages.iter().find(|stage| stage.name == key && !stage.cached);
            if let Some(stage) = stage.filter(|_| beds > 0) {
                *of = stage.seconds / rounds(beds);
            }
        };
        let [drops, pairs] = [now.drops - before.drops, now.pairs - before.pairs];
        // What is in pairs was not dropped as hulls alone.
        take(&mut round.drop, "drop", drops.saturating_sub(pairs));
        take(&mut round.touch, "touch", pairs);
        take(&mut round.trace, "trace", drops + pairs);
    }
}

impl Round {
    /// About how long the beds take that come next.
    fn of(&self, next: Beds, now: Beds) -> f64 {
        let [drops, pairs] = [next.drops - now.drops, next.pairs - now.pairs];
        let touch = if self.touch > 0.0 { self.touch } else { (1.0 + COST) * self.drop };
        let hulls = drops.saturating_sub(pairs);
        self.drop * rounds(hulls) + touch * rounds(pairs) + self.trace * rounds(drops + pairs)
    }
}

/// As many Blenders run side by side as there are threads.
fn rounds(beds: usize) -> f64 {
    beds.div_ceil(rayon::current_num_threads()) as f64
}
