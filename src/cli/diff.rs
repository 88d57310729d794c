//! `soilsig diff`: two results, band by band.

use std::path::PathBuf;

use super::{Context, Outcome};
use crate::report::compare::{Curve, Difference};
use crate::support::error::Status;
use crate::support::output;

/// Compares two results by their errors: runs, bounce tables, signatures or spectra
///
/// The exit status is 5 where they differ by more than the errors of both.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run, bounce table, signature.csv or spectrum
    a: PathBuf,
    /// The same, of what is compared with it
    b: PathBuf,
    /// CSV file to write: every band with its difference, half-width and z
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    output::keeps([&args.a, &args.b], &args.out)?;
    let [a, b] = [Curve::read(&args.a)?, Curve::read(&args.b)?];
    let difference = Difference::new(&a, &b)?;
    context.print(&difference.in_words([&a.name, &b.name]))?;
    if let Some(path) = &args.out {
        output::bytes(path, difference.csv_text().as_bytes())?;
        context.print(&format!("result in {}\n", path.display()))?;
    }
    Ok(difference.differs().then_some(Status::Differs))
}
