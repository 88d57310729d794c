//! Paths through grains that let light through, at one wavelength.
//!
//! At a face a path is reflected or refracted, by the Fresnel equations for unpolarised light; within
//! a grain it is absorbed along its way. A path knows in which media it is. Faces between solids of
//! one medium are none: grains that are pressed or seated into each other join. Of two media in one
//! place the one whose material the scene lists first counts (priorities: Schmidt and Budge, J.
//! Graph. Tools 7(2), 2002).

use std::cell::Cell;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use super::field::{Meets, Ray};
use super::rules::TracingRules;
use super::scatter::Scatter;
use super::{OnMesh, Tracer};
use crate::geometry::Bed;
use crate::histogram::tally::{Light, Tally};
use crate::scene::Sides;
use crate::spectrum::optics::{Axis, Crystal, inward, outward};
use crate::spectrum::{Spectrum, kirchhoff};
use crate::support::math;
use crate::support::random::Point;
use crate::table::{Nodes, NodesError, TableMaterial};

/// Faces after which a path is given up: where nothing is absorbed, some are caught in a grain by
/// total reflection for ever.
const MOST_FACES: u32 = 10_000;

/// Weight below which Russian roulette ends a path or raises it to this.
const RAISED_TO: f64 = 0.1;

/// The reflectance that the floor has in Russian roulette at least, so that a white floor in place
/// of a black one can be told.
const FLOOR_IN_ROULETTE: f64 = 0.5;

/// What light of one wavelength does at the facets of each material.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    wavelength_um: f64,
    facets: Vec<Kind>,
    media: Vec<Medium>,
}

/// The facets of a material at one wavelength.
#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// Refractive: the number of the medium within.
    Into(usize),
    /// Opaque, with a reflectance that is the same at every angle.
    Even(f64),
    /// Opaque mirrors of a crystal.
    Mirror(Arc<Crystal>),
    /// The floor's, opaque: the weight leaves its reflectance out.
    Floor(f64),
}

/// A medium at one wavelength.
#[derive(Debug, Clone, PartialEq)]
struct Medium {
    /// One of them is drawn where a path enters a grain.
    axes: Vec<Along>,
}

/// A medium for an electric field along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Along {
    /// Weights of this axis and of those before it, of 1.
    until: f64,
    dielectric: Complex64,
    absorbed_per_um: f64,
}

impl Node {
    /// At each node of a scene.
    pub(super) fn of(nodes: &Nodes, materials: &[TableMaterial]) -> Vec<Self> {
        let of = |(i, um): (usize, &f64)| {
            Self::new(nodes, materials, *um, nodes.opaque.get(i) == Some(&true))
        };
        nodes.wavelength_um.iter().enumerate().map(of).collect()
    }

    fn new(nodes: &Nodes, materials: &[TableMaterial], wavelength_um: f64, opaque: bool) -> Self {
        let mut crystals: Vec<&Arc<Crystal>> = Vec::new();
        let facets = materials.iter().enumerate().map(|(i, material)| match &material.spectrum {
            Spectrum::Refractive(_, crystal) if opaque && material.auto => {
                Kind::Mirror(Arc::clone(crystal))
            }
            Spectrum::Refractive(_, crystal) => {
                let known = crystals.iter().position(|known| *known == crystal);
                Kind::Into(known.unwrap_or_else(|| {
                    crystals.push(crystal);
                    crystals.len() - 1
                }))
            }
            Spectrum::Fresnel(_, crystal) => Kind::Mirror(Arc::clone(crystal)),
            other => {
                let emissivity = other.emissivity(wavelength_um);
                let reflectance = kirchhoff(emissivity.expect("the spectrum holds the bands"));
                let is_floor = nodes.floor == Some(i);
                if is_floor { Kind::Floor(reflectance) } else { Kind::Even(reflectance) }
            }
        });
        let facets = facets.collect();
        let media = crystals.iter().map(|crystal| Medium::new(crystal, wavelength_um)).collect();
        Self { wavelength_um, facets, media }
    }
}

impl Medium {
    fn new(crystal: &Crystal, wavelength_um: f64) -> Self {
        let axes = crystal.axes.each();
        let whole: f64 = axes.iter().map(|(weight, _)| weight).sum();
        let mut until = 0.0;
        let along = |(weight, axis): &(f64, &Axis)| {
            until += weight / whole;
            let dielectric = axis.dielectric(wavelength_um);
            let absorbed_per_um = 4.0 * PI * dielectric.sqrt().im / wavelength_um;
            Along { until, dielectric, absorbed_per_um }
        };
        Self { axes: axes.iter().map(along).collect() }
    }

    fn drawn(&self, number: f64) -> Along {
        let last = self.axes[self.axes.len() - 1];
        self.axes.iter().copied().find(|along| number < along.until).unwrap_or(last)
    }
}

/// The media that a path is in.
#[derive(Clone, Default)]
struct Inside {
    /// Number of a medium, how many solids of it the path is in, and the axis drawn.
    media: Vec<(usize, i32, Along)>,
}

impl Inside {
    /// The one that counts: that of the lowest number.
    fn medium(&self) -> Option<(usize, Along)> {
        self.media.iter().map(|(number, _, along)| (*number, *along)).min_by_key(|of| of.0)
    }

    /// The path enters a solid.
    fn enter(&mut self, number: usize, along: impl FnOnce() -> Along) {
        match self.media.iter_mut().find(|(known, ..)| *known == number) {
            Some((_, solids, _)) => *solids += 1,
            None => self.media.push((number, 1, along())),
        }
    }

    /// The path leaves a solid. Whether it was in one.
    #[must_use]
    fn leave(&mut self, number: usize) -> bool {
        let Some(i) = self.media.iter().position(|(known, ..)| *known == number) else {
            return false;
        };
        self.media[i].1 -= 1;
        if self.media[i].1 == 0 {
            self.media.swap_remove(i);
        }
        true
    }
}

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

/// Reflectance of a face between two media, and the cosine of the refracted ray; `None` where all is
/// reflected. Vacuum is `None`.
///
/// Of two media the one that absorbs less stands for the vacuum, by its real index.
fn crossing(before: Option<Along>, after: Option<Along>, cosine: f64) -> Option<(f64, f64)> {
    let one = Complex64::new(1.0, 0.0);
    let [from, to] = [before, after].map(|of| of.map_or(one, |along| along.dielectric));
    let is_inward = match (before, after) {
        (None, _) => true,
        (_, None) => false,
        (Some(a), Some(b)) => a.absorbed_per_um <= b.absorbed_per_um,
    };
    let (outer, inner) = if is_inward { (from, to) } else { (to, from) };
    let index = outer.sqrt().re;
    let relative = inner / (index * index);
    let crossing =
        if is_inward { Some(inward(relative, cosine)) } else { outward(relative, cosine) };
    crossing.map(|crossing| (crossing.reflectance, crossing.cosine))
}
