//! A planned run: beds until the total is within the tolerance.

use super::bring::{self, Kept, Lot};
use super::{Bed, Run};
use crate::beds::own_grains::OwnGrains;
use crate::report;
use crate::scene::{Origin, Packing};
use crate::signature::budget::Budget;
use crate::signature::plan::{Beds, COST, Plan};
use crate::signature::{self, Levels};
use crate::support::error::Error;
use crate::table::{Prepared, Table};

/// Wall time of a round of the last stages, seconds.
#[derive(Clone, Copy, Default)]
struct Pace {
    drop: f64,
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
        let (mut before, mut now) = (Beds { drops: 0, pairs: 0 }, Beds { drops: 1, pairs: 0 });
        let mut pace = Pace::default();
        loop {
            let begun = self.folder.record.stages.len();
            let mut beds = self.drop(prepared, packing, library, &lot_of(now))?;
            let tables = self.trace(&mut beds, true)?;
            let plan = self.plan_of(&tables, &prepared.wavelengths_um, keeps_apart)?;
            let told = report::plan(&plan, self.options.tolerance);
            if plan.is_done() {
                if now.drops > 1 {
                    self.folder.monitor.say(&format!("plan: {told}"));
                }
                return Ok((beds, tables, Some(plan)));
            }
            self.clock(&mut pace, begun, rounds(before, now));
            let time = report::duration((pace.drop + pace.trace) * rounds(now, plan.next));
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

    /// Takes the times of the stages since `begun`, which took so many rounds.
    fn clock(&self, pace: &mut Pace, begun: usize, rounds: f64) {
        for (of, name) in [(&mut pace.drop, "drop"), (&mut pace.trace, "trace")] {
            let key = self.folder.key(name);
            let stages = &self.folder.record.stages[begun..];
            if let Some(stage) = stages.iter().find(|stage| stage.name == key && !stage.cached) {
                *of = stage.seconds / rounds;
            }
        }
    }
}

/// The beds of a plan. The first stays as it is when some become pairs: it is there already.
fn lot_of(now: Beds) -> Lot {
    if now == (Beds { drops: 1, pairs: 0 }) {
        return bring::lot(1);
    }
    let is_pair = |bed: usize| now.pairs == now.drops || (1..=now.pairs).contains(&bed);
    let kept = |bed| match is_pair(bed) {
        true => Kept::Pair,
        false if now.pairs > 0 => Kept::Hulls,
        false => Kept::Several,
    };
    (0..now.drops).map(|bed| (bed, kept(bed))).collect()
}

/// The rounds until there are as many beds as come next. In a round each of as many Blenders as there
/// are threads drops one bed as hulls, or works as long on a pair.
fn rounds(now: Beds, next: Beds) -> f64 {
    let [drops, pairs] = [next.drops - now.drops, next.pairs - now.pairs];
    (drops as f64 + COST * pairs as f64) / rayon::current_num_threads().min(drops.max(1)) as f64
}
