//! `soilsig grains`: measures and draws the shapes without dust; checks the user's own grains.

use std::path::{Path, PathBuf};

use super::arguments::{InBlender, number, positive, utf8_path};
use super::{Context, Outcome};
use crate::beds::own_grains::{self, Grain, OwnGrainsError};
use crate::beds::scan::{self, Wanted};
use crate::products::grains::{self, Options};
use crate::scene::Shape;
use crate::support::error::Status;
use crate::support::file_error::FileError;

/// Models bare grains of every shape and measures them against their descriptors
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    command: Option<Command>,
    /// Folder for the table, the bodies and their picture
    #[arg(long, short, value_name = "FOLDER", default_value = "out/grains",
          value_parser = utf8_path())]
    out: PathBuf,
    /// Seed of the shapes; a scene's own gives the bodies of the scene
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u64).range(..=1 << 53))]
    seed: u64,
    /// Bodies of each shape
    #[arg(long, value_name = "N", default_value_t = 4,
          value_parser = clap::value_parser!(u32).range(1..=1000))]
    variants: u32,
    #[command(flatten)]
    in_blender: InBlender,
    /// Print the report (grains.json) instead of the table
    #[arg(long)]
    json: bool,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Checks a folder of your own grains, without Blender: closed, faces outward, no
    /// self-intersection, one piece, in micrometres, standing for a known shape
    Check {
        /// The folder
        folder: PathBuf,
    },
    /// Makes a grain of your own from a scan: reads a .stl, .ply or .obj mesh, thins it, and writes
    /// NAME.obj and NAME.json in micrometres
    Import(Import),
}

#[derive(clap::Args)]
struct Import {
    /// The scan: one closed body
    scan: PathBuf,
    /// Folder of own grains that the grain is written into
    #[arg(long, short, value_name = "FOLDER", value_parser = utf8_path())]
    out: PathBuf,
    /// The shape that the grain stands for: flake, chip, angular, subangular or worn
    #[arg(long, alias = "size-class", value_name = "SHAPE", value_parser = shape)]
    shape: Shape,
    /// Name of the grain [default: that of the scan's file]
    #[arg(long)]
    name: Option<String>,
    /// Length of the scan's unit, um: 1000 for millimetres
    #[arg(long, value_name = "UM", default_value_t = 1.0, value_parser = positive)]
    unit_um: f64,
    /// How far the thinned surface may lie from the scan, as a share of the diameter, up to 0.1; 0 keeps every
    /// triangle
    #[arg(long, value_name = "X", default_value_t = 0.005, value_parser = deviation)]
    deviation: f64,
}

fn shape(text: &str) -> Result<Shape, String> {
    serde_json::from_value(text.into()).map_err(|error| error.to_string())
}

fn deviation(text: &str) -> Result<f64, String> {
    number(text, 0.0..=0.1, "a number from 0 to 0.1")
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    match &args.command {
        Some(Command::Check { folder }) => return check(folder, context),
        Some(Command::Import(args)) => return import(args, context),
        None => {}
    }
    let options = Options {
        seed: args.seed,
        variants: args.variants,
        blender: args.in_blender.blender(),
        blender_timeout_s: args.in_blender.blender_timeout,
    };
    let make = |cache: &_| grains::make(&options, &args.out, cache, context.monitor);
    let report = args.in_blender.run(&context.cache, make)?;
    if args.json {
        context.print_json(&report)?;
    } else {
        let out = args.out.display();
        context.print(&format!("{}result in {out} (grains.json, grains.png)\n", report.words()))?;
    }
    Ok(None)
}

fn import(args: &Import, context: &Context) -> Outcome {
    let Import { scan, out, shape, name, unit_um, deviation } = args;
    let stem = scan.file_stem().unwrap_or_default().to_string_lossy();
    let name = name.as_deref().unwrap_or(&stem);
    let wanted = Wanted { name, shape: *shape, unit_um: *unit_um, deviation: *deviation };
    let made = scan::bring(scan, out, &wanted)?;
    if made.joined > 0 {
        let joined = made.joined;
        context.print(&format!(
            "{name}: {joined} corners that differ from another by rounding were joined with it\n"
        ))?;
    }
    context.print(&format!(
        "{name}: {:.1} um, {} of {} triangles, surface within about {:.2} um, volume changed by \
         {:.3} % and scaled back\n",
        made.diameter_um,
        made.kept,
        made.scanned,
        made.deviation_um,
        100.0 * made.volume_change
    ))?;
    context.print(&format!("result in {} ({name}.obj, {name}.json)\n", out.display()))?;
    Ok(None)
}

/// Prints what every grain is, or what is wrong with it.
fn check(folder: &Path, context: &Context) -> Outcome {
    let mut status = None;
    for name in own_grains::names(folder)? {
        let line = match Grain::read(folder, &name) {
            Ok(Grain { shape, diameter_um, faces, .. }) => {
                format!("{name}: {}, {diameter_um:.1} um, {faces} faces: sound", shape.name())
            }
            Err(FileError::Wrong { problem, .. }) => {
                status = Some(Status::Input);
                format!("{name}: refused: {problem}")
            }
            Err(error) => return Err(OwnGrainsError::from(error).into()),
        };
        context.print(&(line + "\n"))?;
    }
    Ok(status)
}
