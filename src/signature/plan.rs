//! How a tolerance is reached at the least cost: the number of beds, and how many of them are
//! dropped on until their fines touch.

use serde::{Deserialize, Serialize};

use super::levels::{MANY, Parts};
use crate::histogram::estimate::MOST;
use crate::signature::budget::Budget;
use crate::signature::{Band, Levels};

/// Beds of a pilot. Their spread tells how many the tolerance takes.
pub const PILOT: usize = MANY;

/// Pairs of a pilot where hulls keep fines apart.
const PILOT_PAIRS: usize = 3;

/// The cost of dropping a bed on until its fines touch, in beds dropped as hulls, with their traces
/// (docs: stages). Fixed, so that a plan does not depend on the machine.
pub const COST: f64 = 2.0;

/// Beds at which a plan ends whose bounds leave no room: more beds would not help.
const NO_ROOM: usize = 4 * PILOT;

/// Numbers of beds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Beds {
    /// Drops.
    pub drops: usize,
    /// How many of them are there as hulls and with fines that touch.
    pub pairs: usize,
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
    /// The part of it that no further bed makes smaller.
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
    /// Stein's two stages (Ann. Math. Statist. 16, 243 (1945)), repeated: with the quantile of their
    /// own degrees of freedom some beds tell how many are wanted. All beds then make a plan anew,
    /// until their own total is within the tolerance. No step more than doubles the beds, since
    /// the quantile of a few makes them want too many.
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
        let there = levels.parts(&of_band(at));
        let has_spread = by.drops > 1;
        let plan = Self {
            by,
            at_um: widest.wavelength_um,
            total: widest.total,
            bounds: widest.bounds(),
            spread: has_spread.then(|| there.first.sqrt()),
            spread_of_change: (by.pairs > 1).then(|| there.of_change()),
            wanted: Some(by),
            next: by,
        };
        if widest.total <= tolerance {
            return plan;
        }
        if by.drops < PILOT {
            let next = Beds { drops: PILOT, pairs: if keeps_apart { PILOT_PAIRS } else { 0 } };
            return Self { wanted: None, next, ..plan };
        }
        let bands: Vec<(Parts, f64)> = budget
            .bands
            .iter()
            .enumerate()
            .map(|(band, share)| (levels.parts(&of_band(band)), tolerance - share.bounds()))
            .collect();
        let wanted = wanted(by, &bands);
        let twice = |now: usize, wanted: usize| wanted.clamp(now, 2 * now).min(MOST);
        let next = match wanted {
            Some(wanted) => {
                let next = Beds {
                    drops: twice(by.drops, wanted.drops),
                    pairs: twice(by.pairs, wanted.pairs),
                };
                // The quantile or the rounding of the plan was a little too good.
                let more = Beds { drops: (by.drops + by.drops.div_ceil(8)).min(MOST), ..by };
                if next == by { more } else { next }
            }
            None if by.drops < NO_ROOM => Beds { drops: 2 * by.drops, pairs: 2 * by.pairs },
            None => by,
        };
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
