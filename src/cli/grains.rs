//! `soilsig grains`: the shapes without dust, measured and drawn.

use std::path::PathBuf;

use soilsig::cache::Cache;
use soilsig::error::Error;
use soilsig::grains::{self, Options};

use super::{InBlender, print, utf8_path};

/// Models bare grains of every shape and measures them against what is asked of the shape
#[derive(clap::Args)]
pub struct Args {
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

pub fn run(args: &Args, cache: &Cache) -> Result<(), Error> {
    let options = Options {
        seed: args.seed,
        variants: args.variants,
        blender: args.in_blender.blender(),
        blender_timeout_s: args.in_blender.blender_timeout,
    };
    let report = args.in_blender.run(cache, |cache| grains::make(&options, &args.out, cache))?;
    if args.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&report).expect("plain data")))
    } else {
        print(&format!("{}picture: {}\n", report.words(), args.out.join("grains.png").display()))
    }
}
