//! `soilsig replay`: repeats a run and compares the results.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::arguments::{absolute, ending, named, utf8_path};
use super::bundle::{self, Recorded};
use super::terminal::one_line;
use super::{Context, Outcome, usage};
use crate::pipeline::record::{Output, Record};
use crate::pipeline::{self, Options, Source, inputs};
use crate::support::cache::Cache;
use crate::support::error::{Failure, Status};
use crate::support::output::{self, OutputError};
use crate::support::ro_crate;
use crate::support::scratch::Scratch;
use crate::sweep::{self, record::SWEEP};

/// Repeats a recorded run or sweep and compares the results byte for byte
///
/// A record is a file that anybody may have written: the Blender that it names is not started. It
/// is looked for as in every other command.
#[derive(clap::Args)]
pub struct Args {
    /// The result: its folder, its run.json, sweep.json or ro-crate-metadata.json, or a bundle (.zip)
    #[arg(value_name = "RESULT")]
    record: PathBuf,
    /// Keep the new result in this folder
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Blender to use: its executable, or a Python that can import bpy
    #[arg(long, value_name = "PATH", value_parser = utf8_path())]
    blender: Option<PathBuf>,
}

/// What a record and its repetition have in common.
struct Compared<'a> {
    versions: [&'a BTreeMap<String, String>; 2],
    outputs: [&'a BTreeMap<String, Output>; 2],
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let scratch = Scratch::temporary()?;
    let folder = if ending(&args.record) == "zip" {
        let folder = scratch.path().join("bundle");
        bundle::unpack(&args.record, &folder)?;
        folder
    } else if args.record.is_dir() {
        args.record.clone()
    } else {
        match args.record.parent() {
            Some(folder) if folder != Path::new("") => folder.to_owned(),
            _ => PathBuf::from("."),
        }
    };
    let name = args.record.file_name().unwrap_or_default();
    let is_of_folder =
        folder != args.record && name != ro_crate::FILE && ending(&args.record) == "json";
    let record = if is_of_folder && name != SWEEP {
        Recorded::Run(Record::read(&args.record)?)
    } else {
        Recorded::of(&folder)?.0
    };
    let cache = Cache::of_run(scratch.path().join("cache"));
    let out = args.out.clone().unwrap_or_else(|| scratch.path().join("out"));
    if out.canonicalize().ok().is_some_and(|out| Some(out) == folder.canonicalize().ok()) {
        return Err(usage(
            "--out is the folder of the recorded run, which would be overwritten: name another",
        ));
    }
    let read = match &record {
        Recorded::Run(record) => &record.inputs,
        Recorded::Sweep(record) => &record.inputs,
    };
    let copies = inputs::are_whole(read, &folder);
    let mut lines = changed(read, copies)?;
    let place = |path: &Path| {
        if copies { inputs::copied(path, read, &folder) } else { path.to_owned() }
    };
    let blender = args.blender.as_deref().map(named);
    let of_copies = |file: &Path| if copies { absolute(&place(file)) } else { file.to_owned() };
    let (answer, compared) = match &record {
        Recorded::Run(before) => {
            let source = match &before.options.source {
                Source::Scene(path) => Source::Scene(of_copies(path)),
                coverage @ Source::Coverage(_) => coverage.clone(),
            };
            let grains = before.options.grains.as_deref().map(of_copies);
            let options = Options { source, grains, blender, ..before.options.clone() };
            if let Some(recorded) =
                before.options.blender.as_ref().filter(|_| options.blender.is_none())
            {
                lines.push(format!(
                    "the record names a Blender, which is not started unasked: --blender {}",
                    recorded.display()
                ));
            }
            let after =
                pipeline::run(&options, context.command.clone(), &out, &cache, context.monitor)?;
            let of = Compared {
                versions: [&before.versions, &after.versions],
                outputs: [&before.outputs, &after.outputs],
            };
            of.told(&folder, &out)
        }
        Recorded::Sweep(before) => {
            let ended = sweep::run(&sweep::Options {
                study: &of_copies(&before.study_file),
                out: &out,
                command: &context.command,
                blender: blender.as_deref(),
                blender_timeout_s: before.blender_timeout_s,
                part: None,
                cache: &cache,
                monitor: context.monitor,
            })?;
            let after = ended.record.expect("it was the whole study");
            let of = Compared {
                versions: [&before.versions, &after.versions],
                outputs: [&before.outputs, &after.outputs],
            };
            of.told(&folder, &out)
        }
    };
    let differing = compared.0;
    lines.extend(compared.1);
    let lines: Vec<String> = lines.iter().map(|line| one_line(line)).collect();
    context.print(&format!("{answer}\n  {}\n", lines.join("\n  ")))?;
    if let Some(out) = &args.out {
        context.print(&format!("result in {}\n", out.display()))?;
    }
    Ok((differing > 0).then_some(Status::Differs))
}

/// Which inputs were changed since. Those without a copy must be there.
fn changed(read: &BTreeMap<String, String>, copies: bool) -> Result<Vec<String>, InputGone> {
    let mut lines = Vec::new();
    for (path, sum) in read {
        let file = Path::new(path);
        if copies {
            if file.is_file() && output::sha256_hex(file).is_ok_and(|now| now != *sum) {
                lines.push(format!("input changed since, its copy was used: {path}"));
            }
            continue;
        }
        if file.exists() && !file.is_file() {
            let source = io::Error::other("it is not a file");
            return Err(InputGone(OutputError { path: file.to_owned(), source }));
        }
        if output::sha256_hex(file).map_err(InputGone)? != *sum {
            lines.push(format!("input changed since: {path}"));
        }
    }
    Ok(lines)
}

impl Compared<'_> {
    /// The answer, then how many files differ, and a line for each version and file.
    fn told(&self, folder: &Path, out: &Path) -> (String, (usize, Vec<String>)) {
        let mut lines = Vec::new();
        for (name, version) in self.versions[0] {
            if self.versions[1].get(name) != Some(version) {
                let now = self.versions[1].get(name).map_or("none", String::as_str);
                lines.push(format!("version of {name}: {version} then, {now} now"));
            }
        }
        let mut differing = 0;
        for (file, then) in self.outputs[0] {
            let now = self.outputs[1].get(file);
            let verdict = match now {
                None => "missing now".into(),
                Some(now) if now.sha256 == then.sha256 => "the same".into(),
                Some(now) => {
                    let expected =
                        if now.reproducible { "" } else { " (not counted: it holds times)" };
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
        let files = self.outputs[0].len();
        let answer = match differing {
            0 => format!("the same result: {files} files"),
            n => format!("another result: {n} of {files} files differ"),
        };
        (answer, (differing, lines))
    }
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
