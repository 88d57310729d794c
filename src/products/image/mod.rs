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
use crate::support::resources::{need_disk, need_memory};
use crate::support::statistics::T_95;
use crate::table::{NodesError, Prepared, Stop, Table, Target};
use crate::tracer::rules::TracingRules;
use crate::tracer::{Tracer, trace};
use bands::Bands;
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
    let prepared = prepared.decided(&tracer.bed().mean_chords_um(), target.least_weight)?;
    if prepared.nodes.is_some() {
        return Err(NodesError::Image.into());
    }
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
        detectors: noise.map(|noise| Detectors::new(noise, scene.temperature_k.kelvin(), &bands)),
    };
    let [columns, lines] = camera.pixels;
    let size = Size { pixels: lines * columns, line: columns, bands: bands.centres_um.len() };
    size.check(asked, out, monitor)?;
    let is_bad = bands.where_not(|um| table.materials.iter().all(|m| m.is_valid(um)));
    let names: Vec<String> = scene.materials.iter().map(|m| m.name.clone()).collect();
    let about = About {
        title: &scene.name,
        scene_sha256: &table.scene_sha256,
        temperature_k: scene.temperature_k.kelvin(),
        view_deg: [scene.view.zenith_deg, scene.view.azimuth_deg],
        seed: scene.seed,
        materials: &names,
        pixel: camera.pixel_size(),
        is_parallel: camera.is_parallel(),
        size: [lines, columns],
        wavelengths_um: &bands.centres_um,
        widths_um: &bands.widths_um,
        is_bad: &is_bad,
    };
    let set = netcdf::data_set(&about);
    let mut files = Files::new(out, &set, &about)?;
    let mut shown = Shown::new(asked, &bands, scene.temperature_k.kelvin());
    let mut made = Made::new(camera.pixels, bands.centres_um.len());
    made.warnings = warnings(&table, &bands, &is_bad);
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

/// The size of an image.
struct Size {
    pixels: usize,
    /// Pixels of a line.
    line: usize,
    bands: usize,
}

impl Size {
    /// An error before the work if the disk or the memory does not hold the image.
    fn check(&self, asked: &Asked, out: &Path, monitor: &dyn Monitor) -> Result<(), Error> {
        let Self { pixels, line, bands } = *self;
        let numbers = |of: usize, by: usize| (of as u64).saturating_mul(by as u64);
        let task = format!("an image of {} x {line} pixels in {bands} bands", pixels / line);
        // Cubes and maps in single precision, as ENVI and as NetCDF.
        let in_pixel = 2 * 4 * (bands * netcdf::CUBES.len() + netcdf::MAPS.len());
        if let Some(text) = need_disk(&task, numbers(pixels, in_pixel), out)? {
            monitor.say(&text);
        }
        // What the pictures show of each pixel, and some lines of all bands twice.
        let shown = numbers(pixels, 4 * (10 + asked.show_um.len()));
        let in_lines = numbers(LINES * line, 2 * 4 * bands * netcdf::CUBES.len());
        Ok(need_memory(&task, shown.saturating_add(in_lines))?)
    }
}

/// The warnings about the bed, the spectra and the bands.
fn warnings(table: &Table, bands: &Bands, is_bad: &[bool]) -> Vec<String> {
    let mut found: Vec<String> = table.warnings.iter().map(ToString::to_string).collect();
    for material in &table.materials {
        let of_spectrum = material.spectrum.warnings().into_iter();
        found.extend(of_spectrum.map(|why| format!("{}: {why}", material.name)));
    }
    let bad = bands.centres_um.iter().zip(is_bad).filter(|(_, is_bad)| **is_bad);
    let bad: Vec<String> = bad.map(|(um, _)| um.to_string()).collect();
    if !bad.is_empty() {
        let shown = if bad.len() > 6 {
            format!("{} bands from {} to {} um", bad.len(), bad[0], bad[bad.len() - 1])
        } else {
            format!("{} um", bad.join(", "))
        };
        found.push(format!(
            "fresnel facets do not hold at {shown}: grains let over 1 % of the light through, or \
             measure below ten wavelengths. The cubes mark these bands as bad"
        ));
    }
    found
}

/// Checks before the work that the image can be written.
///
/// # Errors
/// The folder cannot be made, or a folder has the name of a file.
pub fn may_write(out: &Path) -> Result<(), output::OutputError> {
    output::folder(out)?;
    output::may_write(&output::within(out, "image.nc")?)
}
