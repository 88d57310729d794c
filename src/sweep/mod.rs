//! Beds at many points: a study file, the work in batches, and its results.

mod batch;
mod bed;
mod charts;
mod netcdf;
mod page;
pub mod points;
pub mod record;
mod results;
pub mod study;
mod study_check;
mod work;

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::blender::{self, Blender};
use crate::pipeline::Source;
use crate::scene::SceneGeometry;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::lock::Lock;
use crate::support::monitor::Monitor;
use crate::support::{output, scratch};

pub use points::Points;
pub use record::{Ended, Sweep};
pub use study::Study;

/// How a study is run.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// The study file.
    pub study: &'a Path,
    /// Folder for the results.
    pub out: &'a Path,
    /// The command line, for the record.
    pub command: &'a [String],
    /// The Blender asked for.
    pub blender: Option<&'a Path>,
    /// Longest that Blender may take for a bed, seconds.
    pub blender_timeout_s: u64,
    /// Only this part of the beds, counted from 1, and of how many.
    pub part: Option<(usize, usize)>,
    /// Results of stages.
    pub cache: &'a Cache,
    /// Told of progress; can stop the work.
    pub monitor: &'a dyn Monitor,
}

/// Drops and traces the beds of a study that are not in its folder yet. Unless a part was asked
/// for, it then writes the tables, charts and the page of all of them.
///
/// A bed is made in a hidden folder, and moved into its place when it is whole. So a run that was
/// stopped at any moment goes on where it was.
pub fn run(options: &Options) -> Result<Ended, Error> {
    let started = SystemTime::now();
    let study = Study::read(options.study)?;
    let points = Points::of(&study)?;
    // Parts of a study may run side by side: each bed goes into its place whole.
    let _lock = match options.part {
        None => Some(Lock::of(options.out)?),
        Some((part, _)) => Some(Lock::of(&options.out.join(PARTS).join(part.to_string()))?),
    };
    scratch::clear_temporary();
    let blender = match points.scene(0, study.seeds[0])?.geometry {
        SceneGeometry::Packing(_) => Some(blender(options)?),
        SceneGeometry::Placed(_) => None,
    };
    let work = work::Work::of(options, &study, &points, blender.as_ref())?;
    work.run()?;
    let mut inputs = vec![options.study.to_owned()];
    if let Source::Scene(_) = study.source {
        inputs.push(study.scene()?.file);
    }
    let mut sums = work.files.clone();
    for file in inputs {
        let sum = output::sha256_hex(&file)?;
        sums.insert(file, sum);
    }
    if options.part.is_some() {
        return Ok(results::of_part(options, &work.beds));
    }
    results::write(options, &study, &points, &work.beds, blender.as_ref(), sums, started)
}

/// Folder of the locks of parts.
const PARTS: &str = ".parts";

fn blender(options: &Options) -> Result<Blender, Error> {
    let limit = Duration::from_secs(options.blender_timeout_s);
    let found = blender::find(options.blender, options.cache.blenders(), limit, options.monitor)?;
    if let Some(warning) = found.warning() {
        options.monitor.say(&format!("warning: {warning}"));
    }
    Ok(found)
}

/// Files of results, in the order in which they are written.
const FILES: [&str; 9] = [
    "results.csv",
    "beds.csv",
    "failures.csv",
    "results.nc",
    "chart.svg",
    "chart.png",
    "spectra.svg",
    "spectra.png",
    "report.html",
];

fn place(options: &Options, file: &str) -> PathBuf {
    options.out.join(file)
}
