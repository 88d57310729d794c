//! How many grains a bed needs: the lowest grains of a pilot's beds are taken away, and the rest is
//! traced again by the same paths.
//!
//! A path that does not reach the lowest grains stays the same. So the difference has far less
//! noise than either bed.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::histogram::{Estimate, Histogram, Mean};
use crate::scene::Packing;
use crate::signature::plan::Plan;
use crate::support::error::Error;
use crate::support::monitor::{Interrupted, Monitor};
use crate::support::random::Purpose;
use crate::table::Prepared;
use crate::table::Table;
use crate::tracer::Tracer;
use crate::tracer::rules::TracingRules;

/// The share of the tolerance that grains left out may take.
const MOST: f64 = 0.1;

/// Steps in which the number of grains is searched.
const PARTS: u32 = 20;

/// Fewer grains than a recipe has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Depth {
    /// Grains of the recipe.
    pub of: u32,
    /// Grains that are dropped instead.
    pub grains: u32,
    /// Change by the grains left out, where it is largest: the mean over the pilot's beds and its
    /// 95 % interval.
    pub change: f64,
    /// Where that is, um.
    pub at_um: f64,
}

impl Depth {
    /// The number of grains with which the rest of a plan costs least, if that is fewer than the
    /// recipe has. A grain costs the same in every bed.
    ///
    /// `tried` takes this many of the lowest grains away and returns the change, its band, and the
    /// rest. `planned` returns the plan for a rest and its change.
    pub fn find<T>(
        packing: &Packing,
        plan: &Plan,
        tolerance: f64,
        tried: impl Fn(u32) -> Result<(f64, f64, T), Error>,
        planned: impl Fn(T, f64) -> Result<Plan, Error>,
    ) -> Result<Option<Self>, Error> {
        let of = grains(packing);
        let mut least = of as usize * plan.to_be_dropped();
        let mut found = None;
        let (mut too_few, mut enough) = (0, PARTS);
        while enough - too_few > 1 {
            let parts = u32::midpoint(too_few, enough);
            let grains = grains(&fewer(packing, parts));
            let (change, at_um, rest) = tried(of - grains)?;
            let fits = change <= MOST * tolerance;
            let cost = match fits.then(|| planned(rest, change)).transpose()? {
                // Shallower beds have a pilot of their own, so all of them count.
                Some(rest) if rest.touching == plan.touching => grains as usize * rest.packings,
                _ => usize::MAX,
            };
            if cost < least {
                (enough, least) = (parts, cost);
                found = Some(Self { of, grains, change, at_um });
            } else {
                too_few = parts;
            }
        }
        Ok(found)
    }

    /// The recipe with this number of grains.
    pub fn of(&self, packing: &Packing) -> Packing {
        let mut all = (1..PARTS).map(|parts| fewer(packing, parts));
        all.find(|fewer| grains(fewer) == self.grains).expect("it was found among these")
    }
}

fn grains(packing: &Packing) -> u32 {
    packing.grains.iter().map(|class| class.count).sum()
}

/// The recipe with this many parts of the grains of each class, at least one grain.
fn fewer(packing: &Packing, parts: u32) -> Packing {
    let mut fewer = packing.clone();
    for class in &mut fewer.grains {
        class.count = ((class.count * parts + PARTS / 2) / PARTS).max(class.count.min(1));
    }
    fewer
}

/// The table of a bed without this many of its lowest grains, by the same paths.
pub fn without_lowest(
    tracer: &Tracer,
    prepared: &Prepared,
    table: &Table,
    grains: u32,
    monitor: &dyn Monitor,
) -> Result<Table, Interrupted> {
    let rules =
        TracingRules::new(prepared).ending_below(table.stop.least_weight, &prepared.reflectances);
    let rest = tracer.without_lowest(grains as usize);
    let check = |_| monitor.check();
    let tally = rest.trace(&rules, table.seed, Purpose::Result, 0..table.paths, &check)?;
    let (histogram, cells) = (Histogram::of(&tally), Histogram::by_cell(&tally));
    Ok(Table { histogram, cells, ..table.clone() })
}

