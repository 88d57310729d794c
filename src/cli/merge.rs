//! `soilsig merge`: the tables of shards into that of the whole trace.

use std::path::PathBuf;

use super::{Context, Outcome};
use crate::report::{Report, ToleranceOf, terminal};
use crate::support::output;
use crate::table::merge;

/// Merges the bounce tables of all shards of a trace: byte for byte the table of one run
#[derive(clap::Args)]
pub struct Args {
    /// Bounce tables of `soilsig trace --shard`, all of them, in any order
    #[arg(required = true, value_name = "TABLE")]
    tables: Vec<PathBuf>,
    /// Bounce table to write
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    output::keeps(&args.tables, [&args.out])?;
    output::may_write(&args.out)?;
    let table = merge::merge(&args.tables)?;
    table.write(&args.out)?;
    let (um, tolerance) = (table.stop.asked.grid.wavelengths_um(), table.stop.asked.tolerance);
    let tables = [table];
    let reached = Report::new(&tables, &um, (tolerance, ToleranceOf::Interval), None)?.reached;
    context.print(&terminal::blocks(&[(&tables[0].scene, &reached, None)], context.verbose))?;
    context.print(&format!("table in {}\n", args.out.display()))?;
    Ok(reached.status())
}
