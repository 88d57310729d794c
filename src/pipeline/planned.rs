//! A planned run: beds until the total is within the tolerance.

use super::bring::{Kept, Lot};
use super::{Bed, Run};
use crate::beds::Failed;
use crate::beds::own_grains::OwnGrains;
use crate::blender::BlenderError;
use crate::report;
use crate::scene::{Origin, Packing};
use crate::signature::budget::Budget;
use crate::signature::plan::{Beds, COST, Plan};
use crate::signature::{self, Levels};
use crate::support::error::Error;
use crate::support::output;
use crate::table::{Prepared, Table};

/// Wall time of a round of the last stages, seconds.
#[derive(Clone, Copy, Default)]
struct Pace {
    drop: f64,
    trace: f64,
}

/// What a run of several stages, or of one, leaves.
pub(super) struct Dropped {
    pub(super) beds: Vec<Bed>,
    pub(super) tables: Vec<Table>,
    /// The plan by which they are enough.
    pub(super) plan: Option<Plan>,
    /// Why Blender refused beds for which others stand.
    pub(super) refused: Vec<String>,
}

impl Dropped {
    /// Of a run whose number of beds was given.
    pub(super) fn of(beds: Vec<Bed>, tables: Vec<Table>) -> Self {
        Self { beds, tables, plan: None, refused: Vec::new() }
    }
}

/// Of so many beds one may be refused, and another stands for it. Of more the recipe is at fault.
const FOR_A_REFUSED: usize = 20;

