//! The command line: a file for each subcommand, and the arguments that they share.

mod arguments;
mod blender;
mod bundle;
mod cache;
mod chart;
mod completions;
mod diff;
mod doctor;
mod export;
mod grains;
mod image;
mod import;
pub mod interrupt;
mod matching;
mod merge;
mod picture;
mod pipeline;
mod replay;
mod report;
mod retrieve;
pub mod schema;
mod signature;
mod soil;
mod spectra;
mod stress;
mod sweep;
pub mod terminal;
mod trace;

use std::ffi::OsString;
use std::io::Write as _;
use std::sync::{Mutex, PoisonError};

use clap::{CommandFactory as _, Parser, Subcommand};
use rayon::ThreadPoolBuilder;
use serde::Serialize;

use crate::support::cache::Cache;
use crate::support::error::{Error, Failure, Status};
use crate::support::monitor::Monitor;
use crate::support::output::OutputError;
pub use arguments::spectrum;
use terminal::{Terminal, escaped, one_line, tell};

/// Thermal-infrared signatures of soil from the geometry of its grains
#[derive(Parser)]
#[command(version, about)]
struct Cli {
    /// Threads to use; the result does not depend on it [default: all cores]
    #[arg(long, global = true, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// Print all that is known of a result, not only its emissivity and warnings
    #[arg(long, global = true)]
    verbose: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Pipeline(pipeline::Args),
    Soil(soil::Args),
    Sweep(sweep::Args),
    Trace(trace::Args),
    Merge(merge::Args),
    Signature(signature::Args),
    Diff(diff::Args),
    Retrieve(retrieve::Args),
    Match(matching::Args),
    Replay(replay::Args),
    Bundle(bundle::Args),
    Report(report::Args),
    Image(image::Args),
    Export(export::Args),
    Import(import::Args),
    Grains(grains::Args),
    Blender(blender::Args),
    Spectra(spectra::Args),
    Picture(picture::Args),
    Chart(chart::Args),
    Stress(stress::Args),
    Cache(cache::Args),
    Doctor(doctor::Args),
    Schema(schema::Args),
    Completions(completions::Args),
}

/// What every subcommand works with.
pub struct Context<'a> {
    cache: Cache,
    monitor: &'a dyn Monitor,
    verbose: bool,
    /// The command line, for the record.
    command: Vec<String>,
    out: Out,
}

/// Where the answer goes.
enum Out {
    Terminal,
    Kept(Mutex<String>),
}

/// A result that was written but is less than was asked for has a status of its own.
type Outcome = Result<Option<Status>, Error>;

/// Runs the program on a command line, its own name first; returns the exit status.
pub fn run(args: impl IntoIterator<Item = OsString>) -> u8 {
    let args: Vec<OsString> = args.into_iter().collect();
    let cli = match Cli::try_parse_from(&args) {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return error.exit_code() as u8;
        }
    };
    interrupt::install();
    if let Some(threads) = cli.threads {
        let pool = ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().expect("the pool is built once");
    }
    let terminal = Terminal::default();
    match Context::new(&cli, &args, &terminal, Out::Terminal).run(&cli.command) {
        Ok(status) => status.map_or(0, |status| status as u8),
        Err(error) if error.status() == Status::Usage && error.hint().is_none() => {
            let kind = clap::error::ErrorKind::ValueValidation;
            let _ = Cli::command().error(kind, error.to_string()).print();
            Status::Usage as u8
        }
        Err(error) => {
            tell(&one_line(&format!("error: {error}")));
            if let Some(hint) = error.hint() {
                tell(&one_line(&format!("  hint: {hint}")));
            }
            error.status() as u8
        }
    }
}

/// What a command answers to another program.
#[derive(Debug)]
pub struct Answer {
    /// What it printed.
    pub text: String,
    /// Of a result that is less than was asked for.
    pub status: Option<Status>,
}

