//! Paths through grains that let light through, at one wavelength.
//!
//! At a face a path is reflected or refracted, by the Fresnel equations for unpolarised light; within
//! a grain it is absorbed along its way. A path knows in which media it is. Faces between solids of
//! one medium are none: grains that are pressed or seated into each other join. Of two media in one
//! place the one whose material the scene lists first counts (priorities: Schmidt and Budge, J.
//! Graph. Tools 7(2), 2002).

use std::cell::Cell;

use glam::DVec3;

use super::Tracer;
use super::field::{Meets, Ray};
use super::follow::OnMesh;
use super::media::{Inside, Kind, Node, crossing};
use super::rules::TracingRules;
use super::scatter::Scatter;
use crate::geometry::Bed;
use crate::histogram::tally::{Light, Tally};
use crate::scene::Sides;
use crate::support::math;
use crate::support::random::Point;
use crate::table::{NodesError, TableMaterial};

/// Faces after which a path is given up: where nothing is absorbed, some are caught in a grain by
/// total reflection for ever.
const MOST_FACES: u32 = 10_000;

/// Weight below which Russian roulette ends a path or raises it to this.
const RAISED_TO: f64 = 0.1;

/// The reflectance that the floor has in Russian roulette at least, so that a white floor in place
/// of a black one can be told.
const FLOOR_IN_ROULETTE: f64 = 0.5;

/// What a ray meets, and the length of the way there, um.
#[derive(Clone, Copy)]
pub(super) struct Face {
    kind: Meeting,
    length_um: f64,
}

#[derive(Clone, Copy)]
enum Meeting {
    /// A facet. The normal and the point beside the facet are on the ray's side.
    Facet {
        mesh: Option<usize>,
        material: u16,
        normal: DVec3,
        points: [DVec3; 2],
        /// Whether it is met from within its solid.
        within: bool,
    },
    Sky,
    Lost,
}

impl Face {
    /// Whether there is only sky.
    pub(super) fn is_sky(&self) -> bool {
        matches!(self.kind, Meeting::Sky)
    }
}

/// Whether each refractive mesh has an inside, and the sides let paths within grains go on.
///
/// # Errors
/// An open mesh, or sides that cut solids.
pub(super) fn check(bed: &Bed, materials: &[TableMaterial]) -> Result<(), NodesError> {
    let is_refractive = |m: &u16| materials[usize::from(*m)].spectrum.is_refractive();
    let open =
        bed.meshes.iter().find(|mesh| !mesh.closed && mesh.materials.iter().any(is_refractive));
    if let Some(mesh) = open {
        return Err(NodesError::Open(mesh.name.clone()));
    }
    match bed.domain.sides {
        Sides::Mirror | Sides::Open => Ok(()),
        Sides::Periodic | Sides::Field { .. } => Err(NodesError::Sides),
    }
}

impl Tracer {
    /// Follows a path at each node. All take the same random numbers, so that the curve over the
    /// nodes has less noise than each of them.
    pub(super) fn follow_at_nodes(
        &self,
        rules: &TracingRules,
        mut ray: Ray,
        random: &Point,
        tally: &mut Tally,
    ) {
        let face = self.face(&mut ray);
        if face.is_sky() {
            return tally.light_misses();
        }
        for (number, node) in rules.nodes.iter().enumerate() {
            let mut random = random.clone();
            let (light, solid) = self.follow_light(rules, node, ray, face, &mut random);
            tally.light(number as u16, &light);
            if let Some(solid) = solid.filter(|_| number == 0) {
                *tally.inside.entry((None, solid)).or_default() += 1;
            }
        }
    }

    /// The next face on a ray's way.
    pub(super) fn face(&self, ray: &mut Ray) -> Face {
        let length = Cell::new(0.0);
        let closest = |ray: &Ray, t_max: f64| {
            let hit = self.accelerator.closest(ray.origin, ray.direction, t_max);
            length.set(length.get() + hit.map_or(t_max, |hit| hit.t));
            hit
        };
        let kind = match self.field.follow(ray, closest) {
            Meets::Mesh(hit) => {
                let OnMesh { mesh, material, point, lift, normal, within } =
                    self.on_mesh(&hit, ray.direction);
                let points = [point + lift, point - lift];
                Meeting::Facet { mesh: Some(mesh), material, normal, points, within }
            }
            Meets::Plane { material, point, normal } => {
                Meeting::Facet { mesh: None, material, normal, points: [point; 2], within: false }
            }
            Meets::Sky => Meeting::Sky,
            Meets::Lost => Meeting::Lost,
        };
        Face { kind, length_um: length.get() }
    }

