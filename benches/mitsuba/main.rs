//! CPU time of soilsig and of Mitsuba 3 at equal standard error: the same bed, view and one thread.
//! `benches/mitsuba/run.sh` starts it.
//!
//! The measure is CPU seconds times the square of the standard error. For independent paths it does
//! not depend on their number. For stratified paths it falls with their number. Both are therefore
//! compared at several standard errors: those of a few thousand of Mitsuba's paths, of 100,000, of
//! 800,000 and of some ten million. Renders of 100,000 paths stand for the larger ones, which would
//! have the same product. Reading meshes and building trees is not counted. Mitsuba renders a few
//! groups of bands. The time for all 651 is scaled by the number of groups of four, though a render
//! gives three: this favours Mitsuba. It ends paths by Russian roulette, its default; without, it
//! takes about twice as long.
//!
//! With a file as the fourth argument, Mitsuba's points for the chart are written to it (`points`).

mod points;

use std::error::Error;
use std::fs;
use std::io::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use nix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};
use soilsig::histogram::{Histogram, Mean};
use soilsig::products::export::{self, To};
use soilsig::scene::{Grid, Scene};
use soilsig::support::monitor::Unwatched;
use soilsig::table::{Prepared, Target};
use soilsig::tracer::rules::TracingRules;
use soilsig::tracer::until::{self, Request};
use soilsig::tracer::{Tracer, trace};

/// Runs of each, in turns.
const RUNS: u64 = 5;
/// Half-width of the reference.
const REFERENCE_TOLERANCE: f64 = 0.00005;
/// One measurement: renders of Mitsuba, and our traces at one standard error or several.
const TURNS: [Turn; 2] = [
    Turn {
        film: Film { pixels: 64, samples: 2 },
        seeds: 32,
        levels: &[Level { tolerance: 0.006, traces: 12 }],
    },
    Turn {
        film: Film { pixels: 256, samples: 2 },
        seeds: 48,
        levels: &[
            Level { tolerance: 0.0014, traces: 12 },
            Level { tolerance: 0.0005, traces: 12 },
            Level { tolerance: 0.00017, traces: 6 },
        ],
    },
];
/// Groups of four that 651 bands make.
const GROUPS: f64 = 163.0;
/// Bands that Mitsuba renders in place of all, three at a time, um.
const BANDS_UM: [f64; 12] = [7.6, 8.2, 8.5, 8.62, 8.95, 9.2, 9.6, 10.5, 11.5, 12.3, 12.65, 13.5];
/// Factor from the time of these bands to that of all bands.
const ALL_BY_SOME: f64 = GROUPS / (BANDS_UM.len() as f64 / 3.0);
const ONE_BAND_UM: f64 = 9.0;

type Done<T> = Result<T, Box<dyn Error>>;

/// Our tracer and its scene.
struct Ours {
    tracer: Tracer,
    scene: Scene,
    /// Folder of the same scene for Mitsuba.
    exported: PathBuf,
}

impl Ours {
    fn bands(&self, wavelengths_um: &[f64]) -> Done<Vec<Vec<f64>>> {
        Ok(Prepared::new(self.scene.clone(), wavelengths_um)?.reflectances.to_vec())
    }

    fn rules(&self) -> TracingRules {
        TracingRules::new(
            &Prepared::new(self.scene.clone(), &BANDS_UM).expect("it was read before"),
        )
    }

    /// CPU seconds of a trace for `bands`, and the weight in each of the bands `asked` for.
    fn run(
        &self,
        bands: &[Vec<f64>],
        asked: &[Vec<f64>],
        seed: u64,
        tolerance: f64,
    ) -> Done<(f64, Vec<Mean>)> {
        let target = Target::of(tolerance);
        let started_s = cpu_s();
        let rules = self.rules().ending_below(target.least_weight, bands);
        let request = Request::new(&rules, seed, bands, target, &Unwatched);
        let traced = until::trace(&self.tracer, &request)?;
        let histogram = Histogram::of(&traced.tally);
        let means = asked.iter().map(|rho| histogram.weight(rho)).collect();
        Ok((cpu_s() - started_s, means))
    }
}

/// The standard error plus the bound by paths that were given up.
fn error(mean: &Mean) -> f64 {
    mean.half_width() / soilsig::support::statistics::T_95
}

fn cpu_s() -> f64 {
    let now = clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).expect("a clock");
    now.tv_sec() as f64 + now.tv_nsec() as f64 * 1e-9
}

fn peak_memory_mb() -> Done<f64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).ok_or("no VmHWM")?;
    Ok(line.split_whitespace().nth(1).ok_or("no number")?.parse::<f64>()? / 1024.0)
}