/// Runs a command line, its own name first, for another program: the answer is returned, and the
/// monitor hears all else.
///
/// # Errors
/// Those of the command, and a command line that is wrong.
pub fn call(args: &[OsString], monitor: &dyn Monitor) -> Result<Answer, Error> {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) if error.exit_code() == 0 => {
            return Ok(Answer { text: error.to_string(), status: None });
        }
        Err(error) => {
            let text = error.to_string();
            return Err(usage(text.trim_start_matches("error: ").trim_end()));
        }
    };
    let context = Context::new(&cli, args, monitor, Out::Kept(Mutex::default()));
    let run = || context.run(&cli.command);
    let status = match cli.threads {
        None => run(),
        Some(threads) => {
            let pool = ThreadPoolBuilder::new().num_threads(threads.into()).build();
            pool.expect("there are threads").install(run)
        }
    }?;
    let Out::Kept(text) = context.out else { unreachable!("it was made above") };
    Ok(Answer { text: text.into_inner().unwrap_or_else(PoisonError::into_inner), status })
}

impl<'a> Context<'a> {
    fn new(cli: &Cli, args: &[OsString], monitor: &'a dyn Monitor, out: Out) -> Self {
        let command = args.iter().map(|arg| arg.to_string_lossy().into_owned()).collect();
        Self { cache: Cache::of_user(), monitor, verbose: cli.verbose, command, out }
    }

    fn run(&self, command: &Command) -> Outcome {
        match command {
            Command::Pipeline(args) => pipeline::run(args, self),
            Command::Soil(args) => soil::run(args, self),
            Command::Sweep(args) => sweep::run(args, self),
            Command::Trace(args) => trace::run(args, self),
            Command::Merge(args) => merge::run(args, self),
            Command::Signature(args) => signature::run(args, self),
            Command::Diff(args) => diff::run(args, self),
            Command::Retrieve(args) => retrieve::run(args, self),
            Command::Match(args) => matching::run(args, self),
            Command::Replay(args) => replay::run(args, self),
            Command::Bundle(args) => bundle::run(args, self),
            Command::Report(args) => report::run(args, self),
            Command::Image(args) => image::run(args, self),
            Command::Export(args) => export::run(args, self),
            Command::Import(args) => import::run(args, self),
            Command::Grains(args) => grains::run(args, self),
            Command::Blender(args) => blender::run(args, self),
            Command::Spectra(args) => spectra::run(args, self),
            Command::Picture(args) => picture::run(args, self),
            Command::Chart(args) => chart::run(args, self),
            Command::Stress(args) => stress::run(args, self),
            Command::Cache(args) => cache::run(args, self),
            Command::Doctor(args) => doctor::run(args, self),
            Command::Schema(args) => schema::run(args, self),
            Command::Completions(args) => completions::run(args, self),
        }
    }

    /// Prints the answer, with names of others made harmless. A closed pipe is no failure: its
    /// reader has read enough.
    fn print(&self, text: &str) -> Result<(), Error> {
        let mut out = match &self.out {
            Out::Terminal => std::io::stdout(),
            Out::Kept(kept) => {
                kept.lock().unwrap_or_else(PoisonError::into_inner).push_str(text);
                return Ok(());
            }
        };
        match out.write_all(escaped(text).as_bytes()).and_then(|()| out.flush()) {
            Err(source) if source.kind() != std::io::ErrorKind::BrokenPipe => {
                Err(OutputError { path: "standard output".into(), source }.into())
            }
            _ => Ok(()),
        }
    }

    /// Prints plain data as JSON.
    fn print_json(&self, value: &impl Serialize) -> Result<(), Error> {
        self.print(&(serde_json::to_string_pretty(value).expect("plain data") + "\n"))
    }

    /// Prints a list below its title, if it has any lines.
    fn print_list(&self, title: &str, lines: &[String]) -> Result<(), Error> {
        match lines {
            [] => Ok(()),
            lines => self.print(&format!("{title}:\n  {}\n", lines.join("\n  "))),
        }
    }
}

/// The command line is wrong.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct WrongUsage(String);

impl Failure for WrongUsage {
    fn status(&self) -> Status {
        Status::Usage
    }
}

/// An error that ends the program as clap does on a wrong command line.
fn usage(problem: &str) -> Error {
    WrongUsage(problem.to_owned()).into()
}
