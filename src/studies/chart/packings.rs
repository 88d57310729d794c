//! The settings of a packing: how its beds are made, and how many of them.

use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;

use super::{REPEATS, Reference, Run, Setting, Took, Trade, timed};
use crate::beds::Order;
use crate::beds::own_grains::OwnGrains;
use crate::blender::Blender;
use crate::scene::{Collision, Fines, Grid, Packing, Scene, SceneGeometry};
use crate::signature;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::monitor::{Monitor, Silently, Step};
use crate::support::random;
use crate::table::{Prepared, Table, Target};
use crate::tracer::trace::{self, Request};

/// Half-width to which the rays of each bed are traced: little against what beds differ by.
const RAYS: f64 = 0.004;
/// Beds of the reference.
const REFERENCE: usize = 48;
/// Seeds of the reference lie beyond those of the settings.
const REFERENCE_SEED: u64 = 1 << 40;
/// The most packings of which a mean is charted: as given and of fines that touch, and of levels that are cheap.
const MOST: usize = 8;
const MOST_OF_LEVEL: usize = 4;

/// What the beds of a chart are made by.
pub struct Maker<'a> {
    /// The Blender that drops them.
    pub blender: &'a Blender,
    /// The bands.
    pub grid: &'a Grid,
    /// Longest that a Blender may take for a bed.
    pub time_limit: Duration,
    /// Whoever watches and may stop it.
    pub monitor: &'a dyn Monitor,
}

/// Beds of one recipe.
struct Pool {
    tables: Vec<Table>,
    /// What one of them took, where many are made.
    each: Took,
}

