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
        let tolerance = self.options.tolerance();
        let (mut before, mut now) = (Beds::default(), Beds::first(tolerance, keeps_apart));
        let mut is_pair = Vec::new();
        let mut pace = Pace::default();
        if now.drops > 1 {
            self.folder.monitor.say(&report::first_beds(&now, tolerance));
        }
        loop {
            let begun = self.folder.record.stages.len();
            grow(&mut is_pair, now);
            let mut beds = self.drop(prepared, packing, library, &lot_of(&is_pair))?;
            let tables = self.trace(&mut beds, true)?;
            let plan = self.plan_of(&tables, &prepared.wavelengths_um, keeps_apart)?;
            let told = report::plan(&plan, tolerance);
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
        let tolerance = self.options.tolerance();
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

/// Adds beds up to these numbers. What is there stays as it is; of the new beds the first become
/// pairs. Bed 1 is shown, as hulls, and becomes a pair last.
fn grow(is_pair: &mut Vec<bool>, to: Beds) {
    let first_new = is_pair.len().max(1);
    is_pair.resize(to.drops, false);
    let order = (first_new..to.drops).chain((0..first_new.min(to.drops)).rev());
    let missing = to.pairs - is_pair.iter().filter(|pair| **pair).count();
    let alone: Vec<usize> = order.filter(|&bed| !is_pair[bed]).take(missing).collect();
    for bed in alone {
        is_pair[bed] = true;
    }
}

/// The beds of a plan.
fn lot_of(is_pair: &[bool]) -> Lot {
    if is_pair == [false] {
        return bring::lot(1);
    }
    let has_pairs = is_pair.contains(&true);
    let kept = |is_pair| match is_pair {
        true => Kept::Pair,
        false if has_pairs => Kept::Hulls,
        false => Kept::Several,
    };
    is_pair.iter().map(|&is_pair| kept(is_pair)).enumerate().collect()
}

/// The rounds until there are as many beds as come next. In a round each of as many Blenders as there
/// are threads drops one bed as hulls, or works as long on a pair.
fn rounds(now: Beds, next: Beds) -> f64 {
    let [drops, pairs] = [next.drops - now.drops, next.pairs - now.pairs];
    (drops as f64 + COST * pairs as f64) / rayon::current_num_threads().min(drops.max(1)) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beds_that_are_there_stay_as_they_are() {
        let mut is_pair = Vec::new();
        let mut grown = |drops, pairs| {
            grow(&mut is_pair, Beds { drops, pairs });
            let pairs: Vec<usize> = (0..drops).filter(|&bed| is_pair[bed]).collect();
            pairs
        };
        assert_eq!(grown(5, 2), [1, 2]);
        assert_eq!(grown(9, 2), [1, 2]);
        assert_eq!(grown(18, 4), [1, 2, 9, 10]);
        assert_eq!(grown(18, 6), [1, 2, 9, 10, 16, 17]);
        assert_eq!(grown(19, 19).len(), 19);
    }
}
