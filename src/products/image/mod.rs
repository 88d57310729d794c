//! Images of a bed: a bounce histogram for every pixel, and from it a spectrum.
//!
//! A pixel's histogram is evaluated for all bands as soon as it is traced and then forgotten, and finished lines go to
//! files: neither tracing nor memory grow with the bands.

mod bands;
mod camera;
mod error;
mod evaluate;
mod files;
mod netcdf;
mod pixel;
mod quicklook;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use rayon::prelude::*;

use crate::products::cube::ImageHeader;
use crate::radiometry::{brightness_temperature_k, planck, planck_derivative};
use crate::scene::{Grid, Noise, Scene};
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;
use crate::support::random::{Purpose, STRETCH, Source};
use crate::support::statistics::T_95;
use crate::table::Prepared;
use crate::table::{Stop, Target};
use crate::tracer::rules::TracingRules;
use crate::tracer::{Tracer, trace};
use bands::Bands;
use camera::Camera;
use evaluate::Evaluator;
use files::{Block, EnviFile};
use netcdf::{About, CUBES, MAPS, NetCdf};
use pixel::Pixels;
use quicklook::Look;

pub use error::ImageError;

/// Lines that are traced and written at a go.
const LINES: usize = 8;

/// Most paths of a pixel.
pub const MOST_PATHS: u64 = STRETCH;

/// What is asked of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Asked {
    /// Standard error in emissivity that the widest band of each pixel is to have.
    pub noise: f64,
    /// Most paths of a pixel, at most [`MOST_PATHS`].
    pub max_paths: u64,
    /// Wavelengths of the quick-look's red, green and blue, um; the nearest bands are shown.
    pub false_colour_um: Option<[f64; 3]>,
    /// Wavelengths that are shown as brightness temperature, um; the nearest bands are shown.
    pub show_um: Vec<f64>,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Made {
    /// Columns and lines.
    pub pixels: [usize; 2],
    /// Bands.
    pub bands: usize,
    /// Paths of all pixels, their pilots not counted.
    pub paths: u64,
    /// Share of pixels that see nothing.
    pub empty: f64,
    /// Root mean square, over the pixels, of the standard error in emissivity in each pixel's widest band.
    pub noise: f64,
    /// Share of pixels whose standard error is at most what was asked for.
    pub reached: f64,
    /// Share of pixels that would have needed more paths than they may have.
    pub capped: f64,
}

/// What becomes known of a pixel, in single precision as it is written.
struct Pixel {
    /// As [`CUBES`] has them.
    cubes: [Vec<f32>; 3],
    /// As [`MAPS`] has them.
    maps: [f32; 4],
    paths: u64,
}

/// The sensor's noise in each band.
struct Detectors {
    /// Noise-equivalent radiance, W m-2 sr-1 um-1.
    nedl: Vec<f64>,
    source: Source,
}

impl Detectors {
    fn new(noise: Noise, temperature_k: f64, bands: &Bands) -> Self {
        let slope: Vec<f64> =
            bands.nodes_um.iter().map(|&um| planck_derivative(um, temperature_k)).collect();
        let of = |band| match (noise.nedl_w_m2_sr_um, noise.nedt_k) {
            (Some(nedl), _) => nedl,
            (None, nedt_k) => nedt_k.unwrap_or_default() * bands.mean(band, &slope),
        };
        let nedl = (0..bands.centres_um.len()).map(of).collect();
        Self { nedl, source: Source::new(noise.seed, Purpose::SensorNoise) }
    }

