//! `soilsig grains`: measures and draws the shapes without dust; checks the user's own grains.

use std::path::{Path, PathBuf};

use super::arguments::{InBlender, utf8_path};
use super::{Context, Outcome};
use crate::beds::own_grains::{self, Grain, OwnGrainsError};
use crate::products::grains::{self, Options};
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
    /// self-intersection, one piece, convex, in micrometres, of a known size class
    Check {
        /// The folder
        folder: PathBuf,
    },
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    if let Some(Command::Check { folder }) = &args.command {
        return check(folder, context);
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

/// Prints what every grain is, or what is wrong with it.
fn check(folder: &Path, context: &Context) -> Outcome {
    let mut status = None;
    for name in own_grains::names(folder)? {
        let line = match Grain::read(folder, &name) {
            Ok(Grain { size_class, diameter_um, faces, .. }) => {
                format!("{name}: {}, {diameter_um:.1} um, {faces} faces: sound", size_class.name())
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
