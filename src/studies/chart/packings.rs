//! The settings of a packing: the ways to make its beds, and their number.

use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;

use super::{REPEATS, Reference, Run, Setting, Took, Trade, timed};
use crate::beds::own_grains::OwnGrains;
use crate::beds::{Order, Wanted};
use crate::blender::Blender;
use crate::scene::{Collision, Fines, Grid, Packing, Scene, SceneGeometry};
use crate::signature;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::monitor::{Monitor, Silently, Step};
use crate::support::random;
use crate::support::scratch::Scratch;
use crate::table::{Prepared, Table, TableMaterial, Target};
use crate::tracer::trace::{self, Request};

/// The tolerance of the rays of each bed, as in planned runs: small compared with what touching
/// fines change.
const RAYS: f64 = 0.0012;
/// Beds of the reference.
const REFERENCE: usize = 48;
/// Seeds of the reference are not among those of the settings.
const REFERENCE_SEED: u64 = 1 << 40;
/// The most beds in a mean.
const MOST: usize = 8;
/// The same for some of the cheap levels.
const SOME: usize = 4;
/// The same for beds as given, of which there are most where beds are in levels.
const GIVEN: usize = 16;

/// How the beds of a chart are made.
pub struct Maker<'a> {
    /// The Blender that drops them.
    pub blender: &'a Blender,
    /// The bands.
    pub grid: &'a Grid,
    /// Time limit for each bed.
    pub time_limit: Duration,
    /// Watches the work and can stop it.
    pub monitor: &'a dyn Monitor,
}

/// Beds of one recipe.
struct Pool {
    tables: Vec<Table>,
    /// Time for each of many, to drop it.
    drop: Took,
    /// The same to trace it.
    trace: Took,
}

