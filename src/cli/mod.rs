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
mod spectra;
mod stress;
mod sweep;
pub mod terminal;
mod trace;

use std::io::Write as _;
use std::process::ExitCode;

use clap::{CommandFactory as _, Parser, Subcommand};
use serde::Serialize;

use crate::support::cache::Cache;
use crate::support::error::{Error, Status};
use crate::support::output::OutputError;
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
pub struct Context {
    cache: Cache,
    terminal: Terminal,
    verbose: bool,
}

/// A result that was written but is less than was asked for has a status of its own.
type Outcome = Result<Option<Status>, Error>;

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
    let terminal = Terminal::default();
    let context = Context { cache: Cache::of_user(), terminal, verbose: cli.verbose };
    let result = match &cli.command {
        Command::Pipeline(args) => pipeline::run(args, &context),
        Command::Sweep(args) => sweep::run(args, &context),
        Command::Trace(args) => trace::run(args, &context),
        Command::Merge(args) => merge::run(args, &context),
        Command::Signature(args) => signature::run(args, &context),
        Command::Diff(args) => diff::run(args, &context),
        Command::Retrieve(args) => retrieve::run(args, &context),
        Command::Match(args) => matching::run(args, &context),
        Command::Replay(args) => replay::run(args, &context),
        Command::Bundle(args) => bundle::run(args, &context),
        Command::Report(args) => report::run(args, &context),
        Command::Image(args) => image::run(args, &context),
        Command::Export(args) => export::run(args, &context),
        Command::Import(args) => import::run(args, &context),
        Command::Grains(args) => grains::run(args, &context),
        Command::Blender(args) => blender::run(args, &context),
        Command::Spectra(args) => spectra::run(args, &context),
        Command::Picture(args) => picture::run(args, &context),
        Command::Chart(args) => chart::run(args, &context),
        Command::Stress(args) => stress::run(args, &context),
        Command::Cache(args) => cache::run(args, &context),
        Command::Doctor(args) => doctor::run(args, &context),
        Command::Schema(args) => schema::run(args, &context),
        Command::Completions(args) => completions::run(args, &context),
    };
    match result {
        Ok(status) => status.map_or(ExitCode::SUCCESS, |status| ExitCode::from(status as u8)),
        Err(error) => {
            tell(&one_line(&format!("error: {error}")));
            if let Some(hint) = error.hint() {
                tell(&one_line(&format!("  hint: {hint}")));
            }
            ExitCode::from(error.status() as u8)
        }
    }
}

/// Ends the program as clap does on a wrong command line.
fn usage(problem: &str) -> ! {
    Cli::command().error(clap::error::ErrorKind::ValueValidation, problem).exit()
}

/// Prints to standard output, with names of others made harmless. A closed pipe is no failure: its reader has read enough.
fn print(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout();
    match out.write_all(escaped(text).as_bytes()).and_then(|()| out.flush()) {
        Err(source) if source.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(OutputError { path: "standard output".into(), source }.into())
        }
        _ => Ok(()),
    }
}

/// Prints plain data as JSON.
fn print_json(value: &impl Serialize) -> Result<(), Error> {
    print(&(serde_json::to_string_pretty(value).expect("plain data") + "\n"))
}

/// Prints a list below its title, if it has any lines.
fn print_list(title: &str, lines: &[String]) -> Result<(), Error> {
    if lines.is_empty() { Ok(()) } else { print(&format!("{title}:\n  {}\n", lines.join("\n  "))) }
}

/// The command line, for the record.
fn command_line() -> Vec<String> {
    std::env::args_os().map(|arg| arg.to_string_lossy().into_owned()).collect()
}
