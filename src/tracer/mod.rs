//! Paths traced backward from the sensor, and counts of what they hit.
//!
//! Facets are opaque and scatter a path independently of wavelength: a Lambertian one by the
//! cosine, a specular one as a mirror. So one path serves every band.

mod alone;
mod bed_warnings;
pub mod bvh;
pub mod coverage;
pub(crate) mod field;
mod follow;
pub(crate) mod footprint;
pub mod light;
mod media;
pub mod rules;
mod scatter;
pub mod trace;
mod turn;
pub mod until;

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::Bed;
use crate::geometry::ingest::Sources;
use crate::histogram::tally::{CELLS, Tally};
use crate::scene::Sides;
use crate::support::error::Error;
use crate::support::monitor::Interrupted;
use crate::support::random::{CELLS_OF_VIEW, Point, Points, Purpose, group_of};
use crate::tracer::bvh::Accelerator;
use crate::tracer::field::Field;
use crate::tracer::follow::Event;
use crate::tracer::rules::TracingRules;

/// Paths that are sorted by where they begin and traced together.
pub(crate) const WAVE: u64 = 1 << 15;

/// Paths that one thread traces at a time.
const BLOCK: usize = 1024;

/// Distance by which a ray's origin is lifted off its facet, as a share of the greatest coordinate:
/// 256 times the rounding of a double. Hit points and their transforms from one mesh to another
/// take some ten roundings, so the origin is certainly on the outer side of the facet and of those
/// in its plane. For a bed one metre wide it is 3e-8 um.
const LIFT: f64 = 128.0 * f64::EPSILON;

/// A bed made ready for tracing.
pub struct Tracer {
    bed: Arc<Bed>,
    scene_sha256: Option<String>,
    accelerator: Arc<Accelerator>,
    /// Distance by which a ray's origin is lifted off each placement's facets, um.
    lift_um: Arc<[f64]>,
    field: Field,
    /// Height of the highest point, um, once it is needed.
    top_um: OnceLock<f64>,
}

/// What the sensor sees at one place.
#[derive(Debug, Clone, Copy)]
pub struct FirstHit {
    /// The mesh; `None` if it is the floor, or a solid that a side cuts.
    pub mesh: Option<usize>,
    /// Index of the material.
    pub material: u16,
    /// Cosine between the facet's normal and the direction to the sensor.
    pub cosine: f64,
}

impl Tracer {
    /// Builds the acceleration structure.
    pub fn new(bed: Bed) -> Self {
        let accelerator = Arc::new(Accelerator::new(&bed));
        Self::with(bed, accelerator)
    }

    /// The tracer of a scene whose files were read.
    ///
    /// # Errors
    /// A mesh is broken, or the bed does not fit its domain.
    pub fn of(sources: &Sources) -> Result<Self, Error> {
        Ok(Self { scene_sha256: Some(sources.sha256()?), ..Self::new(sources.bed()?) })
    }

    /// The tracer of a bed whose acceleration structure is there: it is the same from every side.
    pub fn with(bed: Bed, accelerator: Arc<Accelerator>) -> Self {
        let lift_um = bed
            .placements
            .iter()
            .map(|place| {
                let m = place.to_scene.matrix3;
                let scale = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
                let extent = f64::from(bed.meshes[place.mesh].extent_um());
                (place.to_scene.translation.abs().max_element() + extent * scale) * LIFT
            })
            .collect();
        let field = Field::new(&bed, bed.domain.sides);
        let (bed, top_um) = (Arc::new(bed), OnceLock::new());
        Self { bed, scene_sha256: None, accelerator, lift_um, field, top_um }
    }

    /// The same bed within other sides.
    #[must_use]
    pub fn within(&self, sides: Sides) -> Self {
        let field = Field::new(&self.bed, sides);
        let (bed, accelerator) = (Arc::clone(&self.bed), Arc::clone(&self.accelerator));
        let (scene_sha256, lift_um) = (self.scene_sha256.clone(), Arc::clone(&self.lift_um));
        let top_um = self.top_um.clone();
        Self { bed, scene_sha256, accelerator, lift_um, field, top_um }
    }

    /// SHA-256 of the scene file and its meshes, if the bed was read from them.
    pub fn scene_sha256(&self) -> Option<&str> {
        self.scene_sha256.as_deref()
    }

    /// The bed that is traced.
    pub fn bed(&self) -> &Bed {
        &self.bed
    }