    /// Follows a path of weight 1 at one node, from the first face that it meets. Returns with it the
    /// opaque solid in which it was given up, if it was in one.
    #[allow(clippy::too_many_lines, reason = "one walk, whose steps share all of its state")]
    pub(super) fn follow_light(
        &self,
        rules: &TracingRules,
        node: &Node,
        mut ray: Ray,
        mut face: Face,
        random: &mut Point,
    ) -> (Light, Option<usize>) {
        let mut light = Light::default();
        let mut inside = Inside::default();
        let mut weight = 1.0;
        let mut by_floor = 1.0;
        // Whether the way to the face is accounted for.
        let mut absorbed = true;
        let given_up = |light: Light, weight| Light { given_up: weight, ..light };
        loop {
            if !absorbed && let Some((_, along)) = inside.medium() {
                weight *= math::exp(-along.absorbed_per_um * face.length_um);
            }
            absorbed = false;
            let (mesh, material, normal, points, within) = match face.kind {
                Meeting::Facet { mesh, material, normal, points, within } => {
                    (mesh, material, normal, points, within)
                }
                Meeting::Sky if inside.media.is_empty() => {
                    light.reached_sky = weight;
                    light.downward = ray.direction.z < 0.0;
                    return (light, None);
                }
                Meeting::Sky | Meeting::Lost => return (given_up(light, weight), None),
            };
            if light.faces == 0 {
                light.first = material;
            }
            light.faces += 1;
            if light.faces >= MOST_FACES {
                return (given_up(light, weight), None);
            }
            let [share, number] = random.pair();
            if weight * by_floor < RAISED_TO {
                let kept = weight * by_floor / RAISED_TO;
                let [roulette, _] = random.pair();
                if roulette >= kept {
                    return (light, None);
                }
                weight /= kept;
            }
            let cosine = (-ray.direction.dot(normal)).min(1.0);
            let number_of_medium = match &node.facets[usize::from(material)] {
                Kind::Into(medium) => *medium,
                _ if within => return (given_up(light, weight), mesh),
                kind => {
                    match kind {
                        Kind::Mirror(crystal) => {
                            weight *= crystal.reflectance(node.wavelength_um, cosine);
                        }
                        Kind::Floor(reflectance) => {
                            light.floor_hits += 1;
                            by_floor *= reflectance.max(FLOOR_IN_ROULETTE);
                        }
                        Kind::Even(reflectance) => weight *= reflectance,
                        Kind::Into(_) => unreachable!("it is opaque"),
                    }
                    let facet = rules.facets[usize::from(material)];
                    ray = Scatter::new(ray, points[0], facet, normal, [share, number]).ray(0);
                    face = self.face(&mut ray);
                    continue;
                }
            };
            // The media beyond the face.
            let mut beyond = inside.clone();
            if !within {
                beyond.enter(number_of_medium, || node.media[number_of_medium].drawn(number));
            } else if !beyond.leave(number_of_medium) {
                return (given_up(light, weight), mesh);
            }
            let (before, after) = (inside.medium(), beyond.medium());
            if before.map(|of| of.0) == after.map(|of| of.0) {
                inside = beyond;
                ray.origin = points[1];
                face = self.face(&mut ray);
                continue;
            }
            let crossing = crossing(before.map(|of| of.1), after.map(|of| of.1), cosine);
            let Some((reflectance, cosine_beyond)) = crossing else {
                ray = reflected(ray, points[0], normal);
                face = self.face(&mut ray);
                continue;
            };
            let denser = after.map_or(0.0, |of| of.1.absorbed_per_um);
            if denser > before.map_or(0.0, |of| of.1.absorbed_per_um) {
                // How much gets through the grain is known before reflection is drawn: opaque grains
                // reflect every path, with less weight.
                let mut through = refracted(ray, points[1], normal, cosine_beyond);
                let next = self.face(&mut through);
                let transmitted = (1.0 - reflectance) * math::exp(-denser * next.length_um);
                let both = reflectance + transmitted;
                weight *= both;
                if share * both < reflectance {
                    ray = reflected(ray, points[0], normal);
                    face = self.face(&mut ray);
                } else {
                    (ray, face, inside, absorbed) = (through, next, beyond, true);
                }
            } else if share < reflectance {
                ray = reflected(ray, points[0], normal);
                face = self.face(&mut ray);
            } else {
                ray = refracted(ray, points[1], normal, cosine_beyond);
                inside = beyond;
                face = self.face(&mut ray);
            }
        }
    }
}

/// A ray that goes on from a point as from a mirror.
fn reflected(mut ray: Ray, point: DVec3, normal: DVec3) -> Ray {
    let direction = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
    (ray.origin, ray.direction) = (point, direction.normalize());
    ray
}

/// A ray that goes on beyond a face, at this cosine with its normal.
fn refracted(mut ray: Ray, point: DVec3, normal: DVec3, cosine: f64) -> Ray {
    let along = ray.direction - ray.direction.dot(normal) * normal;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let direction = along.normalize_or_zero() * sine - cosine * normal;
    (ray.origin, ray.direction) = (point, direction.normalize());
    ray
}
