//! `soilsig schema`: the formats of files, as JSON Schema.

use super::print;
use crate::scene::Scene;
use crate::support::error::Error;

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

pub fn run(args: &Args) -> Result<(), Error> {
    let schema = match args.format {
        Format::Scene => schemars::schema_for!(Scene),
    };
    print(&format!("{}\n", serde_json::to_string_pretty(&schema).expect("plain data")))
}
