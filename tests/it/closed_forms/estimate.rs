//! Means to a standard error that is asked for, seen from one direction or from all.

use std::sync::Arc;

use glam::DVec3;
use soilsig::geometry::Bed;
use soilsig::histogram::kept::Kept;
use soilsig::histogram::tally::Tally;
use soilsig::histogram::{Histogram, Mean, Sources};
use soilsig::support::random::Purpose;
use soilsig::tracer::Tracer;
use soilsig::tracer::bvh::Accelerator;
use soilsig::tracer::rules::{Facet, TracingRules};

/// The standard error of every check.
const STANDARD_ERROR: f64 = 1e-4;

/// Weight below which paths end: it may hide a hundredth of what is allowed.
const LEAST_WEIGHT: f64 = 1e-6;

/// Paths after which the standard error is looked at first; then as many are traced as it takes by
/// that, up to four times as many.
const LEAST: u64 = 1 << 17;

/// Directions over a hemisphere. What is seen from them changes without a jump, so that the
/// midpoint rule errs by the order of their number to the power of -2.
const DIRECTIONS: u64 = 256;

/// Where the sensor stands.
#[derive(Clone, Copy)]
pub enum View {
    /// At this zenith angle in the east.
    From { zenith_deg: f64 },
    /// All around a body of revolution, by the cosine: sin^2 of the zenith angle is uniform, and
    /// one azimuth does for all.
    HemisphereOfRound,
    /// All around a profile without end along y, by the cosine. Where a ray meets it depends on the
    /// ray's projection on the x-z plane alone, and the sine of that angle is uniform.
    HemisphereOfProfile,
}

impl View {
    fn to_sensor(self) -> Vec<DVec3> {
        let midpoints = || (0..DIRECTIONS).map(|i| (i as f64 + 0.5) / DIRECTIONS as f64);
        let east = |sin: f64| DVec3::new(sin, 0.0, (1.0 - sin * sin).sqrt());
        match self {
            Self::From { zenith_deg } => vec![east(zenith_deg.to_radians().sin())],
            Self::HemisphereOfRound => midpoints().map(|u| east(u.sqrt())).collect(),
            // Profiles that are their own mirror images: one side does.
            Self::HemisphereOfProfile => midpoints().map(east).collect(),
        }
    }
}

/// One less the mean weight for each set of reflectances, all from the same paths: the emissivity,
/// and the radiosity where all emit as a black body of 1 would.
pub fn emissivities(bed: &Bed, view: View, reflectances: &[Vec<f64>]) -> Vec<Mean> {
    traced(bed, view, Kept::PLAIN, reflectances, &|histogram| {
        let of = |rho: &Vec<f64>| {
            let weight = histogram.weight(rho);
            Mean { mean: 1.0 - weight.mean, ..weight }
        };
        reflectances.iter().map(of).collect()
    })
}

/// The mean radiance that leaves what is looked at, where two materials have these reflectances and
/// black-body radiances; of each set from the same paths.
pub fn radiosities<const N: usize>(bed: &Bed, view: View, sets: [[[f64; 2]; 2]; N]) -> [Mean; N] {
    let kept = Kept { order: true, ..Kept::PLAIN };
    let reflectances = sets.map(|[reflectance, _]| reflectance.to_vec());
    let means = traced(bed, view, kept, &reflectances, &|histogram| {
        let of = |[reflectance, l_blackbody]: &[[f64; 2]; 2]| {
            histogram.seen(Sources { reflectance, l_blackbody, l_sky: &[0.0] }).1.l_target
        };
        sets.iter().map(of).collect()
    });
    means.try_into().expect("one for each set")
}

fn traced(
    bed: &Bed,
    view: View,
    kept: Kept,
    reflectances: &[Vec<f64>],
    means: &dyn Fn(&Histogram) -> Vec<Mean>,
) -> Vec<Mean> {
    let rules = TracingRules::of_facets(kept, vec![Facet::LAMBERTIAN; bed.materials]);
    let rules = rules.ending_below(LEAST_WEIGHT, reflectances);
    let accelerator = Arc::new(Accelerator::new(bed));
    let from = |to_sensor| Tracer::with(Bed { to_sensor, ..bed.clone() }, Arc::clone(&accelerator));
    let tracers: Vec<Tracer> = view.to_sensor().into_iter().map(from).collect();
    let mut tally = Tally::new(bed.materials, kept);
    let (mut from, mut to) = (0, (LEAST / tracers.len() as u64).max(32));
    loop {
        // The same number of paths in each direction.
        for (seed, tracer) in tracers.iter().enumerate() {
            let part = tracer.trace(&rules, seed as u64, Purpose::Result, from..to, &|_| Ok(()));
            tally.add(&part.expect("not interrupted"));
        }
        let mut histogram = Histogram::of(&tally);
        past_collar(&mut histogram, bed.materials);
        let means = means(&histogram);
        let widest = means.iter().map(|mean| mean.standard_error).fold(0.0, f64::max);
        if widest <= STANDARD_ERROR {
            return means;
        }
        // The error is known to a fifth, and falls with the root of their number or faster.
        let times = (1.1 * (widest / STANDARD_ERROR).powi(2)).clamp(1.1, 4.0);
        (from, to) = (to, (to as f64 * times).ceil() as u64);
    }
}

/// Leaves out paths that met the last of the materials, the collar about an opening: they looked
/// past it.
fn past_collar(histogram: &mut Histogram, materials: usize) {
    if histogram.kept.order || materials == 1 {
        return;
    }
    for states in [&mut histogram.escaped, &mut histogram.given_up] {
        states.retain(|(state, _)| state[materials - 1] == 0);
    }
}

/// Within three standard errors, and what trapped paths leave open.
pub fn assert_is(mean: Mean, exact: f64, what: &str) {
    let Mean { mean, standard_error, trapped } = mean;
    assert!(standard_error <= STANDARD_ERROR && trapped <= LEAST_WEIGHT, "{what}");
    let off = (mean - exact) / standard_error;
    println!(
        "{what}: {mean:.6} +- {standard_error:.6}, exact {exact}, {off:.1} standard errors off"
    );
    assert!(
        (mean - exact).abs() < 3.0 * standard_error + trapped,
        "{what}: {mean} +- {standard_error}, exact {exact}"
    );
}
