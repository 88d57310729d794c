//! How a tolerance is reached at the least cost: the number of beds, and how many of them are
//! dropped on until their fines touch.

use serde::{Deserialize, Serialize};

use super::levels::{MANY, Parts};
use crate::histogram::estimate::MOST;
use crate::scene::Collision;
use crate::signature::budget::{Budget, Share};
use crate::signature::{Band, Levels};

/// Tolerances from which on one bed may be enough: the totals of shipped ones are .02 to .03.
const OF_ONE: f64 = 0.02;

/// Beds of a pilot, whose spread tells how many the tolerance takes; pairs only where hulls keep
/// fines apart.
const PILOT: Beds = Beds { drops: 6, pairs: 2 };

/// The pilot of a small tolerance: a spread of few beds wants too many.
const LARGER_PILOT: Beds = Beds { drops: 8, pairs: 3 };

/// Tolerances that are small in this sense.
const SMALL: f64 = 0.0075;

/// The cost of dropping a bed on until its fines touch, in beds dropped as hulls, with their traces
/// (docs: stages). Fixed, so that a plan does not depend on the machine.
pub const COST: f64 = Collision::HullThenFines.cost() - 1.0;

/// Most drops for each pair.
const MOST_FOR_A_PAIR: usize = 5;

/// Beds at which a plan ends whose rim alone leaves no room: that is no chance any more.
const NO_ROOM: usize = 40;

/// The most that one step multiplies the beds by.
const MOST_AT_ONCE: usize = 4;

/// Numbers of beds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Beds {
    /// Drops.
    pub drops: usize,
    /// How many of them are there as hulls and with fines that touch.
    pub pairs: usize,
}

impl Beds {
    /// The beds that tell how many a tolerance takes.
    pub fn first(tolerance: f64, keeps_apart: bool) -> Self {
        match tolerance {
            OF_ONE.. => Self { drops: 1, pairs: 0 },
            SMALL.. => Self::pilot(PILOT, keeps_apart),
            _ => Self::pilot(LARGER_PILOT, keeps_apart),
        }
    }

    fn pilot(beds: Self, keeps_apart: bool) -> Self {
        if keeps_apart { beds } else { Self { pairs: 0, ..beds } }
    }

    /// The beds that come next where so many are wanted by all that these tell.
    fn towards(self, wanted: Self, has_rim: bool) -> Self {
        let step = |now: usize, wanted: usize| {
            let half = wanted.div_ceil(2).max(wanted.min(2 * now));
            half.min(MOST_AT_ONCE * now).min(MOST)
        };
        let drops = match wanted.drops {
            // The rim is in the way, or the rounding of the plan was a little too good.
            drops if wanted == self && has_rim => 2 * drops,
            drops if wanted == self => drops + drops.div_ceil(8),
            drops if drops <= 2 * self.drops => drops,
            drops => step(self.drops, drops),
        };
        let pairs = if wanted.drops <= 2 * self.drops {
            wanted.pairs
        } else {
            step(self.pairs, wanted.pairs)
        };
        let drops = drops.min(MOST);
        // The spread of few changes may be small by luck.
        let least = if self.pairs > 0 { drops.div_ceil(MOST_FOR_A_PAIR) } else { 0 };
        Self { drops, pairs: pairs.max(least).min(drops) }
    }
}

/// What beds tell of how many a tolerance takes. Half-widths and spreads are those of emissivity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Plan {
    /// The beds that told it. They are part of the result.
    pub by: Beds,
    /// The band whose total is widest, um.
    pub at_um: f64,
    /// Its total, of these beds.
    pub total: f64,
    /// The bounds in it.
    pub bounds: f64,
    /// Standard deviation between drops there; `None` of a single one.
    pub spread: Option<f64>,
    /// Standard deviation there of what touching fines change; `None` without pairs.
    pub spread_of_change: Option<f64>,
    /// The beds that the tolerance takes, by what is known. `None` where the bounds leave no room.
    pub wanted: Option<Beds>,
    /// The beds that come next; the same as before where the plan ends.
    pub next: Beds,
}

