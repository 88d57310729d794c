use super::*;
use crate::histogram::Mean;
use crate::support::random::{Purpose, Source};

/// A recipe whose hulls and changes are normally distributed, alike in three bands for four
/// fifths of their variance.
struct Recipe {
    spread: f64,
    of_change: f64,
    correlation: f64,
}

/// By bed and band: hulls, and the same drop whose fines touch.
type Drawn = Vec<Vec<[f64; 2]>>;

impl Recipe {
    fn draw(&self, seed: u64, beds: usize) -> Drawn {
        let mut random = Source::new(seed, Purpose::Packing).stream(0);
        let mut normal = || {
            let [u, v] = random.pair();
            (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        };
        let bed = |_| {
            let all = [normal(), normal()];
            let of_band = |_| {
                let [a, b] = all.map(|all| 0.8f64.sqrt() * all + 0.2f64.sqrt() * normal());
                let r = self.correlation;
                let change = self.of_change * (r * a + (1.0 - r * r).sqrt() * b);
                [self.spread * a, self.spread * a + change]
            };
            (0..3).map(of_band).collect()
        };
        (0..beds).map(bed).collect()
    }
}

/// Beds that were drawn of a recipe (docs: tolerances).
struct Pool {
    recipe: &'static str,
    beds: Drawn,
    keeps_apart: bool,
    /// Standard deviation between beds by the cells of single ones, by band.
    cells: Vec<f64>,
}

impl Pool {
    fn read() -> Vec<Self> {
        let csv = include_str!("../../../docs/measurements/data/drawn_beds.csv");
        let mut pools: Vec<Self> = Vec::new();
        for line in csv.lines().skip(1) {
            let mut cells = line.split(',');
            let mut cell = || cells.next().expect("a cell");
            let [recipe, level, bed] = [cell(), cell(), cell()];
            let bed: usize = bed.parse().expect("a number");
            let is_touching = level == "touching";
            if pools.last().is_none_or(|pool| pool.recipe != recipe) {
                let (beds, cells) = (Vec::new(), Self::cells(recipe));
                pools.push(Self { recipe, beds, keeps_apart: false, cells });
            }
            let pool = pools.last_mut().expect("it was pushed");
            pool.keeps_apart |= is_touching;
            let numbers = cells.map(|cell| cell.parse::<f64>().expect("a number"));
            if is_touching {
                let bands = pool.beds[bed - 1].iter_mut();
                bands.zip(numbers).for_each(|(band, touching)| band[1] = touching);
            } else {
                pool.beds.push(numbers.map(|hulls| [hulls, hulls]).collect());
            }
        }
        pools
    }

    fn cells(recipe: &str) -> Vec<f64> {
        let csv = include_str!("../../../docs/measurements/data/cells.csv");
        let of_recipe = csv.lines().filter(|line| line.split(',').next() == Some(recipe));
        let last = |line: &str| line.rsplit(',').next().map(str::parse);
        of_recipe.map(|line| last(line).expect("a cell").expect("a number")).collect()
    }

    /// The mean of all beds, by band.
    fn truth(&self) -> Vec<f64> {
        let n = self.beds.len() as f64;
        let bands = 0..self.beds[0].len();
        bands.map(|i| self.beds.iter().map(|bed| bed[i][1]).sum::<f64>() / n).collect()
    }

