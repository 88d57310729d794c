//! `soilsig trace`: a placed scene into its bounce table.

use std::path::PathBuf;

use super::{Bands, Enough, Outcome, print, usage};
use crate::report::{self, terminal};
use crate::scene::Scene;
use crate::signature;
use crate::signature::budget::{Budget, Origin};
use crate::support::error::Status;
use crate::support::monitor::{Monitor, Step};
use crate::support::output;
use crate::table::Prepared;
use crate::table::{Part, Target};
use crate::tracer::trace;
use crate::tracer::trace::Request;

/// Traces a placed scene into a bounce table, which `signature` evaluates
///
/// An interrupted trace leaves what it has in FILE.partial; the same command again goes on from there.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file with placed geometry
    scene: PathBuf,
    /// Bounce table to write
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Seed of the rays, in place of the scene's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    enough: Enough,
    /// Trace exactly so many paths, whatever they reach; paths that can no longer matter at the tolerance are
    /// still given up
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..1 << 40),
          conflicts_with_all = ["max_paths", "max_seconds"])]
    paths: Option<u64>,
    /// Trace one of n parts of those paths, to be put together by `merge`
    #[arg(long, value_name = "I/N", value_parser = shard, requires = "paths")]
    shard: Option<(u64, u64)>,
    #[command(flatten)]
    bands: Bands,
    /// Print what was reached as JSON
    #[arg(long)]
    json: bool,
}

fn shard(text: &str) -> Result<(u64, u64), String> {
    let (number, shards) = text.split_once('/').ok_or("write I/N, as in 1/4")?;
    let read = |text: &str| text.trim().parse::<u64>().map_err(|e| format!("{text:?}: {e}"));
    match (read(number)?, read(shards)?) {
        (number, shards) if (1..=shards).contains(&number) => Ok((number, shards)),
        (number, shards) => {
            Err(format!("there is no shard {number} of {shards}: they count from 1"))
        }
    }
}

pub fn run(args: &Args, monitor: &dyn Monitor) -> Outcome {
    let grid = args.bands.grid();
    let exactly = args.paths.map(|paths| {
        let (number, shards) = args.shard.unwrap_or((1, 1));
        let part = Part::shard(number, shards, paths);
        if part.first == part.end {
            usage(&format!("{paths} paths are too few for {shards} shards"));
        }
        part
    });
    let mut scene = Scene::read(&args.scene)?;
    scene.seed = args.seed.unwrap_or(scene.seed);
    // A place that cannot be written to is known before the work, not after it.
    output::keeps([&args.scene], [&args.out])?;
    output::may_write(&args.out)?;
    let target = Target {
        max_paths: args.enough.max_paths,
        max_seconds: args.enough.max_seconds,
        exactly,
        ..Target::of(args.enough.tolerance)
    };
    let step = Step::new(monitor, "load");
    let tracer = trace::tracer(&scene)?;
    step.done(&format!("{} triangles", tracer.bed().triangles()));
    let step = Step::new(monitor, "trace");
    let mut partial = args.out.clone().into_os_string();
    partial.push(".partial");
    let partial = PathBuf::from(partial);
    let prepared = Prepared::new(scene, &grid.wavelengths_um())?;
    let request = Request { partial: Some(&partial), ..Request::new(&grid, target) };
    let table = trace::trace(&tracer, &prepared, request, monitor)?;
    table.write(&args.out)?;
    output::remove(&partial)?;
    step.done(&format!("{} paths, {} hits", table.paths, table.hits));
    let all_reached = table.stop.reached.tolerance || exactly.is_some();
    let packings = [table];
    let bands = signature::evaluate(&packings, &grid.wavelengths_um())?;
    let budget = Budget::new(&packings, &bands, Origin::Given)?;
    let reached = report::reached(&packings, &bands, &budget, args.enough.tolerance);
    if args.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&reached).expect("plain data")))?;
    } else {
        print(&format!("{}: {}", prepared.scene.name, terminal::reached(&reached)))?;
    }
    Ok((!all_reached).then_some(Status::ToleranceNotReached))
}