/// A level: its name, its beds, and what it changes in the recipe.
type Level = (&'static str, usize, fn(&mut Packing));

/// Measures the settings of a packing.
///
/// Nothing comes from a cache, since it is timed.
pub fn packings(
    scene: &Scene,
    packing: &Packing,
    maker: &Maker,
    quick: bool,
) -> Result<Trade, Error> {
    let told = |what: &str| maker.monitor.say(&format!("measuring: {what}"));
    let prepared = Prepared::new(scene.clone(), &maker.grid.wavelengths_um())?;
    let fewest = REPEATS;
    let many = |most: usize| if quick { fewest } else { fewest * most };
    told("reference");
    let contact = |packing: &mut Packing| packing.drop.collision = Collision::HullThenFines;
    let truth = maker.pool(&prepared, packing, REFERENCE, REFERENCE_SEED, &contact)?;
    let bands = truth.tables[0].reflectances(&maker.grid.wavelengths_um())?;
    let estimates: Vec<_> =
        bands.iter().map(|rho| signature::emissivity(&truth.tables, rho)).collect();
    let reference = Reference {
        made_of: format!("{REFERENCE} beds of other seeds whose fines touch (`hull_then_fines`)"),
        emissivity: estimates.iter().map(|e| e.mean).collect(),
        standard_error: estimates.iter().map(|e| e.standard_error).collect(),
    };
    let mut settings = Vec::new();
    let mut put = |level: &str, pool: &Pool, bands: &[Vec<f64>]| {
        let of_each: Vec<Vec<f64>> = pool
            .tables
            .par_iter()
            .map(|table| bands.iter().map(|rho| 1.0 - table.weight(rho).mean).collect())
            .collect();
        for number in (0..).map(|power| 1 << power) {
            let groups = of_each.len() / number;
            if groups < REPEATS {
                break;
            }
            let took = Took {
                wall_s: pool.each.wall_s * number as f64,
                cpu_s: pool.each.cpu_s * number as f64,
            };
            let mean = |group: &[Vec<f64>]| {
                let of = |band| group.iter().map(|bed| bed[band]).sum::<f64>() / number as f64;
                (0..bands.len()).map(of).collect()
            };
            let runs: Vec<Run> =
                of_each.chunks_exact(number).map(|g| Run { took, emissivity: mean(g) }).collect();
            let beds = if number == 1 { "1 bed".into() } else { format!("{number} beds") };
            settings.push(Setting::of(level, beds, &runs, &reference));
        }
    };
    told("as given");
    let shipped = maker.pool(&prepared, packing, many(MOST), packing.seed, &|_| ())?;
    put("as given", &shipped, &bands);
    let share = silhouette(&shipped.tables[0]);
    let levels: [Level; 12] = [
        ("half the tray", many(MOST_OF_LEVEL), |packing| widen(packing, 0.5)),
        ("twice the tray", fewest, |packing| widen(packing, 2.0)),
        ("half the grains in the tray", fewest, thin),
        ("no rim left out", fewest, |packing| packing.crop_um = 0.0),
        ("half the rim left out", fewest, |packing| packing.crop_um /= 2.0),
        ("4 substeps", fewest, |packing| packing.drop.substeps = 4),
        ("10 substeps", fewest, |packing| packing.drop.substeps = 10),
        ("1 variant of a grain", fewest, |packing| packing.variants = 1),
        ("fewest facets of fines", fewest, |packing| {
            packing.fines.iter_mut().for_each(|class| class.ribs = Some(0));
        }),
        ("most facets of fines", fewest, |packing| {
            packing.fines.iter_mut().for_each(|class| class.ribs = Some(2));
        }),
        ("fewest facets of grains", fewest, |packing| {
            packing.grains.iter_mut().for_each(|class| class.ribs = Some(0));
        }),
        ("fines touch", many(MOST), |packing| packing.drop.collision = Collision::HullThenFines),
    ];
    for (level, beds, edit) in levels {
        told(level);
        match maker.pool(&prepared, packing, beds, packing.seed, &edit) {
            Ok(made) => put(level, &made, &bands),
            Err(error) if error.is_interruption() => return Err(error),
            // What cannot be dropped has no place in the chart.
            Err(error) => told(&format!("{level} is left out: {error}")),
        }
    }
    // Without fines the grains' facets have the emissivity of what their silhouettes would show.
    told("fines as an areal mixture");
    let bare = |packing: &mut Packing| {
        packing.grains.iter_mut().for_each(|class| class.fines = Fines::Count(0));
    };
    let bare = maker.pool(&prepared, packing, many(MOST_OF_LEVEL), packing.seed, &bare)?;
    let grains: Vec<usize> =
        packing.grains.iter().filter_map(|class| scene.material_index(&class.material)).collect();
    let cosines = usize::from(truth.tables[0].histogram.kept.cosines);
    let mixed: Vec<_> = bands.iter().map(|rho| mixed(rho, cosines, &share, &grains)).collect();
    put("fines as an areal mixture", &bare, &mixed);
    Ok(Trade { scene: scene.name.clone(), reference, settings })
}

/// The share of each material in the silhouettes of the grains, in their mean.
fn silhouette(table: &Table) -> Vec<f64> {
    let prototypes = table.coverage.len() as f64;
    table
        .materials
        .iter()
        .map(|material| {
            let of = |cover: &crate::table::cover::Cover| {
                cover.silhouette.get(&material.name).copied().unwrap_or(0.0)
            };
            table.coverage.values().map(of).sum::<f64>() / prototypes
        })
        .collect()
}

/// Reflectances, of so many bins of cosines for each material, with those of grains mixed by shares of the materials.
fn mixed(rho: &[f64], cosines: usize, share: &[f64], grains: &[usize]) -> Vec<f64> {
    let of = |symbol: usize| {
        let of_materials = rho.iter().skip(symbol % cosines).step_by(cosines);
        share.iter().zip(of_materials).map(|(share, rho)| share * rho).sum()
    };
    let is_grain = |symbol: usize| grains.contains(&(symbol / cosines));
    (0..rho.len()).map(|i| if is_grain(i) { of(i) } else { rho[i] }).collect()
}

/// As many times the area of the tray within its rim, and of the grains.
fn widen(packing: &mut Packing, factor: f64) {
    for length in &mut packing.tray_um {
        *length *= factor.sqrt();
    }
    for class in &mut packing.grains {
        class.count = (f64::from(class.count) * factor).round().max(1.0) as u32;
    }
}

/// Half the depth.
fn thin(packing: &mut Packing) {
    for class in &mut packing.grains {
        class.count = class.count.div_ceil(2);
    }
}

impl Maker<'_> {
    /// Drops and traces beds of an edited recipe.
    fn pool(
        &self,
        prepared: &Prepared,
        packing: &Packing,
        beds: usize,
        seed: u64,
        edit: &dyn Fn(&mut Packing),
    ) -> Result<Pool, Error> {
        let mut packing = packing.clone();
        edit(&mut packing);
        let geometry = SceneGeometry::Packing(packing.clone());
        let scene = Scene { geometry, ..prepared.scene.clone() };
        let library = OwnGrains::of(&packing, scene.folder())?;
        let seeds: Vec<u64> = (0..beds).map(|i| random::seed_of(seed, i)).collect();
        let folder = tempfile::tempdir().map_err(|source| crate::support::output::OutputError {
            path: std::env::temp_dir(),
            source,
        })?;
        let cache = Cache::new(folder.path().to_owned());
        let order = Order {
            blender: self.blender,
            scene: &scene,
            packing: &packing,
            own_grains: library.as_ref(),
            seeds: &seeds,
            of_first: &[],
            time_limit: self.time_limit,
        };
        let step = Step::new(self.monitor, "drop");
        let (tables, took) = timed(|| {
            let log = |i: usize| folder.path().join(format!("{i}.log"));
            let made = order.beds(&cache, &log, &step)?;
            made.par_iter()
                .zip(&seeds)
                .map(|(made, &seed)| self.traced(prepared, &made.folder.join("scene.json"), seed))
                .collect::<Result<Vec<Table>, Error>>()
        })?;
        step.done(&format!("{beds} beds"));
        let each = Took { wall_s: took.wall_s / beds as f64, cpu_s: took.cpu_s / beds as f64 };
        Ok(Pool { tables, each })
    }

    /// Traces a bed with the materials and the view of the recipe's scene.
    fn traced(&self, prepared: &Prepared, bed: &Path, seed: u64) -> Result<Table, Error> {
        let Scene { geometry, file, .. } = Scene::read(bed)?;
        let placed = prepared.with(Scene { seed, geometry, file, ..prepared.scene.clone() });
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
