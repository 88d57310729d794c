//! `soilsig merge`: the tables of shards into that of the whole trace.

use std::path::PathBuf;

use super::{Outcome, print};
use crate::report::{self, terminal};
use crate::signature;
use crate::signature::budget::{Budget, Origin};
use crate::support::error::{Error, Status};
use crate::support::output;
use crate::table::merge;

/// Puts the bounce tables of all shards of one trace together: byte for byte the table of one run
#[derive(clap::Args)]
pub struct Args {
    /// Bounce tables of `soilsig trace --shard`, all of them, in any order
    #[arg(required = true, value_name = "TABLE")]
    tables: Vec<PathBuf>,
    /// Bounce table to write
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
}

pub fn run(args: &Args) -> Outcome {
    output::keeps(&args.tables, [&args.out])?;
    output::may_write(&args.out)?;
    let table = merge::merge(&args.tables)?;
    table.write(&args.out)?;
    let (name, tolerance) = (table.scene.clone(), table.stop.asked.tolerance);
    let wavelengths_um = table.stop.asked.grid.wavelengths_um();
    let whole = [table];
    let bands = signature::evaluate(&whole, &wavelengths_um)?;
    let budget = Budget::new(&whole, &bands, Origin::Given)?;
    let reached = report::reached(&whole, &bands, &budget, tolerance);
    print(&format!("{name}: {}", terminal::reached(&reached)))?;
    // Where a number of paths was asked for, that is what there is.
    let asked = whole[0].stop.asked.max_paths.is_some();
    Ok::<_, Error>((asked && !reached.tolerance_reached).then_some(Status::ToleranceNotReached))
}
