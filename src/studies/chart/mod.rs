//! Error against time: what each knob that trades one for the other buys on a scene.
//!
//! A *level* is a way to model the scene, a *setting* how much work is put into it. Each setting is run several times with
//! other seeds. Its error is taken against a reference of yet other seeds; what remains of it in the mean of the
//! runs is the level's bias.

mod packings;
mod patch;
mod rows;
mod svg;

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use nix::sys::resource::{Usage, UsageWho, getrusage};

use crate::draw::plot;
use crate::support::error::Error;
use crate::support::output;
use crate::support::statistics::T_95;

pub use packings::{Maker, packings};
pub use patch::patch;
pub use rows::{BesideError, beside, csv};

/// Runs behind each setting, at least.
pub const REPEATS: usize = 10;

/// How long something took, seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Took {
    /// As the user waits.
    pub wall_s: f64,
    /// Of all threads, and of all Blenders that were started.
    pub cpu_s: f64,
}

/// One run of a setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// What it took.
    pub took: Took,
    /// The emissivity in each band.
    pub emissivity: Vec<f64>,
}

/// What is taken for the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// What it was made of, in words.
    pub made_of: String,
    /// The emissivity in each band.
    pub emissivity: Vec<f64>,
    /// Its standard error in each band: no smaller error can be told.
    pub standard_error: Vec<f64>,
}

/// What a setting costs and what it is off by, in emissivity.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The way the scene is modelled.
    pub level: String,
    /// How much work is put into it.
    pub setting: String,
    /// Runs.
    pub repeats: usize,
    /// Medians over the runs.
    pub took: Took,
    /// Root mean square of the error over runs and bands.
    pub rms: f64,
    /// Root mean square over the runs in the band where it is greatest.
    pub worst: f64,
    /// What of `rms` is no noise: the root mean square over bands of the runs' mean error, less what the noise adds to it.
    pub bias: f64,
    /// Where it was measured elsewhere: what its own reference can tell, as root mean square and in the worst band. Such
    /// a setting is charted, but never chosen.
    pub elsewhere: Option<[f64; 2]>,
}

/// The settings of a scene, measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Trade {
    /// The scene's name.
    pub scene: String,
    /// What errors are taken against.
    pub reference: Reference,
    /// What was measured, by level.
    pub settings: Vec<Setting>,
}

/// Runs something and says how long it took.
fn timed<T>(run: impl FnOnce() -> Result<T, Error>) -> Result<(T, Took), Error> {
    let cpu_s = || {
        let of = |who| getrusage(who).map_or(0.0, |usage: Usage| seconds(&usage));
        of(UsageWho::RUSAGE_SELF) + of(UsageWho::RUSAGE_CHILDREN)
    };
    let (wall, cpu) = (Instant::now(), cpu_s());
    let done = run()?;
    Ok((done, Took { wall_s: wall.elapsed().as_secs_f64(), cpu_s: cpu_s() - cpu }))
}

fn seconds(usage: &Usage) -> f64 {
    let of = |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    of(usage.user_time()) + of(usage.system_time())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    f64::midpoint(values[(n - 1) / 2], values[n / 2])
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    (values.map(|x| x * x).sum::<f64>() / n).sqrt()
}

impl Setting {
    /// What runs of a setting say.
    ///
    /// # Panics
    /// Without a run.
    pub fn of(level: &str, setting: String, runs: &[Run], reference: &Reference) -> Self {
        let n = runs.len() as f64;
        let bands = reference.emissivity.len();
        let mut squares = vec![0.0; bands];
        let mut means = vec![0.0; bands];
        for run in runs {
            for (band, truth) in reference.emissivity.iter().enumerate() {
                let error = run.emissivity[band] - truth;
                squares[band] += error * error / n;
                means[band] += error / n;
            }
        }
        // The square of a mean of n errors holds their variance / n.
        let of_bias = squares.iter().zip(&means).map(|(square, mean)| {
            let variance = (square - mean * mean) / (n - 1.0).max(1.0);
            mean * mean - variance
        });
        let bias = (of_bias.sum::<f64>() / bands as f64).max(0.0).sqrt();
        Self {
            level: level.into(),
            setting,
            repeats: runs.len(),
            took: Took {
                wall_s: median(runs.iter().map(|run| run.took.wall_s).collect()),
                cpu_s: median(runs.iter().map(|run| run.took.cpu_s).collect()),
            },
            rms: (squares.iter().sum::<f64>() / bands as f64).sqrt(),
            worst: squares.iter().copied().fold(0.0, f64::max).sqrt(),
            bias,
            elsewhere: None,
        }
    }
}

impl Reference {
    /// Below this root mean square no error can be told.
    pub fn floor(&self) -> f64 {
        root_mean_square(self.standard_error.iter().copied())
    }

    /// The same in the band where it is greatest.
    pub fn worst_floor(&self) -> f64 {
        self.standard_error.iter().copied().fold(0.0, f64::max)
    }
}

impl Trade {
    /// What was measured here, against the reference.
    fn own(&self) -> impl Iterator<Item = &Setting> {
        self.settings.iter().filter(|setting| setting.elsewhere.is_none())
    }

    /// The cheapest setting whose 95 % interval is within a tolerance in the worst band.
    pub fn chosen(&self, tolerance: f64) -> Option<&Setting> {
        let enough = |setting: &&Setting| T_95 * setting.worst <= tolerance;
        self.own().filter(enough).min_by(|a, b| a.took.cpu_s.total_cmp(&b.took.cpu_s))
    }

    /// Settings that none other beats in both time and error, cheapest first.
    pub fn front(&self) -> Vec<&Setting> {
        let mut all: Vec<&Setting> = self.own().collect();
        all.sort_by(|a, b| a.took.cpu_s.total_cmp(&b.took.cpu_s));
        let mut least = f64::INFINITY;
        all.retain(|setting| {
            let better = setting.worst < least;
            least = least.min(setting.worst);
            better
        });
        all
    }

    /// Writes `chart.csv`, `chart.svg` and `chart.png` into a folder.
    pub fn write(&self, tolerance: f64, folder: &Path) -> Result<(), Error> {
        output::folder(folder)?;
        let csv = csv(&self.settings, &self.reference);
        output::bytes(&folder.join("chart.csv"), csv.as_bytes())?;
        let svg = svg::trade_svg(self, tolerance, &machine())?;
        output::bytes(&folder.join("chart.svg"), svg.as_bytes())?;
        let png = plot::png(&svg, plot::PIXELS_PER_UNIT)?;
        Ok(output::bytes(&folder.join("chart.png"), &png)?)
    }
}

/// The processor, how many threads were used, and the program's version.
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

/// What a chart shows.
pub fn in_words(trade: &Trade, tolerance: f64) -> String {
    let mut text = format!(
        "{}: errors against {}; below {:.1e} none can be told\n",
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
        None => writeln!(text, "  none of them is within {tolerance}"),
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
    fn bias_is_told_from_noise() {
        let reference = Reference {
            made_of: String::new(),
            emissivity: vec![0.5, 0.9],
            standard_error: vec![0.0; 2],
        };
        // The first band is off by .1 in each run, the second by +-.02.
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
    fn the_front_holds_what_nothing_beats_and_the_choice_is_its_cheapest_that_does() {
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
        assert_eq!(trade.chosen(0.03).map(|s| s.took.cpu_s), Some(1.0));
        assert_eq!(trade.chosen(0.005).map(|s| s.took.cpu_s), Some(3.0));
        assert_eq!(trade.chosen(0.001), None);
    }
}