    /// Adds the noise of a pixel, and its part of the standard error.
    fn add(&self, pixel: u64, l: &mut [f32], errors: &mut [f32]) {
        let mut random = self.source.stream(pixel);
        for (band, nedl) in self.nedl.iter().enumerate() {
            // Box and Muller's method.
            let [u, v] = random.pair();
            let normal = (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos();
            l[band] = (f64::from(l[band]) + nedl * normal) as f32;
            errors[band] = f64::from(errors[band]).hypot(*nedl) as f32;
        }
    }
}

/// Traces the image of a placed scene and writes it into a folder: ENVI images of radiance, its standard errors, emissivity
/// and maps, all of them as NetCDF, and pictures.
///
/// # Errors
/// A spectrum, sky or atmosphere that does not hold the bands; a folder that cannot be written.
pub fn make(
    tracer: &Tracer,
    scene: &Scene,
    grid: &Grid,
    asked: &Asked,
    out: &Path,
    monitor: &dyn Monitor,
) -> Result<Made, Error> {
    let sensor = scene.sensor.as_ref();
    let bands = Bands::new(sensor, scene.folder(), grid)?;
    let camera = Camera::new(tracer.bed(), sensor)?;
    let prepared = Prepared::new(scene.clone(), &bands.nodes_um)?;
    let target = Target::of(T_95 * asked.noise);
    let rules =
        TracingRules::new(&prepared).ending_below(target.least_weight, &prepared.reflectances);
    let table = trace::untraced(tracer, &prepared, Stop::new(&target, grid.clone()))?;
    let lit = table.lit(&bands.nodes_um)?;
    let (pilot_bands, pilot_lit) = pixel::checked(&lit);
    let pilot = Evaluator::new(rules.kept, &pilot_lit, &pilot_bands);
    let evaluator = Evaluator::new(rules.kept, &lit, &bands);
    let detectors =
        sensor.and_then(|s| s.noise).map(|n| Detectors::new(n, scene.temperature_k, &bands));
    let [columns, lines] = camera.pixels;
    let pixels = Pixels {
        tracer,
        rules: &rules,
        camera: &camera,
        seed: scene.seed,
        noise: asked.noise,
        max_paths: asked.max_paths,
    };
    let one = |number: usize| -> Result<Pixel, Error> {
        monitor.check()?;
        let (sample, line) = (number % columns, number / columns);
        let traced = pixels.trace(&pilot, [sample, line]);
        Ok(seen(&traced, &evaluator, bands.centres_um.len(), |l, errors| {
            if let Some(detectors) = &detectors {
                detectors.add(number as u64, l, errors);
            }
        }))
    };

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
    let mut made = Made {
        pixels: camera.pixels,
        bands: bands.centres_um.len(),
        paths: 0,
        empty: 0.0,
        noise: 0.0,
        reached: 0.0,
        capped: 0.0,
    };
    for first_line in (0..lines).step_by(LINES) {
        let place = [first_line, LINES.min(lines - first_line), columns];
        let range = first_line * columns..(first_line + place[1]) * columns;
        let done: Vec<Pixel> = range.into_par_iter().map(one).collect::<Result<_, _>>()?;
        files.write(place, &done)?;
        for pixel in &done {
            made.count(pixel, asked);
            shown.keep(pixel);
        }
        let (done, all) = ((first_line + place[1]) * columns, lines * columns);
        monitor.at(done as u64, all as u64, "pixels");
    }
    let all = (lines * columns) as f64;
    let met = all - made.empty;
    if met == 0.0 {
        return Err(ImageError::Empty.into());
    }
    made.noise = (made.noise / met).sqrt();
    made.reached /= met;
    made.capped /= met;
    made.empty /= all;
    files.done()?;
    shown.write(&scene.name, columns, &names, out)?;
    Ok(made)
}

/// All files of numbers under way.
struct Files<'a> {
    cubes: Vec<EnviFile>,
    maps: EnviFile,
    netcdf: NetCdf<'a>,
}

impl<'a> Files<'a> {
    fn new(out: &Path, set: &'a netcdf3::DataSet, about: &About) -> Result<Self, Error> {
        let [lines, samples] = about.size;
        let envi = |name: &str, quantity: &str, wavelengths_um: &[f64], band_names: &[String]| {
            let header = ImageHeader { quantity, lines, samples, wavelengths_um, band_names };
            EnviFile::new(&out.join(format!("{name}.img")), &header)
        };
        let quantities = [
            "Radiance at the sensor (W m-2 sr-1 um-1)",
            "Standard error of the radiance (W m-2 sr-1 um-1)",
            "Emissivity",
        ];
        let cubes = CUBES.iter().zip(quantities);
        let cubes = cubes.map(|(name, quantity)| envi(name, quantity, about.wavelengths_um, &[]));
        let quantity = format!("maps; material 0 on: {}", about.materials.join(" "));
        Ok(Self {
            cubes: cubes.collect::<Result<_, _>>()?,
            maps: envi("maps", &quantity, &[], &MAPS.map(str::to_owned))?,
            netcdf: NetCdf::new(&out.join("image.nc"), set, about)?,
        })
    }

