//! `soilsig replay`: repeats a run and compares the results.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::arguments::{named, utf8_path};
use super::terminal::one_line;
use super::{Context, Outcome, usage};
use crate::pipeline::record::Record;
use crate::pipeline::{self, Options};
use crate::support::cache::Cache;
use crate::support::error::{Failure, Status};
use crate::support::output::{self, OutputError};
use crate::support::scratch::Scratch;

/// Repeats a recorded run and compares the results byte for byte
///
/// A record is a file that anybody may have written: the Blender that it names is not started. It
/// is looked for as in every other command.
#[derive(clap::Args)]
pub struct Args {
    /// The run.json of the run
    record: PathBuf,
    /// Keep the new result in this folder
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Blender to use: its executable, or a Python that can import bpy
    #[arg(long, value_name = "PATH", value_parser = utf8_path())]
    blender: Option<PathBuf>,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let before = Record::read(&args.record)?;
    let scratch = Scratch::temporary()?;
    let cache = Cache::of_run(scratch.path().join("cache"));
    let out = args.out.clone().unwrap_or_else(|| scratch.path().join("out"));
    let folder = match args.record.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    if out.canonicalize().ok().is_some_and(|out| Some(out) == folder.canonicalize().ok()) {
        return Err(usage(
            "--out is the folder of the recorded run, which would be overwritten: name another",
        ));
    }
    let mut lines = Vec::new();
    for (path, sum) in &before.inputs {
        let file = Path::new(path);
        if file.exists() && !file.is_file() {
            let source = io::Error::other("it is not a file");
            return Err(InputGone(OutputError { path: file.to_owned(), source }).into());
        }
        if output::sha256_hex(file).map_err(InputGone)? != *sum {
            lines.push(format!("input changed since: {path}"));
        }
    }
    let options = Options { blender: args.blender.as_deref().map(named), ..before.options.clone() };
    if let Some(recorded) = before.options.blender.filter(|_| options.blender.is_none()) {
        lines.push(format!(
            "the record names a Blender, which is not started unasked: --blender {}",
            recorded.display()
        ));
    }
    let after = pipeline::run(&options, context.command.clone(), &out, &cache, context.monitor)?;
    for (name, version) in &before.versions {
        if after.versions.get(name) != Some(version) {
            let now = after.versions.get(name).map_or("none", String::as_str);
            lines.push(format!("version of {name}: {version} then, {now} now"));
        }
    }
    let mut differing = 0;
    for (file, then) in &before.outputs {
        let now = after.outputs.get(file);
        let verdict = match now {
            None => "missing now".into(),
            Some(now) if now.sha256 == then.sha256 => "the same".into(),
            Some(now) => {
                let expected = if now.reproducible { "" } else { " (not counted: it holds times)" };
                // Others may have written the record: no link out of its folder is followed.
                let then = output::within(folder, file);
                let difference = then.map_or_else(
                    |error| error.to_string(),
                    |then| difference(&then, &out.join(file)),
                );
                format!("differs{expected}: {difference}")
            }
        };
        let counts = now.is_none_or(|now| now.sha256 != then.sha256 && now.reproducible);
        differing += usize::from(counts);
        lines.push(format!("{file}: {verdict}"));
    }
    let files = before.outputs.len();
    let answer = match differing {
        0 => format!("the same result: {files} files"),
        n => format!("another result: {n} of {files} files differ"),
    };
    let lines: Vec<String> = lines.iter().map(|line| one_line(line)).collect();
    context.print(&format!("{answer}\n  {}\n", lines.join("\n  ")))?;
    if let Some(out) = &args.out {
        context.print(&format!("result in {}\n", out.display()))?;
    }
    Ok((differing > 0).then_some(Status::Differs))
}

/// An input of a recorded run is gone.
#[derive(Debug, thiserror::Error)]
#[error("an input of the recorded run: {0}")]
struct InputGone(OutputError);

impl Failure for InputGone {
    fn hint(&self) -> Option<String> {
        Some("put it back, or run the pipeline anew".into())
    }

    fn status(&self) -> Status {
        Status::Files
    }
}

/// Where two files differ.
fn difference(then: &Path, now: &Path) -> String {
    let (Ok(then), Ok(now)) = (fs::read(then), fs::read(now)) else {
        return "the old file is gone, and its SHA-256 was another".into();
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
        None => format!("one is longer{lengths}"),
    }
}
