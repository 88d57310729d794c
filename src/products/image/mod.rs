//! Images of a bed: a bounce histogram for every pixel, and from it a spectrum.
//!
//! A pixel's histogram is evaluated for all bands and then dropped, and lines are written when they
//! are complete. So neither time nor memory for tracing grow with the number of bands.

mod bands;
mod camera;
mod error;
mod evaluate;
mod made;
mod netcdf;
mod noise;
mod pixel;
mod quicklook;
mod shown;
mod written;

use std::path::Path;

use rayon::prelude::*;

use crate::scene::{Grid, Scene};
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;
use crate::support::random::STRETCH;
use crate::support::statistics::T_95;
use crate::table::{Prepared, Stop, Target};
use crate::tracer::rules::TracingRules;
use crate::tracer::{Tracer, trace};
use camera::Camera;
use evaluate::Evaluator;
use netcdf::About;
use noise::Detectors;
use pixel::{Pixel, Pixels};
use shown::Shown;
use written::Files;

pub use error::ImageError;
pub use made::Made;

/// Lines that are traced in parallel.
const LINES: usize = 8;

/// Most paths of a pixel.
pub const MOST_PATHS: u64 = STRETCH;

/// What is asked of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Asked {
    /// Standard error in emissivity of the widest band of each pixel.
    pub noise: f64,
    /// Most paths of a pixel, at most [`MOST_PATHS`].
    pub max_paths: u64,
    /// Wavelengths of red, green and blue in the false-colour picture, um; the nearest bands are
    /// shown.
    pub false_colour_um: Option<[f64; 3]>,
    /// Wavelengths shown as brightness temperature, um; the nearest bands are shown.
    pub show_um: Vec<f64>,
}

/// Traces the image of a placed scene into a folder: radiance, its standard errors, emissivity and
/// maps as ENVI images and as NetCDF, and pictures.
///
/// # Errors
/// A spectrum, sky or atmosphere does not hold the bands; no pixel sees anything; the folder cannot
/// be written.
pub fn make(
    tracer: &Tracer,
    scene: &Scene,
    grid: &Grid,
    asked: &Asked,
    out: &Path,
    monitor: &dyn Monitor,
) -> Result<Made, Error> {
    let sensor = scene.sensor.as_ref();
    let bands = bands::bands(sensor, scene.folder(), grid)?;
    let camera = Camera::new(tracer.bed(), sensor)?;
    let prepared = Prepared::new(scene.clone(), &bands.nodes_um)?;
    let target = Target::of(T_95 * asked.noise);
    let rules =
        TracingRules::new(&prepared).ending_below(target.least_weight, &prepared.reflectances);
    let table = trace::untraced(tracer, &prepared, Stop::new(&target, grid.clone()))?;
    let lit = table.lit(&bands.nodes_um)?;
    let (pilot_bands, pilot_lit) = pixel::checked(&lit);
    let noise = sensor.and_then(|sensor| sensor.noise);
    let pixels = Pixels {
        tracer,
        rules: &rules,
        camera: &camera,
        seed: scene.seed,
        noise: asked.noise,
        max_paths: asked.max_paths,
        pilot: Evaluator::new(rules.kept, &pilot_lit, &pilot_bands),
        evaluator: Evaluator::new(rules.kept, &lit, &bands),
        bands: bands.centres_um.len(),
        detectors: noise.map(|noise| Detectors::new(noise, scene.temperature_k, &bands)),
    };
    let [columns, lines] = camera.pixels;
    let names: Vec<String> = scene.materials.iter().map(|m| m.name.clone()).collect();
    let about = About {
        title: &scene.name,
        scene_sha256: &table.scene_sha256,
        temperature_k: scene.temperature_k,
        view_deg: [scene.view.zenith_deg, scene.view.azimuth_deg],
        seed: scene.seed,
        materials: &names,
        pixel_um: camera.pixel_um(),
        size: [lines, columns],
        wavelengths_um: &bands.centres_um,
    };
    let set = netcdf::data_set(&about);
    let mut files = Files::new(out, &set, &about)?;
    let mut shown = Shown::new(asked, &bands, scene.temperature_k);
    let mut made = Made::new(camera.pixels, bands.centres_um.len());
    for first in (0..lines).step_by(LINES) {
        let end = (first + LINES).min(lines);
        let traced: Vec<Pixel> = (first * columns..end * columns)
            .into_par_iter()
            .map(|number| {
                monitor.check()?;
                Ok(pixels.pixel([number % columns, number / columns]))
            })
            .collect::<Result<_, Error>>()?;
        for (line, pixels) in (first..).zip(traced.chunks(columns)) {
            files.write(line, pixels)?;
        }
        for pixel in &traced {
            made.count(pixel, asked);
            shown.keep(pixel);
        }
        monitor.at((end * columns) as u64, (lines * columns) as u64, "pixels");
    }
    let made = made.means().ok_or(ImageError::Empty)?;
    files.done()?;
    shown.write(&scene.name, columns, &names, out)?;
    Ok(made)
}

/// Checks before the work that the image can be written.
///
/// # Errors
/// The folder cannot be made, or a folder has the name of a file.
pub fn may_write(out: &Path) -> Result<(), output::OutputError> {
    output::folder(out)?;
    output::may_write(&out.join("image.nc"))
}
