//! `soilsig picture`: figures of the pipeline's results.

use std::path::{Path, PathBuf};

use clap::{Args as ClapArgs, Subcommand};

use super::arguments::{Changes, ending, number};
use super::{Context, Outcome, usage};
use crate::draw::picture::{self, Look, MOST_PANELS, placed_scene};
use crate::scene::Scene;
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
        drawn: Drawn,
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
        drawn: Drawn,
    },
    /// Several beds side by side at one scale, each with the shares of its materials in the view
    Coverages {
        /// Folders of the pipeline's results, or placed scene files
        #[arg(required = true, num_args = 1..)]
        scenes: Vec<PathBuf>,
        #[command(flatten)]
        drawn: Drawn,
    },
    /// One bed: the sensor's view or, with --zenith or --azimuth, the whole bed from that side
    Patch {
        /// Folder of the pipeline's result, or a placed scene file
        scene: PathBuf,
        #[command(flatten)]
        drawn: Drawn,
    },
}

/// How it is drawn, and where to.
#[derive(ClapArgs)]
struct Drawn {
    #[command(flatten)]
    changes: Changes,
    /// Angle of the eye from straight above, degrees [default: grain 60, drop 72, coverages 0,
    /// patch 60]
    #[arg(long, value_name = "DEGREES", value_parser = zenith)]
    zenith: Option<f64>,
    /// Angle of the eye's place from +x towards +y, degrees [default: -65; from above north is up]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    azimuth: Option<f64>,
    /// PNG file to write
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Width of the picture, pixels [default: grain and patch 800, drop 1200, coverages 1000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(64..=3000))]
    width_px: Option<u16>,
}

impl Drawn {
    fn look(&self, zenith_deg: f64, width_px: usize) -> Look {
        let azimuth_deg = self.azimuth.unwrap_or(-65.0);
        Look { zenith_deg: self.zenith.unwrap_or(zenith_deg), azimuth_deg, width_px }
    }

    /// The width. Before the work it makes sure that the file can be written.
    fn width(&self, default: u16) -> Result<usize, Error> {
        if ending(&self.out) != "png" {
            return Err(usage(&format!("{}: pictures are written as .png", self.out.display())));
        }
        output::may_write(&self.out)?;
        Ok(self.width_px.unwrap_or(default).into())
    }

    fn scene(&self, path: &Path) -> Result<Scene, Error> {
        self.changes.of(placed_scene(path)?)
    }
}

fn zenith(text: &str) -> Result<f64, String> {
    number(text, 0.0..=180.0, "an angle within 0 (straight above) to 180")
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let monitor = context.monitor;
    let drawn = match &args.what {
        What::Grain { scene, prototype, drawn } => {
            let look = drawn.look(60.0, drawn.width(800)?);
            let scene = drawn.scene(scene)?;
            picture::grain(&scene, prototype.as_deref(), look, &drawn.out, monitor)?;
            drawn
        }
        What::Drop { scene, frames, drawn } => {
            let look = drawn.look(72.0, drawn.width(1200)?);
            picture::drop(&drawn.scene(scene)?, (*frames).into(), look, &drawn.out, monitor)?;
            drawn
        }
        What::Coverages { scenes, drawn } => {
            let look = drawn.look(0.0, drawn.width(1000)?);
            let scenes =
                scenes.iter().map(|path| drawn.scene(path)).collect::<Result<Vec<_>, _>>()?;
            picture::coverages(&scenes, look, &drawn.out, monitor)?;
            drawn
        }
        What::Patch { scene, drawn } => {
            let width_px = drawn.width(800)?;
            let asked = drawn.zenith.is_some() || drawn.azimuth.is_some();
            let look = asked.then(|| drawn.look(60.0, width_px));
            picture::patch(&drawn.scene(scene)?, look, width_px, &drawn.out, monitor)?;
            drawn
        }
    };
    context.print(&format!("picture in {}\n", drawn.out.display()))?;
    Ok(None)
}