/// The difference between beds and others traced by the same paths: its mean and its 95 % interval,
/// in the band where it is largest, and that band, um.
pub fn change(beds: &[Table], others: &[Table], um: &[f64]) -> Result<(f64, f64), Error> {
    let of_band = |(rho, um): (Vec<f64>, &f64)| {
        // The plan counts given-up paths already.
        let less = |(a, b): (&Table, &Table)| Mean {
            trapped: 0.0,
            ..a.histogram.less_weight(&b.histogram, &rho)
        };
        let of = Estimate::of(&beds.iter().zip(others).map(less).collect::<Vec<_>>());
        (of.mean.abs() + of.half_width, *um)
    };
    let bands = beds[0].reflectances(um)?.into_par_iter().zip(um).map(of_band);
    Ok(bands.max_by(|a, b| a.0.total_cmp(&b.0)).expect("there is at least one band"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::Scene;
    use crate::scene::{Grid, SceneGeometry, shipped};
    use crate::support::monitor::Unwatched;
    use crate::table::Target;
    use crate::tracer::trace::{self, Request};

    fn recipe() -> Packing {
        let text = shipped::text("sparse").expect("it is shipped");
        let scene = Scene::parse(text, Path::new("sparse.json")).expect("a scene");
        let SceneGeometry::Packing(packing) = scene.geometry else { panic!("a recipe") };
        packing
    }

    fn plan(packings: usize, touching: bool) -> Plan {
        Plan {
            pilot: 6,
            spread: 0.006,
            at_um: 9.0,
            apart: 0.006,
            touching,
            wanted: packings,
            packings,
            depth: None,
        }
    }

    /// Beds whose grains hide more the more of them there are.
    fn found(plan: &Plan, packings: impl Fn(f64) -> usize) -> Option<Depth> {
        let tried = |taken: u32| {
            let share = 1.0 - f64::from(taken) / 72.0;
            Ok((0.1 * (-10.0 * share).exp(), 9.0, share))
        };
        let planned = |share, _| Ok(Plan { packings: packings(share), ..*plan });
        Depth::find(&recipe(), plan, 0.01, tried, planned).expect("nothing fails")
    }

    #[test]
    fn as_few_grains_are_dropped_as_a_tenth_of_the_tolerance_allows() {
        // exp(-10 share) is .01 at .46: nine twentieths of 24 are 11, ten are 12.
        let depth = found(&plan(6, true), |_| 6).expect("fewer");
        assert_eq!((depth.of, depth.grains, depth.at_um), (72, 36, 9.0));
        assert!(depth.change <= 0.001, "{depth:?}");
        let fewer = depth.of(&recipe());
        assert!(fewer.grains.iter().all(|class| class.count == 12));
        assert_eq!(fewer.tray_um, recipe().tray_um);
    }

    #[test]
    fn grains_stay_where_more_packings_cost_what_they_save() {
        assert_eq!(found(&plan(10, true), |share| (10.0 / share).ceil() as usize), None);
        // A third of the grains pays for one packing more; half of them do not pay for thirty.
        let steps = |share: f64| if share < 0.6 { 40 } else { 11 };
        assert_eq!(found(&plan(10, true), steps).map(|depth| depth.grains), Some(48));
        // The pilot is part of eleven hulls: five more cost less than eleven of half the grains.
        assert_eq!(found(&plan(11, false), |_| 11), None);
        assert_eq!(found(&plan(30, false), |_| 30).map(|depth| depth.grains), Some(36));
    }

    #[test]
    fn a_class_keeps_a_grain() {
        let mut few = recipe();
        few.grains[0].count = 1;
        few.grains[1].count = 0;
        let left: Vec<u32> = fewer(&few, 1).grains.iter().map(|class| class.count).collect();
        assert_eq!(left, [1, 0, 1]);
    }

    /// The same paths give the same bed to the last bit; the more is missing, the more they differ.
    #[test]
    fn deep_grains_change_little_and_no_grain_nothing() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/settled_patch.json");
        let scene = Scene::read(&path).expect("a scene");
        let tracer = trace::tracer(&scene).expect("a bed");
        let grid = Grid::new(8.0, 12.0, 1.0).expect("a grid");
        let target = Target { max_paths: 8192, ..Target::of(0.05) };
        let prepared = Prepared::new(scene, &grid.wavelengths_um()).expect("spectra");
        let request = Request::new(&grid, target);
        let table = trace::trace(&tracer, &prepared, request, &Unwatched).expect("traced");
        let changes = |grains| {
            let rest =
                without_lowest(&tracer, &prepared, &table, grains, &Unwatched).expect("traced");
            let of = [rest.clone(), rest];
            change(&[table.clone(), table.clone()], &of, &grid.wavelengths_um()).expect("bands").0
        };
        let placements = tracer.bed().placements.len() as u32;
        let [none, few, all] = [0, placements / 4, placements].map(changes);
        assert_eq!(none, 0.0);
        assert!(few > 0.0 && few < all / 4.0, "{few} {all}");
        assert_eq!(tracer.without_lowest(2).bed().placements.len() as u32, placements - 2);
    }
}
