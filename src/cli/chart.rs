//! `soilsig chart`: error against time.

use std::path::PathBuf;
use std::time::Duration;

use super::arguments::{Bands, Changes, InBlender, tolerance};
use super::{Context, Outcome};
use crate::blender;
use crate::scene::{Scene, SceneGeometry, shipped};
use crate::studies::chart::{self, Maker};
use crate::support::lock::Lock;

/// Charts the error of the emissivity against computing time, for every setting that trades them
///
/// Charts the trace of a placed scene. A packing's beds are charted too, which takes Blender and
/// some minutes.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file, or the name of a shipped scene: full, less, sparse, bare
    scene: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Folder for chart.csv, chart.svg and chart.png
    #[arg(long, short, value_name = "FOLDER")]
    out: PathBuf,
    /// Half-width of the 95 % interval that is marked in the chart
    #[arg(long, value_name = "X", default_value_t = 0.005, value_parser = tolerance)]
    tolerance: f64,
    /// Also chart settings measured elsewhere, in the columns of chart.csv
    #[arg(long, value_name = "FILE.csv")]
    beside: Option<PathBuf>,
    /// Fewer settings and a shorter reference
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    bands: Bands,
    #[command(flatten)]
    in_blender: InBlender,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let &Context { ref cache, monitor, .. } = context;
    let path = &args.scene;
    let scene = match shipped::text(&path.to_string_lossy()) {
        Some(text) => args.changes.of(Scene::parse(text, path)?)?,
        None => args.changes.read(path)?,
    };
    let grid = args.bands.grid()?;
    let beside = args.beside.as_deref().map(chart::beside).transpose()?;
    let _lock = Lock::of(&args.out)?;
    let mut trade = match &scene.geometry {
        SceneGeometry::Placed(_) => chart::patch(&scene, &grid, args.quick, monitor)?,
        SceneGeometry::Packing(packing) => {
            let wanted = args.in_blender.blender();
            let time_limit = Duration::from_secs(args.in_blender.blender_timeout);
            let cache = cache.blenders();
            let blender = blender::find(wanted.as_deref(), cache, time_limit, monitor)?;
            let maker = Maker { blender: &blender, grid: &grid, time_limit, monitor };
            chart::packings(&scene, packing, &maker, args.quick)?
        }
    };
    trade.settings.extend(beside.into_iter().flatten());
    trade.write(args.tolerance, &args.out)?;
    context.print(&chart::in_words(&trade, args.tolerance))?;
    let out = args.out.display();
    context.print(&format!("chart in {out} (chart.csv, chart.svg, chart.png)\n"))?;
    Ok(None)
}