/// The scene with open sides: the sensor sees the domain, and the bed goes on beyond it.
fn open(scene: &str, to: &str) -> Done<()> {
    let mut json: Value = serde_json::from_str(&fs::read_to_string(scene)?)?;
    let folder = fs::canonicalize(Path::new(scene).parent().ok_or("no folder")?)?;
    let placed = &mut json["geometry"]["placed"];
    placed["domain"]["sides"] = "open".into();
    for prototype in placed["prototypes"].as_array_mut().ok_or("no prototypes")? {
        let file = folder.join(prototype["file"].as_str().ok_or("no file")?);
        prototype["file"] = file.display().to_string().into();
    }
    Ok(fs::write(to, json.to_string())?)
}

struct Turn {
    film: Film,
    /// Renders of Mitsuba in each run: their spread is its standard error.
    seeds: u64,
    levels: &'static [Level],
}

/// The target of our traces.
struct Level {
    /// Half-width.
    tolerance: f64,
    /// Traces in each run. Each states its own standard error, to within a quarter.
    traces: u64,
}

/// Pixels along a side, and paths through each pixel.
struct Film {
    pixels: u64,
    samples: u64,
}

impl Film {
    fn paths(&self) -> u64 {
        self.pixels.pow(2) * self.samples
    }
}

/// Mitsuba's renders: seconds of each, means by render and band, peak memory in MB.
#[derive(Default)]
struct Theirs {
    cpu_s: Vec<f64>,
    wall_s: Vec<f64>,
    means: Vec<Vec<f64>>,
    peak_memory_mb: f64,
    version: String,
}

