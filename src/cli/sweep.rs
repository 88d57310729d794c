//! `soilsig sweep`: the beds of a study, in batches.

use std::path::PathBuf;

use super::arguments::{InBlender, absolute, utf8_path};
use super::{Context, Outcome};
use crate::sweep::{self, Options};

/// Drops and traces the beds of a study: a scene at many points
///
/// A run that was stopped goes on where it was: finished beds are not made again. The results are a
/// table, a NetCDF file, charts and a page.
#[derive(clap::Args)]
pub struct Args {
    /// Study file (JSON; docs: sweeps)
    #[arg(value_parser = utf8_path())]
    study: PathBuf,
    /// Folder for the results [default: out/NAME-OF-THE-STUDY-FILE]
    #[arg(long, short, value_name = "FOLDER", value_parser = utf8_path())]
    out: Option<PathBuf>,
    /// Only part K of N of the beds, as on a cluster. A last run without it writes the results
    #[arg(long, value_name = "K/N", value_parser = part)]
    part: Option<(usize, usize)>,
    #[command(flatten)]
    in_blender: InBlender,
    /// Print the record (sweep.json) on standard output
    #[arg(long)]
    json: bool,
}

fn part(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((k, n)) if (1..=n).contains(&k) => Ok((k, n)),
        _ => Err("write K/N, as in 3/20".into()),
    }
}

/// Reasons of failures that are printed.
const MOST_REASONS: usize = 5;

pub fn run(args: &Args, context: &Context) -> Outcome {
    let stem = args.study.file_stem().unwrap_or_default();
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(stem));
    let ended = args.in_blender.run(&context.cache, |cache| {
        sweep::run(&Options {
            study: &absolute(&args.study),
            out: &out,
            command: &context.command,
            blender: args.in_blender.blender().as_deref(),
            blender_timeout_s: args.in_blender.blender_timeout,
            part: args.part,
            cache,
            monitor: context.monitor,
        })
    })?;
    if let (true, Some(record)) = (args.json, &ended.record) {
        context.print_json(record)?;
        return Ok(ended.status());
    }
    context.print(&format!("{}\n", ended.answer))?;
    let mut reasons = ended.failed.clone();
    reasons.truncate(MOST_REASONS);
    let title = format!("{} beds failed, as failures.csv says", ended.failed.len());
    context.print_list(&title, &reasons)?;
    if ended.record.is_some() {
        context.print(&format!(
            "result in {} (report.html, results.csv, results.nc)\n",
            out.display()
        ))?;
    }
    Ok(ended.status())
}
