//! The command line: one file for each subcommand, and what they share.

mod blender;
mod chart;
mod completions;
mod doctor;
mod export;
mod grains;
mod image;
mod import;
pub mod interrupt;
mod merge;
mod picture;
mod pipeline;
mod replay;
mod retrieve;
mod schema;
mod signature;
mod spectra;
mod stress;
pub mod terminal;
mod trace;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::builder::{StringValueParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};

use crate::draw::plot;
use crate::radiometry::Assumed;
use crate::scene::{Grid, Inverted, SpectrumSource};
use crate::spectrum::Spectrum;
use crate::support::cache::Cache;
use crate::support::error::{Error, Status};
use crate::support::output::{self, OutputError};
use terminal::Terminal;

/// Thermal-infrared signatures of soil from the geometry of its grains
#[derive(Parser)]
#[command(version, about)]
struct Cli {
    /// Threads to use; the result does not depend on it [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Pipeline(pipeline::Args),
    Trace(trace::Args),
    Merge(merge::Args),
    Signature(signature::Args),
    Retrieve(retrieve::Args),
    Replay(replay::Args),
    Image(image::Args),
    Export(export::Args),
    Import(import::Args),
    Grains(grains::Args),
    Blender(blender::Args),
    Spectra(spectra::Args),
    Picture(picture::Args),
    Chart(chart::Args),
    Stress(stress::Args),
    Doctor(doctor::Args),
    Schema(schema::Args),
    Completions(completions::Args),
}

/// The bands of a signature.
#[derive(Args)]
struct Bands {
    /// Wavelengths, um; the spectra must cover them
    #[arg(long, value_name = "FROM-TO", default_value = "7.5-14", value_parser = range)]
    range: (f64, f64),
    /// Distance of the bands, um
    #[arg(long, value_name = "UM", default_value_t = 0.01)]
    step: f64,
}

impl Bands {
    fn grid(&self) -> Grid {
        Grid::new(self.range.0, self.range.1, self.step).unwrap_or_else(|problem| usage(&problem))
    }
}

/// How well what a retrieval takes for known is known, and when it tells too little.
#[derive(Args)]
struct Assumptions {
    /// Standard error of the target's temperature, K
    #[arg(long, value_name = "K", default_value_t = 0.0, value_parser = not_below_0)]
    temperature_error: f64,
    /// Standard error of the sky's radiance, as a share of it
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = not_below_0)]
    sky_error: f64,
    /// Mask bands in which Eq. 2 amplifies errors more than this: at 10 an error of 1 % in radiance is one of 0.1 in
    /// emissivity
    #[arg(long, value_name = "F", default_value_t = Assumed::AMPLIFICATION_LIMIT, value_parser = not_below_0)]
    amplification_limit: f64,
}

impl Assumptions {
    fn assumed(&self) -> Assumed {
        Assumed { downwelling_error: self.sky_error, amplification_limit: self.amplification_limit }
    }
}

fn not_below_0(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        _ => Err("it must be a number, 0 or more".into()),
    }
}

/// How Blender is run, and whether for what is there already.
#[derive(Args)]
struct InBlender {
    /// Blender to use: its executable, or a Python that can import bpy
    #[arg(long, value_name = "PATH", value_parser = utf8_path())]
    blender: Option<PathBuf>,
    /// Longest that Blender may take, seconds
    #[arg(long, value_name = "S", default_value_t = 600)]
    blender_timeout: u64,
    /// Make everything anew
    #[arg(long)]
    no_cache: bool,
}

impl InBlender {
    /// The Blender asked for. A path is made absolute, so that a record holds elsewhere; a name is looked up
    /// on PATH.
    fn blender(&self) -> Option<PathBuf> {
        self.blender.as_ref().map(|path| match path.components().count() {
            1 => path.clone(),
            _ => std::path::absolute(path).unwrap_or(path.clone()),
        })
    }

    /// Does the work with the cache, or with an empty one of its own.
    fn run<T>(
        &self,
        cache: &Cache,
        work: impl FnOnce(&Cache) -> Result<T, Error>,
    ) -> Result<T, Error> {
        if !self.no_cache {
            return work(cache);
        }
        let folder = tempfile::tempdir()
            .map_err(|source| OutputError { path: std::env::temp_dir(), source })?;
        work(&cache.other_results(folder.path().to_owned()))
    }
}

/// When a trace is enough.
#[derive(Args)]
struct Enough {
    /// Half-width of the 95 % interval in emissivity that every band is to reach
    #[arg(long, value_name = "X", default_value_t = 0.005, value_parser = tolerance)]
    tolerance: f64,
    /// Most paths to trace; if they do not suffice the result is written and the exit status is 4
    #[arg(long, value_name = "N", default_value_t = 1 << 26,
          value_parser = clap::value_parser!(u64).range(2..))]
    max_paths: u64,
    /// Longest that a trace may take; if it does not suffice the result is written and the exit status is 4
    #[arg(long, value_name = "S", value_parser = seconds)]
    max_seconds: Option<f64>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("it must be a number above 0".into()),
    }
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = text.split_once('-').ok_or("write FROM-TO, as in 7.5-14")?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|e| format!("{text:?}: {e}"));
    Ok((number(from)?, number(to)?))
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x < 1.0 => Ok(x),
        _ => Err("it must be above 0 and below 1".into()),
    }
}

