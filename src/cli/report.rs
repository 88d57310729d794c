//! `soilsig report`: the pages of earlier runs.

use std::path::{Path, PathBuf};

use super::{Context, Outcome};
use crate::pipeline::page::{self, PAGE};
use crate::support::output;

/// Writes a page of earlier runs: of one run anew, of several a comparison
///
/// A page is one file. It is opened in a browser, without a server and without a network.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of runs of the pipeline
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Page to write
    #[arg(long, short, value_name = "FILE", default_value = PAGE)]
    out: PathBuf,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let folder = |path: &'_ PathBuf| -> PathBuf {
        let is_record = path.file_name().is_some_and(|name| name == "run.json");
        let parent = path.parent().filter(|_| is_record);
        parent.map_or_else(|| path.clone(), Path::to_owned)
    };
    let folders: Vec<PathBuf> = args.runs.iter().map(folder).collect();
    output::keeps(folders.iter().map(|folder| folder.join("run.json")), [&args.out])?;
    output::may_write(&args.out)?;
    let html = page::of_runs(&folders.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    output::bytes(&args.out, html.as_bytes())?;
    context.print(&format!("page in {}\n", args.out.display()))?;
    Ok(None)
}