    /// Beds taken at random, with replacement: the pool stands for all beds of the recipe.
    fn draw(&self, seed: u64, beds: usize) -> Drawn {
        let mut random = Source::new(seed, Purpose::Packing).stream(1);
        let mut number = || (random.pair()[0] * self.beds.len() as f64) as usize;
        (0..beds).map(|_| self.beds[number()].clone()).collect()
    }
}

fn levels(beds: Beds) -> Levels {
    let Beds { drops, pairs } = beds;
    Levels::of_pairs(pairs, drops)
}

/// A plan by the first beds, and the estimate of each band.
fn plan(
    drawn: &Drawn,
    cells: Option<&[f64]>,
    now: Beds,
    keeps_apart: bool,
    tolerance: f64,
) -> (Plan, Vec<[f64; 2]>) {
    let levels = levels(now);
    let of_level = |bed: &Vec<[f64; 2]>, level: usize| bed.iter().map(|b| b[level]).collect();
    let touching = drawn[..now.pairs].iter().map(|bed| of_level(bed, 1));
    let hulls = drawn[..now.drops].iter().map(|bed| of_level(bed, 0));
    let curves: Vec<Vec<f64>> = touching.chain(hulls).collect();
    let of = |band: usize| {
        let mean = |curve: &Vec<f64>| Mean { mean: curve[band], ..Mean::default() };
        levels.estimate(&curves.iter().map(mean).collect::<Vec<_>>())
    };
    let um = |band: usize| 8.0 + band as f64;
    let number = drawn[0].len();
    let bands: Vec<Band> = (0..number)
        .map(|i| Band { wavelength_um: um(i), emissivity: of(i), ..Band::default() })
        .collect();
    let total = |i: usize| {
        let values: Vec<f64> = curves.iter().map(|curve| curve[i]).collect();
        levels.half_width(&values, 0.0, cells.map(|cells| cells[i])).unwrap_or(0.02)
    };
    let share = |i: usize| Share { wavelength_um: um(i), total: total(i), ..Share::default() };
    let budget = Budget {
        bands: (0..number).map(share).collect(),
        by_cells: cells.map(<[f64]>::to_vec),
        ..Budget::default()
    };
    let plan = Plan::new(&levels, &curves, &bands, &budget, tolerance, keeps_apart);
    (plan, (0..number).map(|i| [of(i).mean, total(i)]).collect())
}

/// Whether the interval of each band holds the truth in a run that ends within the tolerance.
fn holds(
    drawn: &Drawn,
    cells: Option<&[f64]>,
    keeps_apart: bool,
    tolerance: f64,
    truth: &[f64],
) -> Vec<bool> {
    let mut now = Beds::first(tolerance, keeps_apart);
    loop {
        let (plan, estimates) = plan(drawn, cells, now, keeps_apart, tolerance);
        if plan.is_done() {
            assert!(plan.total <= tolerance, "{plan:?}");
            let bands = estimates.iter().zip(truth);
            return bands.map(|([mean, of], truth)| (mean - truth).abs() <= *of).collect();
        }
        assert!(plan.next.drops >= now.drops && plan.next.pairs >= now.pairs);
        now = plan.next;
    }
}

/// The share of true entries.
fn share(of: &[Vec<bool>]) -> f64 {
    let all = of.iter().flatten();
    all.clone().filter(|held| **held).count() as f64 / all.count() as f64
}

/// The spreads of the shipped recipe at 9 um, with and without fines to touch.
#[test]
fn the_intervals_of_planned_runs_hold_as_often_as_promised() {
    for (spread, of_change, keeps_apart, tolerance) in [
        (0.0075, 0.0013, true, 0.01),
        (0.0075, 0.0013, true, 0.005),
        (0.005, 0.0013, true, 0.01),
        (0.005, 0.0013, true, 0.002),
        (0.005, 0.0, false, 0.004),
    ] {
        let recipe = Recipe { spread, of_change, correlation: -0.6 };
        let run = |seed| holds(&recipe.draw(seed, MOST), None, keeps_apart, tolerance, &[0.0; 3]);
        let share = share(&(0..2000).map(run).collect::<Vec<_>>());
        // Bands of a run hold together: 95 % of 2000 runs is 95 +- 1 %.
        assert!((0.93..0.97).contains(&share), "{tolerance}: {share}");
    }
}

/// Beds of Blender are not normally distributed, and their bands and levels go together as
/// they do.
#[test]
#[expect(clippy::print_stdout, reason = "the table of docs/measurements/tolerances.md")]
fn the_intervals_of_planned_runs_hold_on_beds_of_blender() {
    let pools = Pool::read();
    assert_eq!(pools.len(), 4);
    for pool in &pools {
        for tolerance in [0.01, 0.005] {
            let truth = pool.truth();
            let run = |seed| {
                let drawn = pool.draw(seed, MOST);
                holds(&drawn, Some(&pool.cells), pool.keeps_apart, tolerance, &truth)
            };
            let share = share(&(0..4000).map(run).collect::<Vec<_>>());
            println!("{}, {tolerance}: {share}", pool.recipe);
            // Six beds without fines are within .01 more often than they must be.
            assert!((0.93..0.98).contains(&share), "{}, {tolerance}: {share}", pool.recipe);
        }
    }
}

#[test]
fn bounds_that_leave_no_room_end_a_plan() {
    let bands = [Band::default()];
    let plan = |drops: usize, share: Share| {
        let budget = Budget { bands: vec![share], ..Budget::default() };
        let curves: Vec<Vec<f64>> = (0..drops).map(|i| vec![0.001 * (i % 2) as f64]).collect();
        Plan::new(&Levels::of_pairs(0, drops), &curves, &bands, &budget, 0.002, false)
    };
    let ends = |drops: usize, rim: f64| {
        plan(drops, Share { total: rim + 0.001, rim: Some(rim), ..Share::default() })
    };
    // What a few beds say of the rim may be chance.
    let few = ends(5, 0.003);
    assert!(!few.is_done() && few.next.drops == 10, "{few:?}");
    assert!(ends(NO_ROOM, 0.003).is_done());
    // Beds differ by .0005: 24 leave room for a rim that shrinks.
    let room = ends(24, 0.0015);
    assert!(!room.is_done() && room.wanted == Some(room.by), "{room:?}");
    // A floor ends it at once.
    let floor = plan(5, Share { total: 0.004, floor: 0.003, ..Share::default() });
    assert_eq!((floor.is_done(), floor.wanted), (true, None));
}
