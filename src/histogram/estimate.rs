//! Several packings of one recipe: their mean and its standard error.
//!
//! A drop is a random draw: the next one of the same recipe has other grains on top. The mean over
//! packings is the recipe's own signature. The spread between them gives its error; it contains the
//! noise of the rays, since each packing is traced with rays of its own.

use crate::histogram::Mean;
use crate::support::statistics::quantile_95;

/// The most packings of a result.
pub const MOST: usize = 1000;

/// A quantity in one band, estimated from packings.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// Mean over the packings, which all have the same weight.
    pub mean: f64,
    /// Standard error of the mean, from the spread between packings; of a single packing from its
    /// rays.
    pub standard_error: f64,
    /// Half-width of the 95 % interval, by Student's t, with what paths given up leave open.
    pub half_width: f64,
    /// The part of the standard error that the rays make.
    pub rays_standard_error: f64,
    /// Standard deviation between packings; `None` of a single one.
    pub spread: Option<f64>,
    /// The part of the half-width that paths given up leave open.
    pub trapped: f64,
}

impl Estimate {
    /// Half-width of the 95 % interval without what paths given up leave open.
    pub fn interval(&self) -> f64 {
        self.half_width - self.trapped
    }

    /// The estimate from the mean of each packing.
    pub fn of(packings: &[Mean]) -> Self {
        let n = packings.len() as f64;
        let mean = packings.iter().map(|p| p.mean).sum::<f64>() / n;
        let trapped = packings.iter().map(|p| p.trapped).sum::<f64>() / n;
        let rays = packings.iter().map(|p| p.standard_error.powi(2)).sum::<f64>().sqrt() / n;
        let (spread, standard_error) = if packings.len() > 1 {
            let squares: f64 = packings.iter().map(|p| (p.mean - mean).powi(2)).sum();
            let spread = (squares / (n - 1.0)).sqrt();
            // Packings that happen to agree are no more precise than their rays.
            (Some(spread), (spread / n.sqrt()).max(rays))
        } else {
            (None, rays)
        };
        let half_width = quantile_95(packings.len()) * standard_error + trapped;
        Self { mean, standard_error, half_width, rays_standard_error: rays, spread, trapped }
    }
}
