//! `soilsig pipeline`: from Blender to the emissivity curve.

use std::path::PathBuf;

use super::{Bands, Enough, InBlender, Outcome, command_line, print, utf8_path};
use crate::histogram::estimate;
use crate::pipeline::{self, Auto, HowMany, Options, Source};
use crate::scene::MOST_PARTICLES;
use crate::support::cache::Cache;
use crate::support::error::Status;
use crate::support::monitor::Monitor;

/// Models and drops the grains in Blender, traces the bed, writes its signature
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: Which,
    /// Folder for the result [default: out/COVERAGE or out/NAME-OF-THE-SCENE-FILE]
    #[arg(long, short, value_name = "FOLDER", value_parser = utf8_path())]
    out: Option<PathBuf>,
    /// Folder of your own grains: each shape gives way to the grains whose size class it is
    #[arg(long, value_name = "FOLDER", value_parser = utf8_path())]
    grains: Option<PathBuf>,
    /// Seed of shapes, dust, drop and rays, in place of the scene's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Packings to drop: with several the result is their mean, and its interval holds the spread between
    /// them. `auto` drops a few and then as many as the tolerance takes by their spread, until their fines
    /// touch if it has to
    #[arg(long, value_name = "N", default_value = "1", value_parser = packings)]
    packings: HowMany,
    /// Trace a field of so many particles, of which the packing is a patch: copies turned at random, not held
    /// in memory
    #[arg(long, value_name = "PARTICLES", value_parser = particles)]
    field: Option<f64>,
    #[command(flatten)]
    enough: Enough,
    #[command(flatten)]
    bands: Bands,
    /// Export the settled patch as one flat .obj too
    #[arg(long)]
    patch_obj: bool,
    #[command(flatten)]
    in_blender: InBlender,
    /// Print the record of the run (run.json) on standard output
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Which {
    /// Shipped scene: full, less, sparse, bare, or all of them in one chart; or the share of the grains'
    /// silhouettes that is to be fines, 0 to 1
    #[arg(long, value_name = "COVERAGE")]
    coverage: Option<String>,
    /// Scene file of your own, packing or placed
    #[arg(long, value_name = "FILE", value_parser = utf8_path())]
    scene: Option<PathBuf>,
}

fn packings(text: &str) -> Result<HowMany, String> {
    match text.parse() {
        Ok(number @ 1..=estimate::MOST) => Ok(HowMany::Number(number)),
        _ if text == "auto" => Ok(HowMany::Planned(Auto::Auto)),
        _ => Err(format!("it must be `auto` or a number from 1 to {}", estimate::MOST)),
    }
}

fn particles(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (1.0..=MOST_PARTICLES).contains(&x) => Ok(x),
        _ => Err(format!("it must be a number from 1 to {MOST_PARTICLES:e}")),
    }
}

pub fn run(args: &Args, cache: &Cache, monitor: &dyn Monitor) -> Outcome {
    let (source, name) = match (&args.scene.coverage, &args.scene.scene) {
        (Some(coverage), _) => (Source::Coverage(coverage.clone()), coverage.clone()),
        (None, Some(path)) => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            (Source::Scene(std::path::absolute(path).unwrap_or(path.clone())), stem.into_owned())
        }
        (None, None) => unreachable!("clap asks for one of them"),
    };
    let options = Options {
        source,
        grains: args.grains.as_ref().map(|path| std::path::absolute(path).unwrap_or(path.clone())),
        seed: args.seed,
        packings: args.packings,
        field: args.field,
        tolerance: args.enough.tolerance,
        max_paths: args.enough.max_paths,
        max_seconds: args.enough.max_seconds,
        grid: args.bands.grid(),
        patch_obj: args.patch_obj,
        blender: args.in_blender.blender(),
        blender_timeout_s: args.in_blender.blender_timeout,
    };
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(name));
    let command = command_line();
    let record = args
        .in_blender
        .run(cache, |cache| pipeline::run(&options, command, &out, cache, monitor))?;
    if args.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&record).expect("plain data")))?;
    } else {
        print(&crate::pipeline::record::in_words(&record, &out))?;
    }
    Ok((!record.tolerance_reached()).then_some(Status::ToleranceNotReached))
}
