//! `soilsig schema`: the formats of files, as JSON Schema.

use serde_json::Value;

use super::{Context, Outcome};
use crate::inverse::files;
use crate::inverse::result::Match;
use crate::pipeline::record::Record;
use crate::scene::Scene;
use crate::signature::{budget, csv, in_bands};
use crate::sweep::{Study, Sweep};

/// Prints the JSON Schema of a file format
#[derive(clap::Args)]
pub struct Args {
    /// Format
    format: Format,
}

/// A file format.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Format {
    /// Scene files
    Scene,
    /// Study files
    Study,
    /// run.json, the record of a run
    Run,
    /// sweep.json, the record of a sweep
    Sweep,
    /// match.json, the result of a match
    Match,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    context.print_json(&of(args.format))?;
    Ok(None)
}

/// The schema of a format.
pub fn of(format: Format) -> Value {
    match format {
        Format::Scene => schemars::schema_for!(Scene),
        Format::Study => schemars::schema_for!(Study),
        Format::Run => schemars::schema_for!(Record),
        Format::Sweep => schemars::schema_for!(Sweep),
        Format::Match => schemars::schema_for!(Match),
    }
    .into()
}

/// The columns of each CSV file of a run, with their meanings.
pub fn column_lists() -> [(&'static str, Vec<(&'static str, &'static str)>); 4] {
    [
        ("signature.csv", csv::columns()),
        ("budget.csv", budget::COLUMNS.to_vec()),
        ("the bands of sensors", in_bands::COLUMNS.to_vec()),
        ("match.csv", files::COLUMNS.to_vec()),
    ]
}