    /// Writes lines: the first, how many, and their columns.
    fn write(&mut self, place: [usize; 3], pixels: &[Pixel]) -> Result<(), Error> {
        let [first_line, lines, columns] = place;
        for (i, cube) in self.cubes.iter().enumerate() {
            let values = pixels.iter().map(|pixel| &pixel.cubes[i][..]);
            let block = Block::new(place, pixels[0].cubes[i].len(), values);
            cube.write(&block)?;
            for line in 0..lines {
                self.netcdf.write(CUBES[i], first_line + line, &block.line(line))?;
            }
        }
        let block = Block::new(place, MAPS.len(), pixels.iter().map(|pixel| &pixel.maps[..]));
        self.maps.write(&block)?;
        for line in 0..lines {
            for (name, values) in MAPS.iter().zip(block.line(line).chunks(columns)) {
                self.netcdf.write(name, first_line + line, values)?;
            }
        }
        Ok(())
    }

    /// Puts them in their places.
    fn done(self) -> Result<(), Error> {
        self.cubes.into_iter().try_for_each(EnviFile::done)?;
        self.maps.done()?;
        Ok(self.netcdf.done()?)
    }
}

/// The numbers of a traced pixel.
fn seen(
    traced: &pixel::Traced,
    evaluator: &Evaluator,
    bands: usize,
    noise: impl FnOnce(&mut [f32], &mut [f32]),
) -> Pixel {
    let paths = traced.paths;
    if traced.histogram.paths() == 0.0 {
        let nothing = [const { Vec::new() }; 3].map(|mut values: Vec<f32>| {
            values.resize(bands, f32::NAN);
            values
        });
        return Pixel { cubes: nothing, maps: [f32::NAN, f32::NAN, paths as f32, f32::NAN], paths };
    }
    let spectra = evaluator.spectra(&traced.histogram);
    let mut l: Vec<f32> = spectra.l_sensor.iter().map(|mean| mean.mean as f32).collect();
    let mut errors: Vec<f32> =
        spectra.l_sensor.iter().map(|mean| pixel::error(mean) as f32).collect();
    noise(&mut l, &mut errors);
    let emissivity = spectra.emissivity.iter().map(|mean| mean.mean as f32).collect();
    // Of equal numbers the first.
    let most = traced.first_hits.iter().max().copied().unwrap_or_default();
    let material = traced.first_hits.iter().position(|&hits| hits == most).unwrap_or_default();
    let widest = pixel::widest(&spectra.emissivity);
    let hits = traced.hits as f64 / traced.histogram.paths();
    let maps = [material as f32, hits as f32, paths as f32, widest as f32];
    Pixel { cubes: [l, errors, emissivity], maps, paths }
}

impl Made {
    /// Sums; means are made of them at the end.
    fn count(&mut self, pixel: &Pixel, asked: &Asked) {
        self.paths += pixel.paths;
        let error = f64::from(pixel.maps[3]);
        if error.is_nan() {
            self.empty += 1.0;
            return;
        }
        self.noise += error * error;
        self.reached += f64::from(u8::from(error <= asked.noise));
        self.capped += f64::from(u8::from(pixel.paths == asked.max_paths && error > asked.noise));
    }

    /// In words, for the terminal.
    pub fn words(&self, asked: &Asked) -> String {
        let [columns, lines] = self.pixels;
        let pixels = (columns * lines) as f64 * (1.0 - self.empty);
        let mut text = format!(
            "{columns} x {lines} pixels in {} bands; {:.0} paths a pixel; standard error in emissivity {:.4} (root mean \
             square; {} asked), no more than asked in {:.0} % of the pixels\n",
            self.bands,
            self.paths as f64 / (columns * lines) as f64,
            self.noise,
            asked.noise,
            100.0 * self.reached,
        );
        if self.capped > 0.0 {
            let _ = writeln!(
                text,
                "{:.0} pixels have all the {} paths that a pixel may have",
                self.capped * pixels,
                asked.max_paths
            );
        }
        if self.empty > 0.0 {
            let _ = writeln!(text, "{:.1} % of the pixels see nothing", 100.0 * self.empty);
        }
        text
    }
}

