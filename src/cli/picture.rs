//! `soilsig picture`: figures of the pipeline's results.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

use super::arguments::{Changes, ending, number};
use super::{Context, Outcome, usage};
use crate::draw::picture::{self, Look, MOST_PANELS, placed_scene};
use crate::support::error::Error;
use crate::support::output;

/// Draws a grain, the drop or the beds of earlier results; needs no Blender
#[derive(ClapArgs)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// One dusty grain, large
    Grain {
        /// Folder of the pipeline's result, or a placed scene file
        scene: PathBuf,
        /// Prototype of the scene [default: its first]
        #[arg(long, value_name = "NAME")]
        prototype: Option<String>,
        #[command(flatten)]
        changes: Changes,
        #[command(flatten)]
        side: Side,
        #[command(flatten)]
        file: File,
    },
    /// The drop in time, a strip of frames from the release to the rest
    Drop {
        /// Folder of the pipeline's result, with frames.json in it
        scene: PathBuf,
        /// Panels of the strip
        #[arg(long, value_name = "N", default_value_t = 6,
              value_parser = clap::value_parser!(u16).range(2..=MOST_PANELS as i64))]
        frames: u16,
        #[command(flatten)]
        changes: Changes,
        #[command(flatten)]
        side: Side,
        #[command(flatten)]
        file: File,
    },
    /// Several beds side by side at one scale, each with the shares of its materials in the view
    Coverages {
        /// Folders of the pipeline's results, or placed scene files
        #[arg(required = true, num_args = 1..)]
        scenes: Vec<PathBuf>,
        #[command(flatten)]
        changes: Changes,
        #[command(flatten)]
        side: Side,
        #[command(flatten)]
        file: File,
    },
    /// One bed: the sensor's view or, with --zenith or --azimuth, the whole bed from that side
    Patch {
        /// Folder of the pipeline's result, or a placed scene file
        scene: PathBuf,
        #[command(flatten)]
        changes: Changes,
        #[command(flatten)]
        side: Side,
        #[command(flatten)]
        file: File,
    },
}

/// The direction of the view.
#[derive(ClapArgs)]
struct Side {
    /// Angle of the eye from straight above, degrees [default: grain 60, drop 72, coverages 0,
    /// patch 60]
    #[arg(long, value_name = "DEGREES", value_parser = zenith)]
    zenith: Option<f64>,
    /// Angle of the eye's place from +x towards +y, degrees [default: -65; from above north is up]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    azimuth: Option<f64>,
}

#[derive(ClapArgs)]
struct File {
    /// PNG file to write
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Width of the picture, pixels [default: grain and patch 800, drop 1200, coverages 1000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(64..=3000))]
    width_px: Option<u16>,
}

impl Side {
    fn look(&self, zenith_deg: f64, width_px: usize) -> Look {
        let azimuth_deg = self.azimuth.unwrap_or(-65.0);
        Look { zenith_deg: self.zenith.unwrap_or(zenith_deg), azimuth_deg, width_px }
    }
}

impl File {
    /// The width. Before the work it makes sure that the file can be written.
    fn width(&self, default: u16) -> Result<usize, Error> {
        if ending(&self.out) != "png" {
            return Err(usage(&format!("{}: pictures are written as .png", self.out.display())));
        }
        output::may_write(&self.out)?;
        Ok(self.width_px.unwrap_or(default).into())
    }
}

fn zenith(text: &str) -> Result<f64, String> {
    number(text, 0.0..=180.0, "an angle within 0 (straight above) to 180")
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let monitor = context.monitor;
    let file = match &args.what {
        What::Grain { scene, prototype, changes, side, file } => {
            let look = side.look(60.0, file.width(800)?);
            let scene = changes.of(placed_scene(scene)?)?;
            picture::grain(&scene, prototype.as_deref(), look, &file.out, monitor)?;
            file
        }
        What::Drop { scene, frames, changes, side, file } => {
            let look = side.look(72.0, file.width(1200)?);
            let scene = changes.of(placed_scene(scene)?)?;
            picture::drop(&scene, (*frames).into(), look, &file.out, monitor)?;
            file
        }
        What::Coverages { scenes, changes, side, file } => {
            let look = side.look(0.0, file.width(1000)?);
            let read = |path: &PathBuf| changes.of(placed_scene(path)?);
            let scenes = scenes.iter().map(read).collect::<Result<Vec<_>, _>>()?;
            picture::coverages(&scenes, look, &file.out, monitor)?;
            file
        }
        What::Patch { scene, changes, side, file } => {
            let width_px = file.width(800)?;
            let asked = side.zenith.is_some() || side.azimuth.is_some();
            let look = asked.then(|| side.look(60.0, width_px));
            let scene = changes.of(placed_scene(scene)?)?;
            picture::patch(&scene, look, width_px, &file.out, monitor)?;
            file
        }
    };
    context.print(&format!("picture in {}\n", file.out.display()))?;
    Ok(None)
}
