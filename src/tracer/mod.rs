//! Paths traced backward from the sensor, and counts of what they hit.
//!
//! Facets are opaque and scatter a path independently of wavelength: a Lambertian one by the
//! cosine, a specular one as a mirror. So one path serves every band.

mod alone;
mod bed_warnings;
pub mod bvh;
pub mod coverage;
pub(crate) mod field;
pub(crate) mod footprint;
pub mod light;
pub mod rules;
mod scatter;
pub mod trace;
mod turn;
pub mod until;

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::Bed;
use crate::geometry::ingest::Sources;
use crate::histogram::kept::PARTS;
use crate::histogram::tally::{CELLS, Tally};
use crate::scene::Sides;
use crate::support::error::Error;
use crate::support::monitor::Interrupted;
use crate::support::random::{CELLS_OF_VIEW, Point, Points, Purpose, group_of};
use crate::tracer::bvh::{Accelerator, Hit};
use crate::tracer::field::{Field, Meets, Ray};
use crate::tracer::rules::TracingRules;
use crate::tracer::scatter::Scatter;

/// Paths that are sorted by where they begin and traced together.
pub(crate) const WAVE: u64 = 1 << 15;

/// Paths that one thread traces at a time.
const BLOCK: usize = 1024;

/// Distance by which a ray's origin is lifted off its facet, as a share of the greatest coordinate:
/// 256 times the rounding of a double. Hit points and their transforms from one mesh to another
/// take some ten roundings, so the origin is certainly on the outer side of the facet and of those
/// in its plane. For a bed one metre wide it is 3e-8 um.
const LIFT: f64 = 128.0 * f64::EPSILON;

/// Weight to which Russian roulette raises a path, by the greatest reflectance of each facet in any
/// band. Twice as much or half of it costs as much (docs/notes/tracer.md).
const RAISED_TO: f64 = 0.1;

/// Most paths that one stands for after Russian roulette: more would dominate in bands that are
/// brighter than those the paths were traced for.
const STANDS_FOR: u64 = 8;

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

/// What a ray meets.
///
/// A ray is inside a solid if it meets a closed mesh from behind. The sensor is above everything,
/// so this happens only where solids overlap, or so near to where two touch that the lifted origin
/// is inside the other one.
enum Event {
    /// On no mesh if it is the floor, or a solid that a side cuts.
    Hit {
        mesh: Option<usize>,
        material: u16,
        point: DVec3,
        normal: DVec3,
    },
    Inside {
        mesh: usize,
    },
    Sky,
    Lost,
}

/// Where a ray hits a mesh.
struct OnMesh {
    mesh: usize,
    material: u16,
    point: DVec3,
    /// From the point off the surface, to the ray's side.
    lift: DVec3,
    /// On the ray's side.
    normal: DVec3,
    /// Whether the ray comes from within a solid.
    within: bool,
}

impl Tracer {
    /// Builds the acceleration structure.
    pub fn new(bed: Bed) -> Self {
        let accelerator = Accelerator::new(&bed);
        Self::with(bed, accelerator, None)
    }

    /// The tracer of a scene whose files were read.
    ///
    /// # Errors
    /// A mesh is broken, or the bed does not fit its domain.
    pub fn of(sources: &Sources) -> Result<Self, Error> {
        Ok(Self { scene_sha256: Some(sources.sha256()?), ..Self::new(sources.bed()?) })
    }

