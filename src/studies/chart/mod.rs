//! Error against time, for each setting of a scene that trades one for the other.
//!
//! A *level* is a way to model the scene. A *setting* is an amount of work for it. Each setting is
//! run several times with different seeds. Its error is taken against a reference with other seeds.
//! The error of the mean of the runs is the level's bias.

mod packings;
mod patch;
mod rows;
mod svg;

use std::fmt::Write as _;
use std::ops::Add;
use std::path::Path;
use std::time::Instant;

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeVal;

use crate::draw::plot;
use crate::support::error::Error;
use crate::support::output;
use crate::support::statistics::quantile_of;

pub use packings::{Maker, packings};
pub use patch::patch;
pub use rows::{beside, csv};

/// The least number of runs of a setting.
pub const REPEATS: usize = 10;

/// A duration, seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Took {
    /// Wall time.
    pub wall_s: f64,
    /// CPU time of all threads and all Blenders.
    pub cpu_s: f64,
}

impl Took {
    /// That many times as long.
    fn times(self, factor: f64) -> Self {
        Self { wall_s: factor * self.wall_s, cpu_s: factor * self.cpu_s }
    }
}

impl Add for Took {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { wall_s: self.wall_s + other.wall_s, cpu_s: self.cpu_s + other.cpu_s }
    }
}

/// One run of a setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Its time.
    pub took: Took,
    /// The emissivity in each band.
    pub emissivity: Vec<f64>,
}

/// The result that is taken for the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// How it was made, in words.
    pub made_of: String,
    /// The emissivity in each band.
    pub emissivity: Vec<f64>,
    /// Its standard error in each band. Smaller errors cannot be measured.
    pub standard_error: Vec<f64>,
}

/// The time of a setting and its error of emissivity.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The way to model the scene.
    pub level: String,
    /// The amount of work.
    pub setting: String,
    /// The number of runs.
    pub repeats: usize,
    /// Medians over the runs.
    pub took: Took,
    /// Root mean square of the error over runs and bands.
    pub rms: f64,
    /// Root mean square over the runs in the band where it is greatest.
    pub worst: f64,
    /// The part of `rms` that is no noise: the root mean square over bands of the runs' mean error,
    /// minus the contribution of noise.
    pub bias: f64,
    /// For a setting measured elsewhere: the standard error of its own reference, as root mean
    /// square and in the worst band. Such a setting is charted, but never chosen.
    pub elsewhere: Option<[f64; 2]>,
}

/// The measured settings of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Trade {
    /// The scene's name.
    pub scene: String,
    /// The reference of the errors.
    pub reference: Reference,
    /// The settings, by level.
    pub settings: Vec<Setting>,
}

/// Runs something and measures its time.
fn timed<T>(run: impl FnOnce() -> Result<T, Error>) -> Result<(T, Took), Error> {
    let seconds = |time: TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    let of =
        |who| getrusage(who).map_or(0.0, |u| seconds(u.user_time()) + seconds(u.system_time()));
    let cpu_s = || of(UsageWho::RUSAGE_SELF) + of(UsageWho::RUSAGE_CHILDREN);
    let (wall, cpu) = (Instant::now(), cpu_s());
    let done = run()?;
    Ok((done, Took { wall_s: wall.elapsed().as_secs_f64(), cpu_s: cpu_s() - cpu }))
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let n = values.len();
    f64::midpoint(values[(n - 1) / 2], values[n / 2])
}

impl Setting {
    /// Evaluates the runs of a setting.
    ///
    /// # Panics
    /// Without a run.
    pub fn of(level: &str, setting: String, runs: &[Run], reference: &Reference) -> Self {
        let (n, bands) = (runs.len() as f64, reference.emissivity.len() as f64);
        let (mut squares, mut of_bias) = (Vec::new(), 0.0);
        for (band, truth) in reference.emissivity.iter().enumerate() {
            let errors = || runs.iter().map(|run| run.emissivity[band] - truth);
            let (square, mean) =
                (errors().map(|e| e * e).sum::<f64>() / n, errors().sum::<f64>() / n);
            // The square of a mean of n errors contains their variance / n.
            of_bias += mean * mean - (square - mean * mean) / (n - 1.0).max(1.0);
            squares.push(square);
        }
        Self {
            level: level.into(),
            setting,
            repeats: runs.len(),
            took: Took {
                wall_s: median(runs.iter().map(|run| run.took.wall_s)),
                cpu_s: median(runs.iter().map(|run| run.took.cpu_s)),
            },
            rms: (squares.iter().sum::<f64>() / bands).sqrt(),
            worst: squares.into_iter().fold(0.0, f64::max).sqrt(),
            bias: (of_bias / bands).max(0.0).sqrt(),
            elsewhere: None,
        }
    }
}

impl Setting {
    /// Half-width of the 95 % interval of a single run in the worst band. The error is a root mean
    /// square about the reference, so there are as many degrees of freedom as runs.
    pub fn half_width_95(&self) -> f64 {
        quantile_of(self.repeats as f64) * self.worst
    }
}

impl Reference {
    /// The root mean square of the standard errors. Smaller errors cannot be measured.
    pub fn floor(&self) -> f64 {
        let squares: f64 = self.standard_error.iter().map(|error| error * error).sum();
        (squares / self.standard_error.len() as f64).sqrt()
    }