impl Run<'_> {
    /// As many beds as the tolerance takes, of which some are dropped on until their fines touch if
    /// hulls keep them apart.
    pub(super) fn planned(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&OwnGrains>,
    ) -> Result<Dropped, Error> {
        let keeps_apart = packing.origin() == Origin::DrawnApart;
        let tolerance = self.options.tolerance();
        let (mut before, mut now) = (Beds::default(), Beds::first(tolerance, keeps_apart));
        let mut chosen = Chosen::default();
        let mut pace = Pace::default();
        if now.drops > 1 {
            let seconds = rounds(before, now) * bed_seconds(packing);
            self.folder.monitor.say(&report::first_beds(&now, tolerance, seconds));
        }
        loop {
            let begun = self.folder.record.stages.len();
            chosen.grow(now);
            let mut beds = self.drop_chosen(prepared, packing, library, &mut chosen)?;
            let tables = self.trace(&mut beds, true)?;
            let plan = self.plan_of(&tables, &prepared.wavelengths_um, keeps_apart)?;
            let told = report::plan(&plan, tolerance);
            if plan.is_done() {
                if now.drops > 1 {
                    self.folder.monitor.say(&format!("plan: {told}"));
                }
                return Ok(Dropped { beds, tables, plan: Some(plan), refused: chosen.refused });
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

    /// Drops the chosen beds. The next bed of the recipe stands for one that Blender refuses.
    fn drop_chosen(
        &mut self,
        prepared: &Prepared,
        packing: &Packing,
        library: Option<&OwnGrains>,
        chosen: &mut Chosen,
    ) -> Result<Vec<Bed>, Error> {
        loop {
            let Failed { bed, error } = match self.drop(prepared, packing, library, &chosen.lot()) {
                Ok(beds) => return Ok(beds),
                Err(failed) => failed,
            };
            let Some(bed) = bed.filter(|_| chosen.may_replace()) else { return Err(error) };
            let refused = error.downcast::<BlenderError>()?;
            if let Some(log) = refused.log() {
                output::remove(log)?;
            }
            let why = chosen.replace(bed, &refused);
            self.folder.monitor.say(&format!("warning: {why}"));
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

/// The beds of a plan so far.
#[derive(Default)]
struct Chosen {
    /// The number of each among the recipe's beds, and whether it is a pair.
    beds: Vec<(usize, bool)>,
    /// Why others are not among them.
    refused: Vec<String>,
}

impl Chosen {
    /// The first number that no bed has had.
    fn next(&self) -> usize {
        self.beds.len() + self.refused.len()
    }

    /// Adds beds up to these numbers. What is there stays as it is; of the new beds the first become
    /// pairs. The first bed is shown, as hulls, and becomes a pair last.
    fn grow(&mut self, to: Beds) {
        let first_new = self.beds.len().max(1);
        while self.beds.len() < to.drops {
            self.beds.push((self.next(), false));
        }
        let order = (first_new..to.drops).chain((0..first_new.min(to.drops)).rev());
        let missing = to.pairs - self.beds.iter().filter(|(_, is_pair)| *is_pair).count();
        let alone: Vec<usize> = order.filter(|&bed| !self.beds[bed].1).take(missing).collect();
        for bed in alone {
            self.beds[bed].1 = true;
        }
    }

    fn lot(&self) -> Lot {
        let several = self.beds.len() > 1;
        let has_pairs = self.beds.iter().any(|(_, is_pair)| *is_pair);
        let kept = |is_pair| match is_pair {
            true => Kept::Pair,
            false if has_pairs => Kept::Hulls,
            false if several => Kept::Several,
            false => Kept::One,
        };
        self.beds.iter().map(|&(number, is_pair)| (number, kept(is_pair))).collect()
    }

    fn may_replace(&self) -> bool {
        self.refused.len() < self.beds.len().div_ceil(FOR_A_REFUSED)
    }

    /// Takes the next bed in the place of one that was refused; says so.
    fn replace(&mut self, bed: usize, why: &BlenderError) -> &str {
        let (next, refused) = (self.next(), self.beds[bed].0);
        self.beds[bed].0 = next;
        self.refused.push(format!("bed {} stands for bed {}: {why}", next + 1, refused + 1));
        self.refused.last().expect("it was pushed")
    }
}

/// The rounds until there are as many beds as come next. In a round each of as many Blenders as there
/// are threads drops one bed as hulls, or works as long on a pair.
fn rounds(now: Beds, next: Beds) -> f64 {
    let [drops, pairs] = [next.drops - now.drops, next.pairs - now.pairs];
    (drops as f64 + COST * pairs as f64) / rayon::current_num_threads().min(drops.max(1)) as f64
}

/// Seconds that one thread takes for a bed of hulls with its trace, by the shipped recipes (docs:
/// stages): what is known before the first bed.
fn bed_seconds(packing: &Packing) -> f64 {
    0.035 * packing.grains.iter().map(|grain| f64::from(grain.count)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beds_that_are_there_stay_as_they_are() {
        let mut chosen = Chosen::default();
        let mut grown = |drops, pairs| {
            chosen.grow(Beds { drops, pairs });
            let pairs: Vec<usize> = (0..drops).filter(|&bed| chosen.beds[bed].1).collect();
            pairs
        };
        assert_eq!(grown(5, 2), [1, 2]);
        assert_eq!(grown(9, 2), [1, 2]);
        assert_eq!(grown(18, 4), [1, 2, 9, 10]);
        assert_eq!(grown(18, 6), [1, 2, 9, 10, 16, 17]);
        assert_eq!(grown(19, 19).len(), 19);
    }

    #[test]
    fn the_next_bed_stands_for_a_refused_one() {
        let mut chosen = Chosen::default();
        chosen.grow(Beds { drops: 6, pairs: 2 });
        assert!(chosen.may_replace());
        chosen.replace(1, &BlenderError::Interrupted);
        let numbers: Vec<usize> = chosen.beds.iter().map(|(number, _)| *number).collect();
        assert_eq!(numbers, [0, 6, 2, 3, 4, 5]);
        assert!(!chosen.may_replace());
        chosen.grow(Beds { drops: 21, pairs: 2 });
        assert_eq!(chosen.beds[20], (21, false));
        assert!(chosen.may_replace());
    }
}
