//! How a tolerance is reached at the least cost: the number of packings, and whether they are
//! dropped as hulls or until their fines touch.
//!
//! Hulls are cheap, but they keep dust apart. That effect has to fit into the tolerance beside the
//! spread of the packings. If it leaves too little room, fines have to touch.

use serde::{Deserialize, Serialize};

use crate::histogram::estimate::MOST;
use crate::signature::Band;
use crate::signature::budget::{Budget, Share};
use crate::support::statistics::quantile_95;

/// Packings of a pilot. Their spread tells how many the tolerance takes.
pub const PILOT: usize = 6;

/// Packings dropped before a pilot where hulls may keep fines apart. They tell whether the fines of
/// the pilot have to touch; only they are lost then.
pub const LOOK: usize = 2;

/// Most packings of a larger pilot, which follows if the first wants more than twice its own
/// number. Student's t makes the mean take half as many again by the spread of six packings as by
/// that of 24.
const LARGER_PILOT: usize = 24;

/// The cost of a bed whose fines touch, in beds dropped as hulls, with the start of Blender and the
/// trace (docs: performance). Fixed, so that a plan does not depend on the machine.
const COST: f64 = 2.5;

/// The number of packings that a tolerance takes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Plan {
    /// Packings that told it. They are part of the result.
    pub pilot: usize,
    /// Standard deviation between them, in the band that takes the most packings.
    pub spread: f64,
    /// Where that is, um.
    pub at_um: f64,
    /// Effect there of hulls that keep fines apart; 0 where nothing keeps them apart.
    pub apart: f64,
    /// Whether packings are dropped until their fines touch, though the recipe has hulls.
    pub touching: bool,
    /// Packings that the tolerance takes.
    pub wanted: usize,
    /// Packings that are dropped: at most [`MOST`].
    pub packings: usize,
}

impl Plan {
    /// A plan from this many packings and their budget. It is preliminary where fines have to
    /// touch: packings that touch have a pilot of their own.
    ///
    /// Stein's two stages (Ann. Math. Statist. 16, 243 (1945)): with the quantile of the pilot's
    /// own degrees of freedom the mean is within the tolerance at 95 %, however its spread came
    /// out. All packings then make a plan anew: the result ends when their own interval is within
    /// the tolerance.
    pub fn new(pilot: usize, bands: &[Band], budget: &Budget, tolerance: f64) -> Self {
        let takes = |apart: &dyn Fn(&Share) -> f64| {
            let most = bands
                .iter()
                .zip(&budget.bands)
                .map(|(band, share)| {
                    let bounds = share.floor + share.given_up + apart(share);
                    let room = (tolerance - bounds).max(0.0);
                    let spread = band.emissivity.spread.unwrap_or(0.0);
                    let packings = (quantile_95(pilot) * spread / room).powi(2);
                    // No spread and no room.
                    (if packings.is_nan() { f64::INFINITY } else { packings }, band, share)
                })
                .max_by(|a, b| a.0.total_cmp(&b.0));
            most.expect("a pilot has bands")
        };
        let whole = |packings: f64| (packings.ceil().min(1e9) as usize).max(pilot);
        let as_they_are = takes(&|share| share.apart.unwrap_or(0.0));
        let touching = takes(&|_| 0.0);
        let keeps_apart = budget.bands.iter().any(|share| share.apart.is_some());
        let cost = COST * whole(touching.0) as f64;
        let touches = keeps_apart && cost < whole(as_they_are.0) as f64;
        let (packings, band, share) = if touches { touching } else { as_they_are };
        let wanted = whole(packings);
        Self {
            pilot,
            spread: band.emissivity.spread.unwrap_or(0.0),
            at_um: band.wavelength_um,
            apart: share.apart.unwrap_or(0.0),
            touching: touches,
            wanted,
            packings: wanted.min(MOST),
        }
    }

    /// Packings of the larger pilot, if one is needed before all are dropped.
    pub fn larger_pilot(&self) -> Option<usize> {
        (self.pilot == PILOT && self.wanted > 2 * PILOT).then(|| self.wanted.min(LARGER_PILOT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::histogram::{Estimate, Mean};
    use crate::support::random::{Purpose, Source};

    fn mean(mean: f64) -> Mean {
        Mean { mean, standard_error: 0.0, trapped: 0.0 }
    }

    fn plan(packings: &[Mean], apart: Option<f64>, tolerance: f64) -> Plan {
        let bands = [Band { emissivity: Estimate::of(packings), ..Band::default() }];
        let share = Share { apart, ..Share::default() };
        let budget = Budget { bands: vec![share], spectra_unknown: Vec::new(), floor_effect: None };
        Plan::new(packings.len(), &bands, &budget, tolerance)
    }

    /// Pilots and results of normally distributed packings.
    #[test]
    fn a_planned_mean_is_within_the_tolerance_as_often_as_promised() {
        let mut random = Source::new(11, Purpose::Packing).stream(0);
        let mut normal = || {
            let [u, v] = random.pair();
            (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        };
        let (mut held, runs) = (0, 4000);
        for _ in 0..runs {
            let mut packings: Vec<Mean> = Vec::new();
            let mut drop = |packings: &mut Vec<Mean>, n: usize| {
                while packings.len() < n {
                    packings.push(mean(0.0066 * normal()));
                }
            };
            drop(&mut packings, PILOT);
            let mut planned = plan(&packings, None, 0.002);
            if let Some(pilot) = planned.larger_pilot() {
                drop(&mut packings, pilot);
                planned = plan(&packings, None, 0.002);
            }
            assert_eq!(planned.larger_pilot(), None);
            while planned.packings > packings.len() {
                drop(&mut packings, planned.packings);
                planned = plan(&packings, None, 0.002);
            }
            let estimate = Estimate::of(&packings);
            assert!(estimate.half_width <= 0.002);
            held += u32::from(estimate.mean.abs() <= 0.002);
        }
        let share = f64::from(held) / f64::from(runs);
        // The 95 % interval of 4000 trials is +-0.7 %. A small spread of the first pilot may spare
        // the larger one, which costs up to a per cent; rounding to whole packings gains some.
        assert!((0.933..0.97).contains(&share), "{share}");
    }

    #[test]
    fn fines_touch_where_the_effect_of_hulls_leaves_too_little_room() {
        let pilot = [0.1, 0.102, 0.099, 0.101, 0.1, 0.098].map(mean);
        let of = |tolerance| plan(&pilot, Some(0.006), tolerance);
        let loose = of(0.02);
        assert_eq!((loose.touching, loose.packings), (false, PILOT));
        // A spread of .0014 in room of .001 takes eleven hulls: less than the cost of 6 that touch.
        let narrow = of(0.0071);
        assert!(!narrow.touching && narrow.packings > PILOT, "{narrow:?}");
        let none = of(0.006);
        assert_eq!((none.touching, none.packings), (true, PILOT));
        // Without fines there is nothing to touch.
        assert!(!plan(&pilot, None, 0.0001).touching);
    }
}
