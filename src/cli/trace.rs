//! `soilsig trace`: a placed scene into its bounce table.

use std::path::PathBuf;

use super::arguments::{Bands, Changes, Enough, TOLERANCE, tolerance};
use super::{Context, Outcome, usage};
use crate::report::{Report, ToleranceOf, terminal};
use crate::support::error::{Failure, Status};
use crate::support::monitor::Step;
use crate::support::output;
use crate::table::{Part, Prepared, Target};
use crate::tracer::trace::{self, Request};

/// Traces a placed scene into a bounce table, which `signature` evaluates
///
/// An interrupted trace leaves FILE.partial; the same command continues from there.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file with placed geometry
    scene: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Bounce table to write
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Random seed of the rays; it replaces the scene's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Half-width of the 95 % interval in emissivity that every band is to reach
    #[arg(long, value_name = "X", default_value_t = TOLERANCE, value_parser = tolerance)]
    tolerance: f64,
    #[command(flatten)]
    enough: Enough,
    /// Trace exactly this number of paths, whatever they reach. Paths too weak to matter at the
    /// tolerance are still given up
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..1 << 40),
          conflicts_with_all = ["max_paths", "max_seconds"])]
    paths: Option<u64>,
    /// Trace one of n parts of those paths, which `merge` puts together
    #[arg(long, value_name = "I/N", value_parser = shard, requires = "paths")]
    shard: Option<(u64, u64)>,
    #[command(flatten)]
    bands: Bands,
    /// Print the numbers of the result as JSON
    #[arg(long)]
    json: bool,
}

fn shard(text: &str) -> Result<(u64, u64), String> {
    let (number, shards) = text.split_once('/').ok_or("write I/N, as in 1/4")?;
    let read = |text: &str| text.trim().parse::<u64>().map_err(|e| format!("{text:?}: {e}"));
    match (read(number)?, read(shards)?) {
        (number, shards) if (1..=shards).contains(&number) => Ok((number, shards)),
        (number, shards) => Err(format!("{number}/{shards} is not a shard: they count from 1")),
    }
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let um = args.bands.grid()?.wavelengths_um();
    let exactly = args.paths.map(|paths| {
        let (number, shards) = args.shard.unwrap_or((1, 1));
        let part = Part::shard(number, shards, paths);
        if part.first == part.end {
            return Err(usage(&format!("{paths} paths are too few for {shards} shards")));
        }
        Ok(part)
    });
    let exactly = exactly.transpose()?;
    let mut scene = args.changes.read(&args.scene)?;
    scene.seed = args.seed.unwrap_or(scene.seed);
    // Before the work, not after it.
    output::keeps([&args.scene], [&args.out])?;
    output::may_write(&args.out)?;
    let tolerance = args.tolerance;
    let Enough { max_paths, max_seconds } = args.enough;
    let target = Target { max_paths, max_seconds, exactly, ..Target::of(tolerance) };
    let monitor = context.monitor;
    let step = Step::new(monitor, "load");
    let tracer = trace::tracer(&scene)?;
    step.done(&format!("{} triangles", tracer.bed().triangles()));
    let step = Step::new(monitor, "trace");
    let name = args.out.file_name().unwrap_or_default().to_string_lossy();
    let partial = output::sibling(&args.out, &format!("{name}.partial"))?;
    let prepared = Prepared::new(scene, &um)?;
    let grid = args.bands.grid()?;
    // Beside a device or a pipe nothing is left.
    let partial = output::is_file(&args.out).then_some(&*partial);
    let request = Request { partial, ..Request::new(&grid, target) };
    let table =
        trace::trace(&tracer, &prepared, request, monitor).map_err(|error| {
            match partial.filter(|partial| error.is_interruption() && partial.is_file()) {
                Some(partial) => InterruptedTrace { partial: partial.to_owned() }.into(),
                None => error,
            }
        })?;
    table.write(&args.out)?;
    partial.map_or(Ok(()), output::remove)?;
    step.done(&format!("{} paths, {} hits", table.paths, table.hits));
    let reached = Report::new(&[table], &um, (tolerance, ToleranceOf::Interval), None)?.reached;
    if args.json {
        context.print_json(&reached)?;
    } else {
        let name = &prepared.scene.name;
        context.print(&terminal::blocks(&[(name, &reached, None)], context.verbose))?;
        context.print(&format!("table in {}\n", args.out.display()))?;
    }
    Ok(reached.status())
}

/// The user asked to stop; the paths so far are saved.
#[derive(Debug, thiserror::Error)]
#[error("interrupted; the paths so far are in {}", partial.display())]
struct InterruptedTrace {
    partial: PathBuf,
}

impl Failure for InterruptedTrace {
    fn hint(&self) -> Option<String> {
        Some("the same command goes on from there".into())
    }

    fn status(&self) -> Status {
        Status::Interrupted
    }
}
