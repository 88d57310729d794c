//! The joint histogram of what paths did, and what it gives for any reflectances.
//!
//! It is all that spectra need to know of a traced bed: it is evaluated without tracing again.

pub mod estimate;
mod evaluate;
pub mod kept;
mod mean;
mod shares;
pub mod tally;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use crate::support::random::GROUPS;
use kept::Kept;
use tally::{CELLS, Counts, Outcomes, State, Tally};

pub use estimate::Estimate;
pub(crate) use evaluate::{Evaluator, LANES, Seen};
pub use evaluate::{Radiance, Sources};
pub use mean::Mean;
pub(crate) use mean::Sums;
pub use shares::Shares;

/// A state and the parts of paths of each group that ended in it.
pub type Counted = (State, Vec<(u16, i64)>);

/// How many parts of the paths of each group ended in which state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Histogram {
    /// What the states record.
    pub kept: Kept,
    /// Parts of a path.
    pub parts: u64,
    /// States of the parts that reached the sky, in lexical order.
    pub escaped: Vec<Counted>,
    /// States of those that were given up, in lexical order.
    #[serde(rename = "trapped")]
    pub given_up: Vec<Counted>,
    /// Parts that Russian roulette ended, less those that it added, by group. They bring nothing to
    /// the sky; with them the parts add up to the paths.
    #[serde(rename = "ended")]
    pub rouletted: Vec<(u16, i64)>,
}

/// Cells of the view are summed as groups are.
const _: () = assert!((CELLS * CELLS) as usize <= GROUPS);

impl Histogram {
    /// The histogram of a tally.
    pub fn of(tally: &Tally) -> Self {
        Self::of_outcomes(tally.kept(), &tally.by_group)
    }

    /// The same by cells of the view in place of groups; `None` where the view has none.
    pub fn by_cell(tally: &Tally) -> Option<Self> {
        let cells = &tally.by_cell;
        (*cells != Outcomes::default()).then(|| Self::of_outcomes(tally.kept(), cells))
    }

    fn of_outcomes(kept: Kept, outcomes: &Outcomes) -> Self {
        Self {
            kept,
            parts: kept.parts(),
            escaped: grouped(&outcomes.escaped),
            given_up: grouped(&outcomes.given_up),
            rouletted: outcomes.rouletted.iter().map(|(&group, &parts)| (group, parts)).collect(),
        }
    }

    /// The counts as they were before they were grouped.
    pub(crate) fn outcomes(&self) -> Outcomes {
        let ungrouped = |states: &[Counted]| -> Counts {
            let keys = |(state, of): &Counted| -> Vec<(State, i64)> {
                let key = |group| state.iter().copied().chain([group]).collect();
                of.iter().map(|&(group, parts)| (key(group), parts)).collect()
            };
            states.iter().flat_map(keys).collect()
        };
        Outcomes {
            escaped: ungrouped(&self.escaped),
            given_up: ungrouped(&self.given_up),
            rouletted: self.rouletted.iter().copied().collect(),
        }
    }

    /// A histogram of no path.
    pub fn empty(kept: Kept) -> Self {
        Self::of_outcomes(kept, &Outcomes::default())
    }

    /// As JSON of an object one level deep in another, one state a line.
    pub(crate) fn json(&self) -> String {
        let plain = "a histogram is plain data";
        let kept = serde_json::to_string(&self.kept).expect(plain);
        let ended = serde_json::to_string(&self.rouletted).expect(plain);
        let [escaped, trapped] = [&self.escaped, &self.given_up].map(|states| {
            let lines: Vec<String> = states
                .iter()
                .map(|state| format!("\n      {}", serde_json::to_string(state).expect(plain)))
                .collect();
            let end = if lines.is_empty() { "" } else { "\n    " };
            format!("[{}{end}]", lines.join(","))
        });
        let parts = self.parts;
        format!(
            "{{\n    \"kept\": {kept},\n    \"parts\": {parts},\n    \"escaped\": {escaped},\n    \
             \"trapped\": {trapped},\n    \"ended\": {ended}\n  }}"
        )
    }