    /// The closest-hit structure.
    pub fn accelerator(&self) -> &Accelerator {
        &self.accelerator
    }

    /// Traces the paths of these numbers. `progress` is told how many more paths are done, from any
    /// thread, and may stop the work.
    pub fn trace(
        &self,
        rules: &TracingRules,
        seed: u64,
        purpose: Purpose,
        numbers: Range<u64>,
        progress: &(dyn Fn(u64) -> Result<(), Interrupted> + Sync),
    ) -> Result<Tally, Interrupted> {
        let points = Points::new(seed, purpose, rules.sampler);
        let mut sum = self.nothing(rules);
        for first in numbers.clone().step_by(WAVE as usize) {
            let end = (first + WAVE).min(numbers.end);
            sum.add(&self.wave(rules, &points, first..end, progress)?);
        }
        Ok(sum)
    }

    /// Counts of no path.
    pub(crate) fn nothing(&self, rules: &TracingRules) -> Tally {
        Tally::new(self.bed.materials, rules.kept)
    }

    /// Traces paths in the order of where they begin: neighbours meet the same nodes and triangles,
    /// which are still in the caches. Counts do not depend on the order.
    fn wave(
        &self,
        rules: &TracingRules,
        points: &Points,
        numbers: Range<u64>,
        progress: &(dyn Fn(u64) -> Result<(), Interrupted> + Sync),
    ) -> Result<Tally, Interrupted> {
        let begun = |(net, mut point): (u16, Point)| (point.pair(), net, point);
        let block = |number: usize| {
            let first = numbers.start + (number * BLOCK) as u64;
            points.of(first, (first + BLOCK as u64).min(numbers.end)).map(begun)
        };
        let blocks = ((numbers.end - numbers.start) as usize).div_ceil(BLOCK);
        let mut paths: Vec<_> = (0..blocks).into_par_iter().flat_map_iter(block).collect();
        paths.par_sort_by_cached_key(|(place, ..)| morton(*place));
        paths
            .par_chunks_mut(BLOCK)
            .map(|block| {
                let mut tally = self.nothing(rules);
                for (place, net, point) in &mut *block {
                    tally.begin(group_of(*net, *place, CELLS_OF_VIEW), self.cell(*place));
                    let ray = self.field.start(*place, || point.pair());
                    if rules.nodes.is_empty() {
                        self.follow(rules, ray, point, &mut tally);
                    } else {
                        self.follow_at_nodes(rules, ray, point, &mut tally);
                    }
                }
                progress(block.len() as u64)?;
                Ok(tally)
            })
            .try_reduce(
                || self.nothing(rules),
                |mut sum, part| {
                    sum.add(&part);
                    Ok(sum)
                },
            )
    }

    /// The cell of the view at a place in it; `None` where the target does not fill the view.
    fn cell(&self, place: [f64; 2]) -> Option<u16> {
        let [x, y] = place.map(|at| (at * f64::from(CELLS)) as u16);
        (self.bed.domain.sides != Sides::Open).then_some(x + CELLS * y)
    }

    /// One path of a camera above the scene, whose ray is given in the scene's coordinates. A ray
    /// that never comes down misses.
    pub(crate) fn path_of_camera(
        &self,
        rules: &TracingRules,
        (origin, direction): (DVec3, DVec3),
        random: &mut Point,
        tally: &mut Tally,
    ) {
        match self.field.enter(origin, direction) {
            Some(ray) => self.follow(rules, ray, random, tally),
            None => tally.reached_sky(1.0),
        }
    }

    /// What the sensor sees at a place in its view, 0 to 1 from the left and from below; of a field
    /// over its first patch.
    pub fn first_hit(&self, place: [f64; 2]) -> Option<FirstHit> {
        match self.next(&mut self.field.start(place, || [0.0, 0.0])) {
            Event::Hit { mesh, material, normal, .. } => {
                Some(FirstHit { mesh, material, cosine: normal.dot(self.bed.to_sensor) })
            }
            Event::Sky | Event::Lost | Event::Inside { .. } => None,
        }
    }
}

/// Morton order of a place in the view: the bits of its coordinates interleaved.
fn morton(place: [f64; 2]) -> u32 {
    let [x, y] = place.map(|at| (at * 65536.0) as u32);
    (0..16).map(|bit| (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1)).sum()
}
