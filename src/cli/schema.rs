//! `soilsig schema`: the formats of files, as JSON Schema.

use super::{Context, Outcome, print_json};
use crate::scene::Scene;

/// Prints the JSON Schema of a file format
#[derive(clap::Args)]
pub struct Args {
    /// Format
    format: Format,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// Scene files
    Scene,
}

pub fn run(args: &Args, _: &Context) -> Outcome {
    match args.format {
        Format::Scene => print_json(&schemars::schema_for!(Scene))?,
    }
    Ok(None)
}