    /// The largest standard error of a band.
    pub fn worst_floor(&self) -> f64 {
        self.standard_error.iter().copied().fold(0.0, f64::max)
    }
}

impl Trade {
    /// The cheapest setting whose 95 % interval is within a tolerance in the worst band.
    pub fn chosen(&self, tolerance: f64) -> Option<&Setting> {
        self.front().into_iter().find(|setting| setting.half_width_95() <= tolerance)
    }

    /// The settings measured here without a better one in both time and error, cheapest first.
    pub fn front(&self) -> Vec<&Setting> {
        let mut all: Vec<_> = self.settings.iter().filter(|s| s.elsewhere.is_none()).collect();
        all.sort_by(|a, b| a.took.cpu_s.total_cmp(&b.took.cpu_s));
        let mut least = f64::INFINITY;
        all.retain(|setting| {
            let is_better = setting.worst < least;
            least = least.min(setting.worst);
            is_better
        });
        all
    }

    /// Writes `chart.csv`, `chart.svg` and `chart.png` into a folder.
    pub fn write(&self, tolerance: f64, folder: &Path) -> Result<(), Error> {
        output::folder(folder)?;
        let csv = csv(&self.settings, &self.reference);
        output::bytes(&output::within(folder, "chart.csv")?, csv.as_bytes())?;
        let svg = svg::trade_svg(self, tolerance, &machine())?;
        output::bytes(&output::within(folder, "chart.svg")?, svg.as_bytes())?;
        let png = plot::png(&svg, plot::PIXELS_PER_UNIT)?;
        Ok(output::bytes(&output::within(folder, "chart.png")?, &png)?)
    }
}

/// The processor, the number of threads, and the program's version.
fn machine() -> String {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    format!(
        "{}, {} threads; soilsig {}.",
        cpu.as_deref().unwrap_or(std::env::consts::ARCH),
        rayon::current_num_threads(),
        env!("CARGO_PKG_VERSION")
    )
}

/// A chart in words.
pub fn in_words(trade: &Trade, tolerance: f64) -> String {
    let mut text = format!(
        "{}: errors against {}; errors below {:.1e} cannot be measured\n",
        trade.scene,
        trade.reference.made_of,
        trade.reference.worst_floor()
    );
    for setting in trade.front() {
        let _ = writeln!(
            text,
            "  {:>9.4} s CPU {:>9.4} s wall  worst band {:.5}  {}, {}",
            setting.took.cpu_s, setting.took.wall_s, setting.worst, setting.level, setting.setting
        );
    }
    let _ = match trade.chosen(tolerance) {
        Some(s) => writeln!(text, "  the cheapest within {tolerance}: {}, {}", s.level, s.setting),
        None => writeln!(text, "  no setting is within {tolerance}"),
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(emissivity: [f64; 2]) -> Run {
        let took = Took { wall_s: 1.0, cpu_s: 2.0 };
        Run { took, emissivity: emissivity.into() }
    }

    #[test]
    fn bias_is_separated_from_noise() {
        let reference = Reference {
            made_of: String::new(),
            emissivity: vec![0.5, 0.9],
            standard_error: vec![0.0; 2],
        };
        // The first band has an error of .1 in each run, the second of +-.02.
        let runs: Vec<Run> =
            (0..10).map(|i| run([0.6, if i % 2 == 0 { 0.92 } else { 0.88 }])).collect();
        let setting = Setting::of("level", "1".into(), &runs, &reference);
        assert!((setting.worst - 0.1).abs() < 1e-12);
        assert!((setting.rms - f64::midpoint(0.01, 0.0004).sqrt()).abs() < 1e-12);
        assert!((setting.bias - 0.1 / 2f64.sqrt()).abs() < 1e-3, "{}", setting.bias);
        let noise: Vec<Run> =
            (0..10).map(|i| run([0.5, if i % 2 == 0 { 0.92 } else { 0.88 }])).collect();
        assert_eq!(Setting::of("level", "1".into(), &noise, &reference).bias, 0.0);
    }

    #[test]
    fn the_choice_is_the_cheapest_setting_of_the_front_within_the_tolerance() {
        let setting = |cpu_s, worst| Setting {
            level: "level".into(),
            setting: String::new(),
            repeats: 10,
            took: Took { wall_s: cpu_s, cpu_s },
            rms: worst,
            worst,
            bias: 0.0,
            elsewhere: None,
        };
        let reference =
            Reference { made_of: String::new(), emissivity: vec![], standard_error: vec![] };
        let peer = Setting { elsewhere: Some([0.0; 2]), ..setting(0.5, 0.001) };
        let settings = vec![setting(3.0, 0.002), peer, setting(1.0, 0.01), setting(2.0, 0.02)];
        let trade = Trade { scene: "scene".into(), reference, settings };
        let front: Vec<f64> = trade.front().iter().map(|s| s.took.cpu_s).collect();
        assert_eq!(front, [1.0, 3.0]);
        // Student's t of ten degrees of freedom is 2.23.
        assert_eq!(trade.chosen(0.0222).map(|s| s.took.cpu_s), Some(3.0));
        assert_eq!(trade.chosen(0.0223).map(|s| s.took.cpu_s), Some(1.0));
        assert_eq!(trade.chosen(0.005).map(|s| s.took.cpu_s), Some(3.0));
        assert_eq!(trade.chosen(0.001), None);
    }
}