/// A level: its name, the most beds in a mean, its change of the recipe.
type Level = (&'static str, usize, fn(&mut Packing));

const LEVELS: [Level; 12] = [
    ("half the tray", SOME, |packing| widen(packing, 0.5)),
    ("twice the tray", 1, |packing| widen(packing, 2.0)),
    ("half the grains in the tray", 1, |packing| {
        packing.grains.iter_mut().for_each(|class| class.count = class.count.div_ceil(2));
    }),
    ("no rim left out", 1, |packing| packing.crop_um = 0.0),
    ("half the rim left out", 1, |packing| packing.crop_um /= 2.0),
    ("4 substeps", 1, |packing| packing.drop.substeps = 4),
    ("10 substeps", 1, |packing| packing.drop.substeps = 10),
    ("1 variant of a grain", 1, |packing| packing.variants = 1),
    ("fewest facets of fines", 1, |packing| {
        packing.fines.iter_mut().for_each(|class| class.ribs = Some(0));
    }),
    ("most facets of fines", 1, |packing| {
        packing.fines.iter_mut().for_each(|class| class.ribs = Some(2));
    }),
    ("fewest facets of grains", 1, |packing| {
        packing.grains.iter_mut().for_each(|class| class.ribs = Some(0));
    }),
    (TOUCH, MOST, touch),
];

/// The level whose beds make pairs with those as given.
const TOUCH: &str = "fines touch";

/// Drops for each pair where beds are in levels.
const FOR_A_PAIR: usize = 4;

fn touch(packing: &mut Packing) {
    packing.drop.collision = Collision::HullThenFines;
}

/// Multiplies the area of the tray and the number of grains.
fn widen(packing: &mut Packing, factor: f64) {
    for length in &mut packing.tray_um {
        *length *= factor.sqrt();
    }
    for class in &mut packing.grains {
        class.count = (f64::from(class.count) * factor).round().max(1.0) as u32;
    }
}

/// Measures the settings of a packing. Nothing comes from a cache, because the work is timed.
pub fn packings(
    scene: &Scene,
    packing: &Packing,
    maker: &Maker,
    quick: bool,
) -> Result<Trade, Error> {
    let say = |what: &str| maker.monitor.say(&format!("measuring: {what}"));
    let prepared = Prepared::new(scene.clone(), &maker.grid.wavelengths_um())?;
    let beds = |most: usize| if quick { REPEATS } else { REPEATS * most };
    say("reference");
    let truth = maker.pool(&prepared, packing, REFERENCE, REFERENCE_SEED, touch)?;
    let bands = truth.tables[0].reflectances(&maker.grid.wavelengths_um())?;
    let estimates: Vec<_> =
        bands.iter().map(|rho| signature::emissivity(&truth.tables, rho)).collect();
    let reference = Reference {
        made_of: format!("{REFERENCE} beds of other seeds whose fines touch (`hull_then_fines`)"),
        emissivity: estimates.iter().map(|e| e.mean).collect(),
        standard_error: estimates.iter().map(|e| e.standard_error).collect(),
    };
    let mut settings = Vec::new();
    say("as given");
    let given = maker.pool(&prepared, packing, beds(GIVEN), packing.seed, |_| ())?;
    let as_given = match packing.drop.collision {
        Collision::Hull => "as given: hulls",
        _ => "as given",
    };
    settings.extend(given.settings(as_given, &bands, &reference));
    for (level, most, change) in LEVELS {
        say(level);
        match maker.pool(&prepared, packing, beds(most), packing.seed, change) {
            Ok(pool) => {
                settings.extend(pool.settings(level, &bands, &reference));
                if level == TOUCH {
                    settings.extend(in_levels(&given, &pool, &bands, &reference));
                }
            }
            Err(error) if error.is_interruption() => return Err(error),
            // A level that cannot be dropped is left out of the chart.
            Err(error) => say(&format!("{level} is left out: {error}")),
        }
    }
    // Without fines, the facets of grains have the mean emissivity of the dusty grains'
    // silhouettes.
    let level = "fines as an areal mixture";
    say(level);
    let bare = maker.pool(&prepared, packing, beds(SOME), packing.seed, |packing| {
        packing.grains.iter_mut().for_each(|class| class.fines = Fines::Count(0));
    })?;
    let share = silhouette(&given.tables[0]);
    let grains: Vec<usize> =
        packing.grains.iter().filter_map(|class| scene.material_index(&class.material)).collect();
    let each = truth.tables[0].histogram.kept.of_material();
    let mixed: Vec<_> = bands.iter().map(|rho| mixed(rho, each, &share, &grains)).collect();
    settings.extend(bare.settings(level, &mixed, &reference));
    Ok(Trade { scene: scene.name.clone(), reference, settings })
}

/// The emissivity of each bed in each band.
fn of_each(pool: &Pool, bands: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let of_bed = |table: &Table| bands.iter().map(|rho| 1.0 - table.weight(rho).mean).collect();
    pool.tables.par_iter().map(of_bed).collect()
}

/// Beds as given, and of every fourth the change where its fines touch: the sum of levels of a
/// planned run.
fn in_levels(
    given: &Pool,
    touching: &Pool,
    bands: &[Vec<f64>],
    reference: &Reference,
) -> Vec<Setting> {
    let (hulls, touch) = (of_each(given, bands), of_each(touching, bands));
    let runs_of = |pairs: usize| (hulls.len() / (FOR_A_PAIR * pairs)).min(touch.len() / pairs);
    let pairs = (0..).map(|power| 1 << power).take_while(|&pairs| runs_of(pairs) >= REPEATS);
    let of_pairs = |pairs: usize| {
        let (runs, drops) = (runs_of(pairs), FOR_A_PAIR * pairs);
        let (n, m) = (drops as f64, pairs as f64);
        // Both states of a pair come from one drop, and both are traced.
        let took = given.drop.times(n - m) + touching.drop.times(m);
        let took = took + given.trace.times(n) + touching.trace.times(m);
        // The first drops are there in both states: each run has its share of them.
        let run = |run: usize| {
            let paired = run * pairs..(run + 1) * pairs;
            let alone =
                runs * pairs + run * (drops - pairs)..runs * pairs + (run + 1) * (drops - pairs);
            let of = |band: usize| {
                let all: f64 = paired.clone().chain(alone.clone()).map(|i| hulls[i][band]).sum();
                let change: f64 = paired.clone().map(|i| touch[i][band] - hulls[i][band]).sum();
                all / n + change / m
            };
            Run { took, emissivity: (0..bands.len()).map(of).collect() }
        };
        let runs: Vec<Run> = (0..runs).map(run).collect();
        let pairs = if pairs == 1 { "1 a pair".into() } else { format!("{pairs} pairs") };
        Setting::of("hulls and pairs", format!("{drops} beds, {pairs}"), &runs, reference)
    };
    pairs.map(of_pairs).collect()
}

impl Pool {
    /// A setting for each number of beds in a mean: 1, 2, 4 and so on.
    fn settings(&self, level: &str, bands: &[Vec<f64>], reference: &Reference) -> Vec<Setting> {
        let of_each = of_each(self, bands);
        let numbers = (0..).map(|power| 1 << power);
        let numbers = numbers.take_while(|number| of_each.len() / number >= REPEATS);
        let of_number = |number: usize| {
            let n = number as f64;
            let took = (self.drop + self.trace).times(n);
            let run = |group: &[Vec<f64>]| {
                let mean = |band| group.iter().map(|bed| bed[band]).sum::<f64>() / n;
                Run { took, emissivity: (0..bands.len()).map(mean).collect() }
            };
            let runs: Vec<Run> = of_each.chunks_exact(number).map(run).collect();
            let beds = if number == 1 { "1 bed".into() } else { format!("{number} beds") };
            Setting::of(level, beds, &runs, reference)
        };
        numbers.map(of_number).collect()
    }
}

/// The mean share of each material in the silhouettes of the grains.
fn silhouette(table: &Table) -> Vec<f64> {
    let share = |material: &TableMaterial| {
        let of_each = table.coverage.values().filter_map(|c| c.silhouette.get(&material.name));
        of_each.sum::<f64>() / table.coverage.len() as f64
    };
    table.materials.iter().map(share).collect()
}

/// Reflectances by material and bin of cosines, where grains get the mean over the shares of all
/// materials.
fn mixed(rho: &[f64], cosines: usize, share: &[f64], grains: &[usize]) -> Vec<f64> {
    let of = |symbol: usize| {
        let of_materials = rho.iter().skip(symbol % cosines).step_by(cosines);
        share.iter().zip(of_materials).map(|(share, rho)| share * rho).sum()
    };
    let is_grain = |symbol: usize| grains.contains(&(symbol / cosines));
    (0..rho.len()).map(|i| if is_grain(i) { of(i) } else { rho[i] }).collect()
}

impl Maker<'_> {
    /// Drops and traces beds of a changed recipe.
    fn pool(
        &self,
        prepared: &Prepared,
        packing: &Packing,
        beds: usize,
        seed: u64,
        change: fn(&mut Packing),
    ) -> Result<Pool, Error> {
        let mut packing = packing.clone();
        change(&mut packing);
        let geometry = SceneGeometry::Packing(packing.clone());
        let scene = Scene { geometry, ..prepared.scene.clone() };
        let library = OwnGrains::of(&packing, scene.folder())?;
        let seeds: Vec<u64> = (0..beds).map(|i| random::seed_of(seed, i)).collect();
        let folder = Scratch::temporary()?;
        let cache = Cache::of_run(folder.path().to_owned());
        let order = Order {
            blender: self.blender,
            beds: Wanted::of_seeds(&scene, &packing, library.as_ref(), &seeds),
            of_first: &[],
            time_limit: self.time_limit,
        };
        let step = Step::new(self.monitor, "drop");
        let (made, drop) = timed(|| {
            let log = |i: usize| folder.path().join(format!("{i}.log"));
            Ok(order.beds(&cache, &log, &step)?)
        })?;
        let (tables, trace) = timed(|| {
            made.par_iter()
                .zip(&seeds)
                .map(|(made, &seed)| self.traced(prepared, &made.folder.join("scene.json"), seed))
                .collect::<Result<Vec<Table>, Error>>()
        })?;
        step.done(&format!("{beds} beds"));
        let each = |took: Took| took.times(1.0 / beds as f64);
        Ok(Pool { tables, drop: each(drop), trace: each(trace) })
    }

    /// Traces a bed with the materials and the view of the recipe's scene.
    fn traced(&self, prepared: &Prepared, bed: &Path, seed: u64) -> Result<Table, Error> {
        let Scene { geometry, file, .. } = Scene::read(bed)?;
        let placed = prepared.with(Scene { file, seed, geometry, ..prepared.scene.clone() });
        let tracer = trace::tracer(&placed.scene)?;
        let request = Request::new(self.grid, Target::of(RAYS));
        trace::trace(&tracer, &placed, request, &Silently(self.monitor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_areal_mixture_is_of_the_same_cosines() {
        let share = [0.25, 0.75];
        assert_eq!(mixed(&[0.5, 1.0], 1, &share, &[1]), [0.5, 0.875]);
        assert_eq!(mixed(&[0.5, 0.0, 1.0, 0.5], 2, &share, &[0]), [0.875, 0.375, 1.0, 0.5]);
    }
}
