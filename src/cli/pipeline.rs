//! `soilsig pipeline`: from Blender to the emissivity curve.

use std::path::PathBuf;

use super::arguments::{Bands, Changes, Enough, InBlender, absolute, number, tolerance, utf8_path};
use super::{Context, Outcome};
use crate::histogram::estimate;
use crate::pipeline::{self, Auto, HowMany, Options, Source};
use crate::report::terminal;
use crate::scene::{Facets, MOST_PARTICLES};

/// Drops the grains in Blender, traces the bed, and writes its emissivity
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: Which,
    #[command(flatten)]
    changes: Changes,
    /// What the spectra of powders give to facets: the spectrum itself, or that of a facet by which
    /// a pure bed has the powder's spectrum [default: as the scene says]
    #[arg(long, value_enum, value_name = "KIND")]
    facets: Option<Facets>,
    /// Folder for the result [default: out/COVERAGE or out/NAME-OF-THE-SCENE-FILE]
    #[arg(long, short, value_name = "FOLDER", value_parser = utf8_path())]
    out: Option<PathBuf>,
    /// Folder of your own grains: they replace the shapes that they stand for
    #[arg(long, value_name = "FOLDER", value_parser = utf8_path())]
    grains: Option<PathBuf>,
    /// Random seed of shapes, dust, drop and rays; it replaces the scene's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Half-width at 95 % that the total of every band is to reach, all included that can be
    /// measured: rays, beds, rim, floor, hulls, given-up paths. As many beds are dropped as that
    /// takes; some of them until their fines touch if that is needed. With --packings, or of a
    /// placed scene, the half-width of rays and of the spread between beds [default: one bed,
    /// or --packings, with rays to 0.005]
    #[arg(long, value_name = "X", value_parser = tolerance)]
    tolerance: Option<f64>,
    /// Packings (beds) to drop, in place of as many as the tolerance takes. The result of several is
    /// their mean [default: 1, or `auto` with --tolerance]
    #[arg(long, value_name = "N", value_parser = packings)]
    packings: Option<HowMany>,
    /// Trace a field of this many particles: copies of the packing turned at random, not held in
    /// memory
    #[arg(long, value_name = "PARTICLES", value_parser = particles)]
    field: Option<f64>,
    #[command(flatten)]
    enough: Enough,
    #[command(flatten)]
    bands: Bands,
    /// Also export the settled patch as one flat .obj
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
    /// Shipped scene: full, less, sparse, bare, or all of them in one chart; or the share of the
    /// grains' silhouettes to be covered with fines, 0 to 1
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
        _ => Err(format!("{text:?} is not `auto` or a number from 1 to {}", estimate::MOST)),
    }
}

fn particles(text: &str) -> Result<f64, String> {
    number(text, 1.0..=MOST_PARTICLES, format_args!("a number from 1 to {MOST_PARTICLES:e}"))
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let (source, name) = match (&args.scene.coverage, &args.scene.scene) {
        (Some(coverage), _) => (Source::Coverage(coverage.clone()), coverage.clone()),
        (None, Some(path)) => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            (Source::Scene(absolute(path)), stem.into_owned())
        }
        (None, None) => unreachable!("clap asks for one of them"),
    };
    let options = Options {
        source,
        set: args.changes.set.clone(),
        facets: args.facets,
        grains: args.grains.as_deref().map(absolute),
        seed: args.seed,
        packings: match (args.packings, args.tolerance) {
            (Some(packings), _) => packings,
            (None, Some(_)) => HowMany::Planned(Auto::Auto),
            (None, None) => HowMany::Number(1),
        },
        field: args.field,
        tolerance: args.tolerance,
        max_paths: args.enough.max_paths,
        max_seconds: args.enough.max_seconds,
        grid: args.bands.grid()?,
        patch_obj: args.patch_obj,
        blender: args.in_blender.blender(),
        blender_timeout_s: args.in_blender.blender_timeout,
    };
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(name));
    let record = args.in_blender.run(&context.cache, |cache| {
        pipeline::run(&options, context.command.clone(), &out, cache, context.monitor)
    })?;
    if args.json {
        context.print_json(&record)?;
        return Ok(record.status());
    }
    let scene = |(name, reached)| (String::as_str(name), reached, record.cost(name));
    let scenes: Vec<_> = record.reached.iter().map(scene).collect();
    context.print(&terminal::blocks(&scenes, context.verbose))?;
    let files = match record.reached.len() {
        1 => "report.html, signature.csv, signature.svg, run.json",
        _ => "report.html, signatures.svg, run.json, a folder for each scene",
    };
    context.print(&format!("result in {} ({files})\n", out.display()))?;
    Ok(record.status())
}