impl Plan {
    /// The plan by beds of which each table has its emissivity in each band.
    ///
    /// Three stages (Hall, Ann. Statist. 9, 1229 (1981)): with the quantile of their own degrees of
    /// freedom some beds tell how many are wanted. Of many more than there are, half come first
    /// and tell it better. All beds then make a plan anew, until their own total is within the
    /// tolerance.
    pub fn new(
        levels: &Levels,
        curves: &[Vec<f64>],
        bands: &[Band],
        budget: &Budget,
        tolerance: f64,
        keeps_apart: bool,
    ) -> Self {
        let by = Beds { drops: levels.drops(), pairs: levels.pairs() };
        let widest = budget.widest();
        let is_widest = |band: &Band| band.wavelength_um == widest.wavelength_um;
        let at = bands.iter().position(is_widest).expect("it is one of the bands");
        let of_band =
            |band: usize| -> Vec<f64> { curves.iter().map(|curve| curve[band]).collect() };
        let parts = |band: usize| {
            let cells = budget.by_cells.as_ref().map(|cells| cells[band]);
            levels.parts(&of_band(band), cells)
        };
        let there = parts(at);
        let plan = Self {
            by,
            at_um: widest.wavelength_um,
            total: widest.total,
            bounds: widest.bounds(),
            spread: (by.drops > 1).then(|| there.first.sqrt()),
            spread_of_change: (by.pairs > 1).then(|| there.of_change()),
            wanted: Some(by),
            next: by,
        };
        if widest.total <= tolerance {
            return plan;
        }
        // The spread of fewer beds tells too little.
        if by.drops < MANY {
            return Self { wanted: None, next: Beds::pilot(PILOT, keeps_apart), ..plan };
        }
        // Of few beds the rim is mostly chance, and more beds lessen it.
        let without_rim = |share: &Share| tolerance - share.bounds() + share.rim.unwrap_or(0.0);
        let bands: Vec<(Parts, f64)> = budget
            .bands
            .iter()
            .enumerate()
            .map(|(band, share)| (parts(band), without_rim(share)))
            .collect();
        let rim = budget.bands.iter().filter_map(|share| share.rim).fold(0.0, f64::max);
        let is_stuck = rim >= tolerance && by.drops >= NO_ROOM;
        let wanted = wanted(by, &bands).filter(|_| !is_stuck);
        let next = wanted.map_or(by, |wanted| by.towards(wanted, rim > 0.0));
        Self { wanted, next, ..plan }
    }

    /// Whether no further beds come.
    pub fn is_done(&self) -> bool {
        self.next == self.by
    }
}

/// The cheapest numbers of beds by which every band has its room; `None` where there is none.
fn wanted(by: Beds, bands: &[(Parts, f64)]) -> Option<Beds> {
    // The variance that each band may have.
    let most: Vec<(&Parts, f64)> = bands
        .iter()
        .map(|(parts, room)| (*room > 0.0).then(|| (parts, (room / parts.quantile).powi(2))))
        .collect::<Option<_>>()?;
    let fits = |drops: f64, pairs: f64| {
        most.iter().all(|(parts, most)| parts.variance(drops, pairs) <= *most)
    };
    let drops_for = |pairs: usize| -> Option<usize> {
        let fits = |drops: usize| fits(drops as f64, pairs as f64);
        let least = by.drops.max(pairs);
        let most = (0..20).map(|power| least << power).find(|&drops| fits(drops))?;
        let (mut too_few, mut enough) = (least.saturating_sub(1), most);
        while enough - too_few > 1 {
            let middle = usize::midpoint(too_few, enough);
            if fits(middle) { enough = middle } else { too_few = middle }
        }
        Some(enough)
    };
    let cost = |beds: &Beds| beds.drops as f64 + COST * beds.pairs as f64;
    // Numbers of pairs some eighth apart.
    let further = |pairs: &usize| Some(pairs + (pairs / 8).max(1));
    let pairs = std::iter::successors(Some(by.pairs), further).take_while(|&pairs| pairs <= MOST);
    let pairs = pairs.take(if by.pairs == 0 { 1 } else { usize::MAX });
    pairs
        .filter_map(|pairs| Some(Beds { drops: drops_for(pairs)?, pairs }))
        .min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

#[cfg(test)]
mod tests;
