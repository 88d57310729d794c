//! `soilsig stress`: the atlas of failure.

use std::path::PathBuf;

use super::arguments::utf8_path;
use super::{Context, Outcome, usage};
use crate::studies::stress::{self, Setting};
use crate::support::lock::Lock;
use crate::support::monitor::Step;

/// Drives the method to where it fails, and records whether the program says so
///
/// Writes a CSV file for each row, a page of charts (atlas.svg, atlas.png) and a table (atlas.md).
#[derive(clap::Args)]
pub struct Args {
    /// Folder for the atlas
    #[arg(long, short, value_name = "FOLDER", default_value = "out/stress",
          value_parser = utf8_path())]
    out: PathBuf,
    /// Fewer points and rays
    #[arg(long)]
    quick: bool,
    /// Only these rows
    #[arg(long, value_name = "NAME", num_args = 1..)]
    rows: Vec<String>,
    /// Leave out the rows that drop grains in Blender
    #[arg(long)]
    without_blender: bool,
    /// Blender to use: its executable, or a Python that can import bpy
    #[arg(long, value_name = "PATH", value_parser = utf8_path())]
    blender: Option<PathBuf>,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let &Context { ref cache, monitor, .. } = context;
    if let Some(unknown) = args.rows.iter().find(|name| !stress::names().any(|row| row == **name)) {
        let names: Vec<&str> = stress::names().collect();
        return Err(usage(&format!("{unknown:?} is not a row; the rows are {}", names.join(", "))));
    }
    let _lock = Lock::of(&args.out)?;
    let setting = Setting {
        quick: args.quick,
        cache,
        blender: args.blender.as_deref(),
        without_blender: args.without_blender,
        monitor,
    };
    let mut rows = Vec::new();
    for name in
        stress::names().filter(|name| args.rows.is_empty() || args.rows.iter().any(|n| n == name))
    {
        let step = Step::new(monitor, name);
        let row = stress::row(name, &setting)?;
        step.done(&format!("{} points", row.points.len()));
        context.print(&stress::line(&row))?;
        rows.push(row);
    }
    stress::write(&rows, &args.out)?;
    Ok(None)
}