    fn with(bed: Bed, accelerator: Accelerator, scene_sha256: Option<String>) -> Self {
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
        let (bed, accelerator) = (Arc::new(bed), Arc::new(accelerator));
        Self { bed, scene_sha256, accelerator, lift_um, field, top_um: OnceLock::new() }
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

    /// Follows a path to its end.
    fn follow(&self, rules: &TracingRules, mut ray: Ray, random: &mut Point, tally: &mut Tally) {
        let mut left = None;
        let mut weight = 1.0;
        let mut event = self.next(&mut ray);
        loop {
            match event {
                Event::Sky => return tally.reached_sky(ray.direction.z),
                Event::Lost => return tally.give_up(),
                Event::Inside { mesh } => return tally.give_up_inside(left, mesh),
                Event::Hit { mesh, material, point, normal } => {
                    left = mesh;
                    let facet = rules.facets[usize::from(material)];
                    let on = (material, self.layer(rules, ray, material, (point, normal)));
                    let (symbol, hits) = tally.hit(on, facet.by_angle, -ray.direction.dot(normal));
                    weight *= rules.greatest[symbol];
                    if hits >= rules.most_hits || weight * tally.share() < rules.least_weight {
                        return tally.give_up();
                    }
                    let mut numbers = random.pair();
                    // No roulette before the several rays of the first hit.
                    if hits > 1 && !rules.kept.order {
                        let times = (RAISED_TO / (weight * tally.share())) as u64;
                        let times = times.min(STANDS_FOR / tally.stands_for());
                        if times > 1 {
                            // The rest of the number is as random as the whole.
                            numbers[1] *= times as f64;
                            let goes_on = numbers[1] < 1.0;
                            tally.roulette(times, goes_on);
                            if !goes_on {
                                return;
                            }
                        }
                    }
                    let scatter = Scatter::new(ray, point, facet, normal, numbers);
                    (ray, event) = if hits == 1 && facet.specular < 1.0 {
                        match self.split(&scatter, random, tally) {
                            Some(rest) => rest,
                            None => return,
                        }
                    } else {
                        let mut ray = scatter.ray(0);
                        let event = self.next(&mut ray);
                        (ray, event)
                    };
                }
            }
        }
    }

    /// The layer of temperature of a place that a ray met, its point lifted off the surface.
    fn layer(
        &self,
        rules: &TracingRules,
        ray: Ray,
        material: u16,
        (point, normal): (DVec3, DVec3),
    ) -> u16 {
        let Some(of) = rules.layers.as_ref().filter(|of| of.has[usize::from(material)]) else {
            return 0;
        };
        let in_sun = of.to_sun.is_some_and(|to_sun| {
            let mut to_sun = ray.towards(point, to_sun);
            to_sun.direction.dot(normal) > 0.0 && self.sees_sky(&mut to_sun)
        });
        of.layers.layer(self.top_um() - point.z, in_sun)
    }

    /// Height of the highest point of the bed, um.
    fn top_um(&self) -> f64 {
        *self.top_um.get_or_init(|| {
            let (_, high) = Bed::bounds_um(&self.bed.meshes, &self.bed.placements);
            self.bed.domain.floor.map_or(high.z, |(z_um, _)| high.z.max(z_um))
        })
    }

    /// Tries several directions at a path's first hit, where rays reach the sky most often
    /// (next-event estimation). Each that reaches it brings its part of the path there. The others
    /// together go on along one of them: along the first if it is blocked, since its hit is known,
    /// else along any.
    ///
    /// Each direction has the distribution of a single one. So has the one that goes on, among
    /// those that are blocked: all points of the lattice are alike, so the first is any of them
    /// with equal probability. No mean changes, only its noise.
    fn split(
        &self,
        scatter: &Scatter,
        random: &mut Point,
        tally: &mut Tally,
    ) -> Option<(Ray, Event)> {
        let mut first = scatter.ray(0);
        let event = self.next(&mut first);
        let is_open = matches!(event, Event::Sky);
        let (mut cosines, mut open) = ([0.0; PARTS as usize], 0);
        let (mut blocked, mut count) = ([0; PARTS as usize], 0);
        for number in 0..PARTS {
            let mut ray = if number == 0 { first } else { scatter.ray(number) };
            if if number == 0 { is_open } else { self.sees_sky(&mut ray) } {
                cosines[open] = ray.direction.z;
                open += 1;
            } else {
                blocked[count] = number;
                count += 1;
            }
        }
        tally.parts_reached_sky(&cosines[..open]);
        if count == 0 {
            return None;
        }
        if !is_open {
            return Some((first, event));
        }
        let [among, _] = random.pair();
        let mut ray = scatter.ray(blocked[(among * count as f64) as usize]);
        let event = self.next(&mut ray);
        Some((ray, event))
    }

    /// Whether a ray reaches the sky.
    fn sees_sky(&self, ray: &mut Ray) -> bool {
        let any = |ray: &Ray, t_max| self.accelerator.any(ray.origin, ray.direction, t_max);
        matches!(self.field.follow(ray, |ray, t_max| any(ray, t_max).then_some(())), Meets::Sky)
    }

    /// Follows a ray to the next surface.
    fn next(&self, ray: &mut Ray) -> Event {
        let closest = |ray: &Ray, t_max| self.accelerator.closest(ray.origin, ray.direction, t_max);
        match self.field.follow(ray, closest) {
            Meets::Mesh(hit) => self.at_mesh(&hit, ray.direction),
            Meets::Plane { material, point, normal } => {
                Event::Hit { mesh: None, material, point, normal }
            }
            Meets::Sky => Event::Sky,
            Meets::Lost => Event::Lost,
        }
    }

    /// What a ray meets where it hits a mesh.
    fn on_mesh(&self, hit: &Hit, direction: DVec3) -> OnMesh {
        let place = &self.bed.placements[hit.placement];
        let mesh = &self.bed.meshes[place.mesh];
        let [a, b, c] = hit.corners.map(Vec3::as_dvec3);
        let [v, w] = hit.weights;
        let point = place.to_scene.transform_point3(a + v * (b - a) + w * (c - a));
        let matrix = place.to_scene.matrix3;
        let (ab, ac) = (matrix * (b - a), matrix * (c - a));
        let cross = ab.cross(ac);
        let outward = cross.normalize() * place.handedness();
        let behind = outward.dot(direction) > 0.0;
        let normal = if behind { -outward } else { outward };
        // The narrower a triangle, the less certain is which way it faces.
        let narrow = ab.length() * ac.length() / cross.length();
        OnMesh {
            mesh: place.mesh,
            material: mesh.materials[hit.triangle],
            point,
            lift: self.lift_um[hit.placement] * narrow * normal,
            normal,
            within: behind && mesh.closed,
        }
    }

    /// A hit on a mesh from outside, its point lifted off the surface.
    fn at_mesh(&self, hit: &Hit, direction: DVec3) -> Event {
        let OnMesh { mesh, material, point, lift, normal, within } = self.on_mesh(hit, direction);
        if within {
            return Event::Inside { mesh };
        }
        Event::Hit { mesh: Some(mesh), material, point: point + lift, normal }
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