fn theirs(
    python: &str,
    ours: &Ours,
    reflectances: &[Vec<f64>],
    film: &Film,
    seeds: Range<u64>,
    threads: Option<u64>,
) -> Done<Theirs> {
    let mut job = json!({
        "scene": ours.exported.join("scene.xml"), "reflectances": reflectances,
        "pixels": film.pixels, "samples": film.samples, "rr_depth": 5,
        "seeds": seeds.collect::<Vec<_>>(),
    });
    if let Some(threads) = threads {
        job["threads"] = threads.into();
    }
    let mut child = Command::new(python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/mitsuba/peer.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    child.stdin.take().ok_or("no pipe")?.write_all(job.to_string().as_bytes())?;
    let output = child.wait_with_output()?;
    if !output.status.success() {
        return Err(format!("Mitsuba: {}", output.status).into());
    }
    let mut theirs = Theirs::default();
    for line in String::from_utf8(output.stdout)?.lines() {
        let render: Value = serde_json::from_str(line)?;
        if let Some(peak) = render["peak_memory_mb"].as_f64() {
            theirs.peak_memory_mb = peak;
            theirs.version = render["mitsuba"].as_str().ok_or("no version")?.into();
        } else {
            theirs.cpu_s.push(render["cpu_s"].as_f64().ok_or("no time")?);
            theirs.wall_s.push(render["wall_s"].as_f64().ok_or("no time")?);
            theirs.means.push(serde_json::from_value(render["means"].clone())?);
        }
    }
    Ok(theirs)
}

/// Mean and variance.
fn moments(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, values.map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
}

/// CPU seconds of a render, and the variance of its mean in each band.
fn cost(theirs: &Theirs) -> (f64, Vec<f64>) {
    let bands = theirs.means[0].len();
    let (cpu_s, _) = moments(theirs.cpu_s.iter().copied());
    let variances = (0..bands).map(|band| moments(theirs.means.iter().map(move |m| m[band])).1);
    (cpu_s, variances.collect())
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

fn median(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let (least, most) = (values[0], values[values.len() - 1]);
    format!("{:.3e} ({least:.3e}-{most:.3e})", values[values.len() / 2])
}

fn root_mean_square(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count() as f64;
    (values.map(|v| v * v).sum::<f64>() / n).sqrt()
}

fn main() -> Done<()> {
    let args: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    match &args[..] {
        [scene, python, open_scene] => {
            rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
            costs(python, &ours(scene, open_scene)?)
        }
        [scene, python, open_scene, file] => points::write(python, &ours(scene, open_scene)?, file),
        _ => Err("give a placed scene, the Python with Mitsuba, and where to write".into()),
    }
}

/// The scene with open sides, for both.
fn ours(scene: &str, open_scene: &str) -> Done<Ours> {
    open(scene, open_scene)?;
    let path = Path::new(open_scene);
    let scene = Scene::read(path)?;
    let tracer = trace::tracer(&scene)?;
    let exported = path.with_extension("mitsuba");
    export::export(&scene, To::Mitsuba, &BANDS_UM[..3], &exported)?;
    Ok(Ours { tracer, scene, exported })
}

fn costs(python: &str, ours: &Ours) -> Done<()> {
    let some = ours.bands(&BANDS_UM)?;
    let one = ours.bands(&[ONE_BAND_UM])?;
    let few = [&some[..], &one].concat();
    let (_, exact) = ours.run(&few, &few, 1000, REFERENCE_TOLERANCE)?;
    println!(
        "medians (and range) of {RUNS} runs in turns; costs are CPU s x squared standard error, of all 651 bands in the \
         mean of {}, of one band at {ONE_BAND_UM} um\n",
        BANDS_UM.len(),
    );
    println!(
        "| paths of a render | bands | standard error, ours | Mitsuba | cost, ours | Mitsuba | Mitsuba : ours | off the \
         reference (+-{:.5}), ours | Mitsuba, mean of its renders |",
        exact[BANDS_UM.len()].standard_error,
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut their_peak_mb = 0.0_f64;
    let all = ours.bands(&Grid::PAPER.wavelengths_um())?;
    // Mitsuba always renders three bands.
    let thrice = vec![one[0].clone(); 3];
    for turn in &TURNS {
        let both = [
            (
                "all 651",
                Bands { traced: &all, looked_at: &some, rendered: &some, renders: ALL_BY_SOME },
            ),
            ("one", Bands { traced: &one, looked_at: &one, rendered: &thrice, renders: 1.0 }),
        ];
        for (name, bands) in both {
            let exact =
                if bands.looked_at.len() > 1 { &exact[..some.len()] } else { &exact[some.len()..] };
            let rms = |values: &[f64]| format!("{:.5}", root_mean_square(values.iter().copied()));
            let (rows, theirs, peak_mb) = in_turns(python, ours, turn, &bands, exact)?;
            their_peak_mb = their_peak_mb.max(peak_mb);
            for row in rows {
                let ratios = theirs.costs.iter().zip(&row.costs).map(|(m, o)| m / o).collect();
                println!(
                    "| {} | {name} | {} | {} | {} | {} | {} | {} | {} |",
                    turn.film.paths(),
                    rms(&row.errors),
                    rms(&theirs.errors),
                    median(row.costs),
                    median(theirs.costs.clone()),
                    median(ratios),
                    rms(&row.off),
                    rms(&theirs.off),
                );
            }
        }
    }
    println!("\npeak memory, MB: ours {:.0}, Mitsuba {their_peak_mb:.0}", peak_memory_mb()?);
    Ok(())
}

/// Bands that are compared.
struct Bands<'a> {
    /// The bands of our traces.
    traced: &'a [Vec<f64>],
    looked_at: &'a [Vec<f64>],
    /// The bands that Mitsuba renders, and the factor to the time of all bands.
    rendered: &'a [Vec<f64>],
    renders: f64,
}

/// The runs of one of the two programs.
#[derive(Default)]
struct Row {
    /// Root mean square of the standard errors over the bands.
    errors: Vec<f64>,
    costs: Vec<f64>,
    /// By run and band.
    off: Vec<f64>,
}

/// Ours at each level, then Mitsuba's with its peak memory in MB.
fn in_turns(
    python: &str,
    ours: &Ours,
    turn: &Turn,
    bands: &Bands,
    exact: &[Mean],
) -> Done<(Vec<Row>, Row, f64)> {
    let mut rows: Vec<Row> = turn.levels.iter().map(|_| Row::default()).collect();
    let (mut of_theirs, mut peak_memory_mb) = (Row::default(), 0.0_f64);
    for run in 1..=RUNS {
        for ((number, level), row) in (0..).zip(turn.levels).zip(&mut rows) {
            let (mut cost_of_ours, mut squares) = (0.0, 0.0);
            for trace in 0..level.traces {
                let seed = 1000 * number + 100 * run + trace;
                let (cpu_s, means) =
                    ours.run(bands.traced, bands.looked_at, seed, level.tolerance)?;
                let variance = mean(means.iter().map(|mean| error(mean).powi(2)));
                squares += variance / level.traces as f64;
                cost_of_ours += cpu_s * variance / level.traces as f64;
                row.off.extend(means.iter().zip(exact).map(|(mean, exact)| mean.mean - exact.mean));
            }
            row.errors.push(squares.sqrt());
            row.costs.push(cost_of_ours);
        }
        let first = 1000 * turn.film.pixels + 200 * run + 100 * (bands.looked_at.len() as u64 % 2);
        let seeds = first..first + turn.seeds;
        let renders = theirs(python, ours, bands.rendered, &turn.film, seeds, Some(1))?;
        let (cpu_s, variances) = cost(&renders);
        let variance = mean(variances.into_iter());
        of_theirs.errors.push(variance.sqrt());
        of_theirs.costs.push(cpu_s * bands.renders * variance);
        let mean_of = |band: usize| moments(renders.means.iter().map(move |m| m[band])).0;
        let off = exact.iter().enumerate().map(|(band, exact)| mean_of(band) - exact.mean);
        of_theirs.off.extend(off);
        peak_memory_mb = peak_memory_mb.max(renders.peak_memory_mb);
    }
    Ok((rows, of_theirs, peak_memory_mb))
}
