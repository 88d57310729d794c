//! `soilsig trace`: a placed scene into its bounce table.

use std::path::PathBuf;

use soilsig::error::Status;
use soilsig::progress::Step;
use soilsig::scene::Scene;
use soilsig::stop::Target;
use soilsig::{output, report, signature, trace, words};

use super::{Bands, Enough, Outcome, print};

/// Traces a placed scene into a bounce table, which `signature` evaluates
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
    #[command(flatten)]
    bands: Bands,
    /// Print what was reached as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let wavelengths_um = args.bands.grid().wavelengths_um();
    let mut scene = Scene::read(&args.scene)?;
    scene.seed = args.seed.unwrap_or(scene.seed);
    // A place that cannot be written to is known before the work, not after it.
    output::may_write(&args.out)?;
    let target = Target { tolerance: args.enough.tolerance, max_paths: args.enough.max_paths };
    let step = Step::new("load");
    let tracer = trace::tracer(&scene, &args.scene)?;
    step.done(&format!("{} triangles", tracer.bed().triangles()));
    let step = Step::new("trace");
    let table =
        trace::trace(&tracer, &scene, &args.scene, &wavelengths_um, target, &|done, of| {
            step.at(done, of, "paths");
        })?;
    table.write(&args.out)?;
    step.done(&format!("{} paths, {} hits", table.paths, table.hits));
    let reached_all = table.stop.reached;
    let packings = [table];
    let bands = signature::evaluate(&packings, &wavelengths_um)?;
    let reached = report::reached(&packings, &bands, args.enough.tolerance);
    if args.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&reached).expect("plain data")))?;
    } else {
        print(&format!("{}: {}", scene.name, words::reached(&reached)))?;
    }
    Ok((!reached_all).then_some(Status::ToleranceNotReached))
}