/// What the pictures show.
struct Shown<'a> {
    bands: &'a Bands,
    temperature_k: f64,
    colours: [usize; 3],
    bands_shown: Vec<usize>,
    /// Apparent emissivity (Eq. 3) in the three bands of the false colours.
    channels: [Vec<f32>; 3],
    brightness_k: Vec<Vec<f32>>,
    materials: Vec<f32>,
    hits: Vec<f32>,
}

impl<'a> Shown<'a> {
    fn new(asked: &Asked, bands: &'a Bands, temperature_k: f64) -> Self {
        let all = &bands.centres_um;
        let ends =
            all.iter().fold([f64::INFINITY, 0.0], |[a, b], &um| [a.min(um), f64::max(b, um)]);
        let at = |share: f64| ends[0] + share * (ends[1] - ends[0]);
        let colours_um = asked.false_colour_um.unwrap_or([at(5.0 / 6.0), at(0.5), at(1.0 / 6.0)]);
        let mut bands_shown: Vec<usize> =
            asked.show_um.iter().map(|&um| bands.nearest(um)).collect();
        bands_shown.dedup();
        Self {
            bands,
            temperature_k,
            colours: colours_um.map(|um| bands.nearest(um)),
            channels: [const { Vec::new() }; 3],
            brightness_k: vec![Vec::new(); bands_shown.len()],
            bands_shown,
            materials: Vec::new(),
            hits: Vec::new(),
        }
    }

    fn keep(&mut self, pixel: &Pixel) {
        let l = |band: usize| f64::from(pixel.cubes[0][band]);
        for (channel, &band) in self.channels.iter_mut().zip(&self.colours) {
            let l_blackbody = planck(self.bands.centres_um[band], self.temperature_k);
            channel.push((l(band) / l_blackbody) as f32);
        }
        for (values, &band) in self.brightness_k.iter_mut().zip(&self.bands_shown) {
            let kelvin = brightness_temperature_k(self.bands.centres_um[band], l(band));
            values.push(kelvin.map_or(f32::NAN, |kelvin| kelvin as f32));
        }
        self.materials.push(pixel.maps[0]);
        self.hits.push(pixel.maps[1]);
    }

    fn write(
        &self,
        title: &str,
        columns: usize,
        materials: &[String],
        out: &Path,
    ) -> Result<(), Error> {
        let look = Look { columns, title };
        let centre = |band: usize| self.bands.centres_um[band];
        let names = self.colours.map(|band| format!("{:.2} um", centre(band)));
        let what = "apparent emissivity (Eq. 3)";
        look.false_colour(&self.channels, &names, what, &out.join("false_colour.png"))?;
        let centres = self.bands_shown.iter().map(|&band| centre(band));
        // As many places as tell the bands apart.
        let named = |places: usize| -> BTreeSet<String> {
            centres.clone().map(|um| format!("{um:.places$}")).collect()
        };
        let places =
            (2..9).find(|&places| named(places).len() == self.bands_shown.len()).unwrap_or(9);
        for (values, &band) in self.brightness_k.iter().zip(&self.bands_shown) {
            let um = centre(band);
            let what = format!("brightness temperature at {um:.places$} um");
            let file = out.join(format!("brightness_{um:.places$}um.png"));
            look.scaled(values, &what, "K", 1, &file)?;
        }
        look.materials(&self.materials, materials, &out.join("materials.png"))?;
        look.scaled(&self.hits, "mean number of hits of a path", "", 2, &out.join("hits.png"))
    }
}

/// Finds out before the work whether the image can be written there.
pub fn may_write(out: &Path) -> Result<(), output::OutputError> {
    output::folder(out)?;
    output::may_write(&out.join("image.nc"))
}
