//! A path from surface to surface, until it ends.

use glam::{DVec3, Vec3};

use super::Tracer;
use super::bvh::Hit;
use super::field::{Meets, Ray};
use super::rules::TracingRules;
use super::scatter::Scatter;
use crate::geometry::Bed;
use crate::histogram::kept::PARTS;
use crate::histogram::tally::Tally;
use crate::support::random::Point;

/// Weight to which Russian roulette raises a path, by the greatest reflectance of each facet in any
/// band. Twice as much or half of it costs as much (docs/notes/tracer.md).
const RAISED_TO: f64 = 0.1;

/// Most paths that one stands for after Russian roulette: more would dominate in bands that are
/// brighter than those the paths were traced for.
const STANDS_FOR: u64 = 8;

/// What a ray meets.
///
/// A ray is inside a solid if it meets a closed mesh from behind. The sensor is above everything,
/// so this happens only where solids overlap, or so near to where two touch that the lifted origin
/// is inside the other one.
pub(super) enum Event {
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
pub(super) struct OnMesh {
    pub(super) mesh: usize,
    pub(super) material: u16,
    pub(super) point: DVec3,
    /// From the point off the surface, to the ray's side.
    pub(super) lift: DVec3,
    /// On the ray's side.
    pub(super) normal: DVec3,
    /// Whether the ray comes from within a solid.
    pub(super) within: bool,
}

impl Tracer {
    /// Follows a path to its end.
    pub(super) fn follow(
        &self,
        rules: &TracingRules,
        mut ray: Ray,
        random: &mut Point,
        tally: &mut Tally,
    ) {
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
    pub(super) fn next(&self, ray: &mut Ray) -> Event {
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
    pub(super) fn on_mesh(&self, hit: &Hit, direction: DVec3) -> OnMesh {
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
}
