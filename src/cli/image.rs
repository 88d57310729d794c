//! `soilsig image`: a placed scene as a radiance image.

use std::path::PathBuf;

use super::arguments::{Bands, Changes, tolerance};
use super::{Context, Outcome};
use crate::products::image::{self, Asked, MOST_PATHS, Made};
use crate::report::terminal;
use crate::support::error::Status;
use crate::support::lock::Lock;
use crate::support::monitor::Step;
use crate::tracer::trace;

/// Traces a placed scene into a radiance image with a spectrum in every pixel
///
/// Writes ENVI images of radiance, its standard errors, emissivity, and maps of materials, hits and
/// paths; all of them as NetCDF; and quick-looks as PNG. The scene's `sensor` describes the sensor;
/// without it, parallel rays see the domain.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file with placed geometry
    scene: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Folder to write into
    #[arg(long, short, value_name = "FOLDER")]
    out: PathBuf,
    /// Standard error in emissivity that every band of each pixel is to reach
    #[arg(long, value_name = "X", default_value_t = 0.01, value_parser = tolerance)]
    noise: f64,
    /// Most paths of a pixel
    #[arg(long, value_name = "N", default_value_t = 1 << 14,
          value_parser = clap::value_parser!(u64).range(32..=MOST_PATHS))]
    max_paths: u64,
    /// Random seed of the rays; it replaces the scene's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Pixels of the focal plane; they replace the scene's
    #[arg(long, value_name = "COLUMNSxLINES", value_parser = pixels)]
    pixels: Option<[u32; 2]>,
    #[command(flatten)]
    bands: Bands,
    /// Wavelengths of the quick-look's red, green and blue, um [default: spread over all bands]
    #[arg(long, value_name = "R,G,B", value_parser = three)]
    false_colour: Option<[f64; 3]>,
    /// Wavelengths to draw as brightness temperature, um
    #[arg(long, value_name = "UM,...", value_delimiter = ',', default_value = "9")]
    show: Vec<f64>,
    /// Print the numbers of the result as JSON
    #[arg(long)]
    json: bool,
}

fn pixels(text: &str) -> Result<[u32; 2], String> {
    let (columns, lines) = text.split_once('x').ok_or("write COLUMNSxLINES, as in 256x256")?;
    let number = |text: &str| match text.parse::<u32>() {
        Ok(side @ 1..=16_384) => Ok(side),
        _ => Err(format!("{text:?} is not a number of pixels, 1 to 16384")),
    };
    Ok([number(columns)?, number(lines)?])
}

fn three(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|um| um.trim().parse()).collect();
    let numbers = numbers.map_err(|error| error.to_string())?;
    numbers.try_into().map_err(|_| "write three wavelengths, as in 12.9,10.7,8.6".into())
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let grid = args.bands.grid()?;
    let mut scene = args.changes.read(&args.scene)?;
    scene.seed = args.seed.unwrap_or(scene.seed);
    if let Some(pixels) = args.pixels {
        scene.sensor.get_or_insert_default().pixels = pixels;
    }
    // Before the work, not after it.
    let _lock = Lock::of(&args.out)?;
    image::may_write(&args.out)?;
    let asked = Asked {
        noise: args.noise,
        max_paths: args.max_paths / 32 * 32,
        false_colour_um: args.false_colour,
        show_um: args.show.clone(),
    };
    let monitor = context.monitor;
    let step = Step::new(monitor, "load");
    let tracer = trace::tracer(&scene)?;
    step.done(&format!("{} triangles", tracer.bed().triangles()));
    let step = Step::new(monitor, "image");
    let made = image::make(&tracer, &scene, &grid, &asked, &args.out, monitor)?;
    step.done(&format!("{} paths", made.paths));
    if args.json {
        context.print_json(&made)?;
    } else {
        let lines = lines(&made, &asked, context.verbose);
        let indent = format!("\n{:1$}", "", scene.name.len().min(terminal::WIDEST_NAME) + 3);
        context.print(&format!("{}   {}\n", scene.name, lines.join(&indent)))?;
        let files = "radiance.img, image.nc, false_colour.png";
        context.print(&format!("result in {} ({files})\n", args.out.display()))?;
    }
    Ok((made.capped > 0.0).then_some(Status::ToleranceNotReached))
}

/// The noise that was reached, and what limits it.
fn lines(made: &Made, asked: &Asked, with_details: bool) -> Vec<String> {
    let [columns, lines] = made.pixels;
    let pixels = (columns * lines) as f64;
    let mut text = vec![format!(
        "{columns} x {lines} pixels, standard error in emissivity {:.4} (root mean square)",
        made.noise
    )];
    text.push(format!(
        "{:.0} % of the pixels have at most the {} asked; a smaller --noise narrows all",
        100.0 * made.reached,
        asked.noise
    ));
    if made.capped > 0.0 {
        text.push(format!(
            "warning: {:.0} pixels have all the {} paths allowed: raise --max-paths",
            made.capped * pixels * (1.0 - made.empty),
            asked.max_paths
        ));
    }
    if made.empty > 0.0 {
        text.push(format!("warning: {:.1} % of the pixels see nothing", 100.0 * made.empty));
    }
    text.extend(made.warnings.iter().map(|warning| format!("warning: {warning}")));
    if with_details {
        let paths = made.paths as f64 / pixels;
        text.push(format!("{} bands; {paths:.0} paths per pixel", made.bands));
    }
    text
}
