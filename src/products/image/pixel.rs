//! One pixel: its paths, and the numbers that they give.

use super::bands::Bands;
use super::camera::Camera;
use super::evaluate::Evaluator;
use super::noise::Detectors;
use crate::histogram::tally::Tally;
use crate::histogram::{Histogram, Mean};
use crate::radiometry::Lit;
use crate::support::random::{GROUPS, Points, Purpose, STRETCH, Sampler, group_of};
use crate::support::statistics::T_95;
use crate::tracer::Tracer;
use crate::tracer::rules::TracingRules;

/// Cells along each side of a pixel.
const CELLS: u16 = 4;
/// The number of paths is a multiple of this: one in each cell from either net.
const LOT: u64 = GROUPS as u64;
/// Paths of the pilot, and the least of a pixel.
const PILOT: u64 = LOT;
/// Wavelengths at which the pilot is evaluated.
const CHECKED: usize = 32;

/// The numbers of a pixel, in single precision as they are written.
pub(super) struct Pixel {
    /// By band, in the order of [`CUBES`](super::netcdf::CUBES).
    pub cubes: [Vec<f32>; 3],
    /// In the order of [`MAPS`](super::netcdf::MAPS).
    pub maps: [f32; 4],
    pub paths: u64,
}

/// Traces and evaluates pixels.
pub(super) struct Pixels<'a> {
    pub tracer: &'a Tracer,
    pub rules: &'a TracingRules,
    pub camera: &'a Camera,
    pub seed: u64,
    /// Standard error in emissivity that every band of a pixel must reach.
    pub noise: f64,
    /// Most paths of a pixel.
    pub max_paths: u64,
    /// Evaluates the pilots.
    pub pilot: Evaluator<'a>,
    /// Evaluates the pixels in this number of bands.
    pub evaluator: Evaluator<'a>,
    pub bands: usize,
    pub detectors: Option<Detectors>,
}

/// The paths of a pixel.
struct Traced {
    histogram: Histogram,
    /// First hits on each material.
    first_hits: Vec<u64>,
    /// Hits of all paths, also of those that were rouletted.
    hits: u64,
    paths: u64,
}

impl Pixels<'_> {
    /// The numbers of a pixel; NaN if it sees nothing.
    pub(super) fn pixel(&self, pixel: [usize; 2]) -> Pixel {
        let Traced { histogram, first_hits, hits, paths } = self.trace(pixel);
        let met = histogram.paths();
        if met == 0.0 {
            let nothing = [0; 3].map(|_| vec![f32::NAN; self.bands]);
            let maps = [f32::NAN, f32::NAN, paths as f32, f32::NAN];
            return Pixel { cubes: nothing, maps, paths };
        }
        let spectra = self.evaluator.spectra(&histogram);
        let means = |of: &[Mean]| of.iter().map(|mean| mean.mean as f32).collect::<Vec<_>>();
        let mut l = means(&spectra.l_sensor);
        let mut errors: Vec<f32> = spectra.l_sensor.iter().map(|mean| error(mean) as f32).collect();
        if let Some(detectors) = &self.detectors {
            detectors.add(self.number(pixel), &mut l, &mut errors);
        }
        // The first of equal numbers.
        let most = first_hits.iter().max().copied().unwrap_or_default();
        let material = first_hits.iter().position(|&hits| hits == most).unwrap_or_default();
        let widest = widest(&spectra.emissivity) as f32;
        let maps = [material as f32, (hits as f64 / met) as f32, paths as f32, widest];
        Pixel { cubes: [l, errors, means(&spectra.emissivity)], maps, paths }
    }

    /// Traces as many paths as the pilot asks for. The pilot's own paths are not used: a pilot with
    /// a small spread by chance would bias the result.
    fn trace(&self, pixel: [usize; 2]) -> Traced {
        let traced = self.paths(Purpose::ImagePilot, pixel, PILOT);
        let paths = if traced.histogram.paths() == 0.0 {
            PILOT
        } else {
            let error = widest(&self.pilot.spectra(&traced.histogram).emissivity);
            let wanted = PILOT as f64 * (error / self.noise).powi(2);
            ((wanted.min(1e12) as u64).div_ceil(LOT) * LOT).max(PILOT)
        };
        self.paths(Purpose::Image, pixel, paths.min(self.max_paths))
    }

    fn paths(&self, purpose: Purpose, pixel: [usize; 2], paths: u64) -> Traced {
        let first = self.number(pixel) * STRETCH;
        let mut tally = Tally::new(self.tracer.bed().materials, self.rules.kept);
        let points = Points::new(self.seed, purpose, Sampler::Even);
        for (net, mut point) in points.of(first, first + paths) {
            let place = point.pair();
            tally.begin(group_of(net, place, CELLS), None);
            let ray = self.camera.ray(pixel, place);
            self.tracer.path_of_camera(self.rules, ray, &mut point, &mut tally);
        }
        let histogram = Histogram::of(&tally);
        Traced { histogram, first_hits: tally.first_hits, hits: tally.hits, paths }
    }

    fn number(&self, [sample, line]: [usize; 2]) -> u64 {
        (line * self.camera.pixels[0] + sample) as u64
    }
}

/// The error of the widest band.
fn widest(bands: &[Mean]) -> f64 {
    bands.iter().map(error).fold(0.0, f64::max)
}

/// The standard error, with the bound that trapped paths leave open.
fn error(mean: &Mean) -> f64 {
    mean.half_width() / T_95
}

/// A few wavelengths for the pilots, from the least reflectance to the greatest.
pub(super) fn checked(lit: &[Lit]) -> (Bands, Vec<Lit>) {
    let mean = |lit: &Lit| lit.reflectance.iter().sum::<f64>();
    let mut order: Vec<&Lit> = lit.iter().collect();
    order.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
    let number = CHECKED.min(order.len());
    let chosen: Vec<Lit> =
        (0..number).map(|i| order[i * (order.len() - 1) / (number - 1).max(1)].clone()).collect();
    let centres_um: Vec<f64> = chosen.iter().map(|lit| lit.wavelength_um).collect();
    let weights = (0..number).map(|i| vec![(i, 1.0)]).collect();
    let widths_um = vec![0.0; number];
    (Bands { nodes_um: centres_um.clone(), centres_um, widths_um, weights }, chosen)
}
