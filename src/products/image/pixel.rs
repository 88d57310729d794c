//! The paths of one pixel.

use super::bands::Bands;
use super::camera::Camera;
use super::evaluate::Evaluator;
use crate::histogram::tally::Tally;
use crate::histogram::{Histogram, Mean};
use crate::radiometry::Lit;
use crate::support::random::{GROUPS, Points, Purpose, STRETCH, Sampler, group_of};
use crate::support::statistics::T_95;
use crate::tracer::Tracer;
use crate::tracer::rules::TracingRules;

/// Cells along each side of a pixel.
const CELLS: u16 = 4;
/// Paths are traced in lots of this size: one in each cell, from either net.
const LOT: u64 = GROUPS as u64;
/// Paths of the pilot, and the least of a pixel.
const PILOT: u64 = LOT;
/// Wavelengths at which the pilot is evaluated.
const CHECKED: usize = 32;

/// Traces pixels.
pub(super) struct Pixels<'a> {
    pub tracer: &'a Tracer,
    pub rules: &'a TracingRules,
    pub camera: &'a Camera,
    pub seed: u64,
    /// Standard error in emissivity that every band of a pixel is to reach.
    pub noise: f64,
    /// Most paths of a pixel.
    pub max_paths: u64,
}

/// What a pixel sees.
pub(super) struct Traced {
    pub histogram: Histogram,
    /// First hits on each material.
    pub first_hits: Vec<u64>,
    /// Hits of all paths, of one that was ended those that it had.
    pub hits: u64,
    pub paths: u64,
}

impl Pixels<'_> {
    /// Traces a pixel with as many paths as its pilot says: paths of their own, or those that happened to see little
    /// spread would be believed.
    pub(super) fn trace(&self, pilot: &Evaluator, pixel: [usize; 2]) -> Traced {
        let traced = self.paths(Purpose::ImagePilot, pixel, PILOT);
        let paths = if traced.histogram.paths() == 0.0 {
            PILOT
        } else {
            let error = widest(&pilot.spectra(&traced.histogram).emissivity);
            let wanted = PILOT as f64 * (error / self.noise).powi(2);
            ((wanted.min(1e12) as u64).div_ceil(LOT) * LOT).max(PILOT)
        };
        self.paths(Purpose::Image, pixel, paths.min(self.max_paths))
    }

    fn paths(&self, purpose: Purpose, [sample, line]: [usize; 2], paths: u64) -> Traced {
        let number = (line * self.camera.pixels[0] + sample) as u64;
        let (first, end) = (number * STRETCH, number * STRETCH + paths);
        let mut tally = Tally::new(self.tracer.bed().materials, self.rules.kept);
        for (net, mut point) in Points::new(self.seed, purpose, Sampler::Even).of(first, end) {
            let place = point.pair();
            tally.begin(group_of(net, place, CELLS), None);
            let ray = self.camera.ray([sample, line], place);
            self.tracer.path_of_camera(self.rules, ray, &mut point, &mut tally);
        }
        let histogram = Histogram::of(&tally);
        Traced { histogram, first_hits: tally.first_hits, hits: tally.hits, paths }
    }
}

/// The error of the band where it is widest, with what trapped paths leave open.
pub(super) fn widest(bands: &[Mean]) -> f64 {
    bands.iter().map(error).fold(0.0, f64::max)
}

/// The standard error with what trapped paths leave open.
pub(super) fn error(mean: &Mean) -> f64 {
    mean.half_width() / T_95
}

/// The wavelengths, a few of all, that a pilot is evaluated at: from the darkest to the brightest.
pub(super) fn checked(lit: &[Lit]) -> (Bands, Vec<Lit>) {
    let mean = |lit: &Lit| lit.reflectance.iter().sum::<f64>();
    let mut order: Vec<&Lit> = lit.iter().collect();
    order.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
    let number = CHECKED.min(order.len());
    let chosen: Vec<Lit> =
        (0..number).map(|i| order[i * (order.len() - 1) / (number - 1).max(1)].clone()).collect();
    let centres_um: Vec<f64> = chosen.iter().map(|lit| lit.wavelength_um).collect();
    let weights = (0..number).map(|i| vec![(i, 1.0)]).collect();
    (Bands { nodes_um: centres_um.clone(), centres_um, weights }, chosen)
}