    /// Number of paths.
    pub fn paths(&self) -> f64 {
        self.by_group().map(|(_, parts)| parts).sum::<i64>() as f64 / self.parts as f64
    }

    /// Number of paths given up, those given up in part by their share.
    pub fn paths_given_up(&self) -> f64 {
        totals(&self.given_up).map(|(_, parts)| parts).sum::<i64>() as f64 / self.parts as f64
    }

    /// Whether both count the same paths, in whatever groups.
    pub(crate) fn counts_as(&self, other: &Self) -> bool {
        let alike = |ours: &[Counted], theirs: &[Counted]| totals(ours).eq(totals(theirs));
        let rouletted = |of: &Self| of.rouletted.iter().map(|(_, parts)| parts).sum::<i64>();
        self.kept == other.kept
            && rouletted(self) == rouletted(other)
            && alike(&self.escaped, &other.escaped)
            && alike(&self.given_up, &other.given_up)
    }

    /// Checks a histogram from a file: for so many materials and groups or cells.
    pub(crate) fn check(&self, materials: usize, groups: usize) -> Result<(), String> {
        let kept = self.kept;
        let symbols = kept.symbols(materials);
        let fits = |hits: &[u16]| {
            if kept.lists() {
                hits.iter().all(|&symbol| usize::from(symbol) < symbols)
            } else {
                hits.len() == materials
            }
        };
        // A path may be given up before its first hit, but does not escape before it.
        let escapes = |(state, _): &Counted| {
            let (hits, bin) = kept.split(state);
            !hits.is_empty() && fits(hits) && bin < kept.zeniths.into()
        };
        let mut counts = self.escaped.iter().chain(&self.given_up).flat_map(|(_, parts)| parts);
        Err(if self.parts != kept.parts() {
            format!("a path has {} parts, not {}", self.parts, kept.parts())
        } else if kept.cosines == 0 || kept.zeniths == 0 {
            "a number of bins is 0".into()
        } else if self.by_group().any(|(group, _)| usize::from(group) >= groups) {
            format!("a group or cell is not within 0 to {}", groups - 1)
        } else if counts.any(|(_, parts)| *parts < 0) {
            "a count is below 0".into()
        } else if !self.escaped.iter().all(escapes)
            || !self.given_up.iter().all(|(state, _)| fits(state))
        {
            "a state does not fit the materials and what is recorded of a path".into()
        } else if kept.order && !self.rouletted.is_empty() {
            "paths that record the order of hits are not ended by roulette".into()
        } else {
            return Ok(());
        })
    }

    /// Parts of paths that met the target, by group.
    pub(crate) fn met(&self) -> [f64; GROUPS] {
        let mut met = [0.0; GROUPS];
        for (group, parts) in self.by_group() {
            met[usize::from(group)] += parts as f64;
        }
        met
    }

    /// All counts, by group or cell.
    fn by_group(&self) -> impl Iterator<Item = (u16, i64)> {
        let states = self.escaped.iter().chain(&self.given_up).flat_map(|(_, parts)| parts);
        states.chain(&self.rouletted).copied()
    }
}

/// The parts of each state, of all groups.
fn totals(counted: &[Counted]) -> impl Iterator<Item = (&State, i64)> {
    counted.iter().map(|(state, of)| (state, of.iter().map(|(_, parts)| parts).sum()))
}

fn grouped(counts: &Counts) -> Vec<Counted> {
    // Sorted by whole keys, a state would be torn apart by those that begin with it.
    let mut list: Vec<(&[u16], u16, i64)> = Vec::with_capacity(counts.len());
    for (key, &count) in counts {
        let (&group, state) = key.split_last().expect("a key ends with its group");
        list.push((state, group, count));
    }
    list.sort_unstable();
    let of_state = |of: &[(&[u16], u16, i64)]| {
        (of[0].0.into(), of.iter().map(|&(_, group, parts)| (group, parts)).collect())
    };
    list.chunk_by(|a, b| a.0 == b.0).map(of_state).collect()
}
