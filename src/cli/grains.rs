//! `soilsig grains`: the shapes without dust, measured and drawn; grains of the user's own, checked.

use std::path::PathBuf;

use super::{InBlender, Outcome, print, utf8_path};
use crate::beds::own_grains::{self, Grain, OwnGrainsError};
use crate::products::grains::{self, Options};
use crate::support::cache::Cache;
use crate::support::error::Status;
use crate::support::file_error::FileError;
use crate::support::monitor::Monitor;

/// Models bare grains of every shape and measures them against what is asked of the shape
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    command: Option<Command>,
    /// Folder for the table, the bodies and their picture
    #[arg(long, short, value_name = "FOLDER", default_value = "out/grains", value_parser = utf8_path())]
    out: PathBuf,
    /// Seed of the shapes; a scene's own gives the bodies of the scene
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=1 << 53))]
    seed: u64,
    /// Bodies of each shape
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    variants: u32,
    #[command(flatten)]
    in_blender: InBlender,
    /// Print the report (grains.json) instead of the table
    #[arg(long)]
    json: bool,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Checks a folder of your own grains, without Blender: closed, outward, not through itself, one piece,
    /// convex, in micrometres, of a known size class
    Check {
        /// The folder
        folder: PathBuf,
    },
}

pub fn run(args: &Args, cache: &Cache, monitor: &dyn Monitor) -> Outcome {
    if let Some(Command::Check { folder }) = &args.command {
        return check(folder);
    }
    let options = Options {
        seed: args.seed,
        variants: args.variants,
        blender: args.in_blender.blender(),
        blender_timeout_s: args.in_blender.blender_timeout,
    };
    let report =
        args.in_blender.run(cache, |cache| grains::make(&options, &args.out, cache, monitor))?;
    if args.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&report).expect("plain data")))?;
    } else {
        let picture = args.out.join("grains.png");
        print(&format!("{}picture: {}\n", report.words(), picture.display()))?;
    }
    Ok(None)
}

/// Says of every grain what it is, or what is wrong with it.
fn check(folder: &std::path::Path) -> Outcome {
    let mut refused = false;
    for name in own_grains::names(folder)? {
        match Grain::read(folder, &name) {
            Ok(grain) => print(&format!(
                "{name}: {}, {:.1} um, {} faces: sound\n",
                grain.size_class.name(),
                grain.diameter_um,
                grain.faces
            ))?,
            Err(FileError::Wrong { problem, .. }) => {
                refused = true;
                print(&format!("{name}: refused: {problem}\n"))?;
            }
            Err(error) => return Err(OwnGrainsError::from(error).into()),
        }
    }
    Ok(refused.then_some(Status::Input))
}
