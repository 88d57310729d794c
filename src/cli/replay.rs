//! `soilsig replay`: a run again, and what came out differently.

use std::fs;
use std::path::{Path, PathBuf};

use super::{Outcome, command_line, print, usage};
use crate::pipeline;
use crate::pipeline::record::Record;
use crate::support::cache::Cache;
use crate::support::error::{Failure, Status};
use crate::support::monitor::Monitor;
use crate::support::output::{self, OutputError};

/// Runs a recorded run again, all of it, and compares the results byte for byte
#[derive(clap::Args)]
pub struct Args {
    /// The run.json of the run
    record: PathBuf,
    /// Keep the new result in this folder
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

pub fn run(args: &Args, monitor: &dyn Monitor) -> Outcome {
    let before = Record::read(&args.record)?;
    let scratch =
        tempfile::tempdir().map_err(|source| OutputError { path: std::env::temp_dir(), source })?;
    let cache = Cache::new(scratch.path().join("cache"));
    let out = args.out.clone().unwrap_or_else(|| scratch.path().join("out"));
    let folder = args.record.parent().unwrap_or(Path::new(""));
    let same = |a: &Path, b: &Path| {
        a.canonicalize().ok().is_some_and(|a| Some(a) == b.canonicalize().ok())
    };
    if same(&out, if folder == Path::new("") { Path::new(".") } else { folder }) {
        usage("--out is the folder of the recorded run, which would be overwritten: name another");
    }
    for (path, sum) in &before.inputs {
        if output::sha256_hex(Path::new(path)).map_err(InputGone)? != *sum {
            print(&format!("input changed since: {path}\n"))?;
        }
    }
    let after = pipeline::run(&before.options, command_line(), &out, &cache, monitor)?;
    for (name, version) in &before.versions {
        if after.versions.get(name) != Some(version) {
            let now = after.versions.get(name).map_or("none", String::as_str);
            print(&format!("version of {name}: {version} then, {now} now\n"))?;
        }
    }
    let mut differ = false;
    for (file, then) in &before.outputs {
        let verdict = match after.outputs.get(file) {
            None => "missing now".into(),
            Some(now) if now.sha256 == then.sha256 => "the same".into(),
            Some(now) => {
                differ |= now.reproducible;
                let difference = difference(&folder.join(file), &out.join(file));
                let expected = if now.reproducible {
                    ""
                } else {
                    " (not counted: it differs from run to run)"
                };
                format!("differs{expected}: {difference}")
            }
        };
        differ |= !after.outputs.contains_key(file);
        print(&format!("{file}: {verdict}\n"))?;
    }
    if let Some(out) = &args.out {
        print(&format!("the new result is in {}\n", out.display()))?;
    }
    Ok(differ.then_some(Status::ReplayDiffers))
}

/// An input of a recorded run is gone.
#[derive(Debug, thiserror::Error)]
#[error("an input of the recorded run: {0}")]
struct InputGone(OutputError);

impl Failure for InputGone {
    fn hint(&self) -> Option<String> {
        Some("put it back where it was, or run the pipeline anew".into())
    }

    fn status(&self) -> Status {
        Status::Files
    }
}

/// Where two files differ, in words.
fn difference(then: &Path, now: &Path) -> String {
    let (Ok(then), Ok(now)) = (fs::read(then), fs::read(now)) else {
        return "the old file is not at hand; its SHA-256 is another".into();
    };
    let first = then.iter().zip(&now).position(|(a, b)| a != b);
    let bytes = then.iter().zip(&now).filter(|(a, b)| a != b).count();
    let lengths = if then.len() == now.len() {
        String::new()
    } else {
        format!(", {} bytes then and {} now", then.len(), now.len())
    };
    match first {
        Some(at) => format!("{bytes} bytes, the first at {at}{lengths}"),
        None if lengths.is_empty() => "the old file was changed since it was recorded".into(),
        None => format!("one goes on longer{lengths}"),
    }
}