/// A spectrum of the command line: a number, a shipped one's name, `fresnel:CONSTANTS`, `inverted:` before that of a
/// powder, else a file.
fn spectrum_source(text: &str) -> SpectrumSource {
    if let Ok(value) = text.parse::<f64>() {
        if !(0.0..=1.0).contains(&value) {
            usage(&format!("an emissivity of {value} is not within 0 to 1"));
        }
        SpectrumSource::Constant(value)
    } else if let Some(constants) = text.strip_prefix("fresnel:") {
        SpectrumSource::Fresnel(constants.to_owned())
    } else if let Some(powder) = text.strip_prefix("inverted:") {
        if powder.starts_with("inverted:") || powder.starts_with("fresnel:") {
            usage(&format!(
                "{text:?}: after inverted: stands the spectrum of a powder: a shipped one's name, a file or a number"
            ));
        }
        let spectrum = Box::new(spectrum_source(powder));
        SpectrumSource::Inverted(Inverted { spectrum, pure_bed: Vec::new() })
    } else if Spectrum::builtin(text).is_ok() {
        SpectrumSource::Builtin(text.to_owned())
    } else {
        SpectrumSource::File(text.into())
    }
}

/// The file that a spectrum given in words comes from, if it comes from one.
fn file_of(text: &str) -> Option<&Path> {
    let path = Path::new(text.strip_prefix("inverted:").unwrap_or(text));
    path.exists().then_some(path)
}

/// How a chart is written, by its file's ending.
enum ChartFormat {
    Svg,
    Png,
}

impl ChartFormat {
    fn of(path: &Path) -> Self {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match ending.as_str() {
            "svg" => Self::Svg,
            "png" => Self::Png,
            _ => usage(&format!("{}: charts are written as .svg or .png", path.display())),
        }
    }

    fn write(&self, svg: &str, path: &Path) -> Result<(), Error> {
        match self {
            Self::Svg => output::bytes(path, svg.as_bytes())?,
            Self::Png => output::bytes(path, &plot::png(svg, plot::PIXELS_PER_UNIT)?)?,
        }
        Ok(())
    }
}

/// Ends the program as clap does on a wrong command line.
fn usage(problem: &str) -> ! {
    use clap::CommandFactory as _;
    Cli::command().error(clap::error::ErrorKind::ValueValidation, problem).exit()
}

/// Prints to standard output. Whoever closes the pipe has read enough; any other failure is one.
fn print(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(source) if source.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(OutputError { path: "standard output".into(), source }.into())
        }
        _ => Ok(()),
    }
}

/// A path that a record can hold: in UTF-8.
fn utf8_path() -> impl TypedValueParser<Value = PathBuf> {
    StringValueParser::new().map(PathBuf::from)
}

/// The command line, for the record.
fn command_line() -> Vec<String> {
    std::env::args_os().map(|arg| arg.to_string_lossy().into_owned()).collect()
}

/// Runs the program.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    interrupt::install();
    if let Some(threads) = cli.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global()
            .expect("the pool is built once");
    }
    let cache = Cache::of_user();
    let terminal = Terminal::default();
    let result = match &cli.command {
        Command::Pipeline(args) => pipeline::run(args, &cache, &terminal),
        Command::Trace(args) => trace::run(args, &terminal),
        Command::Merge(args) => merge::run(args),
        Command::Signature(args) => signature::run(args).map(|()| None),
        Command::Retrieve(args) => retrieve::run(args, &terminal).map(|()| None),
        Command::Replay(args) => replay::run(args, &terminal),
        Command::Spectra(args) => spectra::run(args).map(|()| None),
        Command::Image(args) => image::run(args, &terminal),
        Command::Export(args) => export::run(args).map(|()| None),
        Command::Import(args) => import::run(args).map(|()| None),
        Command::Grains(args) => grains::run(args, &cache, &terminal),
        Command::Blender(args) => blender::run(args, &cache, &terminal).map(|()| None),
        Command::Picture(args) => picture::run(args, &terminal).map(|()| None),
        Command::Chart(args) => chart::run(args, &cache, &terminal).map(|()| None),
        Command::Stress(args) => stress::run(args, &cache, &terminal).map(|()| None),
        Command::Doctor(args) => doctor::run(args, &cache, &terminal).map(|()| None),
        Command::Schema(args) => schema::run(args).map(|()| None),
        Command::Completions(args) => completions::run(args).map(|()| None),
    };
    match result {
        Ok(None) => ExitCode::SUCCESS,
        Ok(Some(status)) => ExitCode::from(status as u8),
        Err(error) => {
            report(&error);
            ExitCode::from(error.status() as u8)
        }
    }
}

/// A result that was written but is not all that was asked for has a status of its own.
type Outcome = Result<Option<Status>, Error>;

fn report(error: &Error) {
    eprintln!("error: {error}");
    if let Some(hint) = error.hint() {
        eprintln!("  hint: {hint}");
    }
}
