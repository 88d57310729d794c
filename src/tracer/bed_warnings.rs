//! Warnings that a bed gives before it is traced.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::{Bed, Mesh, Placement, cross};
use crate::scene::{Origin, Sides};
use crate::support::math;
use crate::support::random::{Purpose, Source};
use crate::table::warning::Warning;
use crate::tracer::Tracer;

/// A given patch narrower than this many of its largest bodies gives a warning. How much the beds of
/// a recipe differ is part of their budget.
const LEAST_WIDTHS: f64 = 1.0;

/// Share of the facets that are too fine, or within other solids, that gives a warning. Some narrow
/// facets do no harm, and grains of a drop press a little into each other.
const NOTABLE: f64 = 0.01;

/// A body whose facets add up to so small a vector area, as a share of their area, is closed except
/// for holes. Open sheets and pits lie far above.
const NEARLY_CLOSED: f64 = 0.1;

/// Mean of 1 - cos between the facets and the normals in the file that gives a warning.
const NOTABLY_CURVED: f64 = 0.003;

/// Solids that reach into each other by less than this share of their size only touch.
const TOUCHING: f64 = 1e-3;

/// Points on facets that are tested for lying within another solid.
const PROBES: u64 = 1 << 12;

/// The warnings of a bed: of each kind the worst.
pub(super) fn of_bed(tracer: &Tracer, origin: Origin, longest_um: f64, seed: u64) -> Vec<Warning> {
    let bed = tracer.bed();
    let placed: BTreeSet<usize> = bed.placements.iter().map(|place| place.mesh).collect();
    let worst = |of: &dyn Fn(&Mesh) -> f64, limit: f64| {
        let meshes = placed.iter().map(|&mesh| (&bed.meshes[mesh], of(&bed.meshes[mesh])));
        meshes.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, of)| *of > limit)
    };
    let mut warnings = Vec::new();
    let too_fine = |m: &Mesh| m.quality.too_fine as f64 / m.quality.facets as f64;
    // Grains of a recipe are about their own origin: their few narrow facets have no area.
    if let Some((mesh, share)) = worst(&too_fine, NOTABLE).filter(|_| origin == Origin::Given) {
        let rounding_um = mesh.quality.rounding_um;
        warnings.push(Warning::TooFine { mesh: mesh.name.clone(), share, rounding_um });
    }
    let holes = |m: &Mesh| if is_holed(m) { m.quality.open_edges as f64 } else { 0.0 };
    if let Some((mesh, _)) = worst(&holes, 0.0) {
        let (edges, of) = (mesh.quality.open_edges, mesh.quality.edges);
        warnings.push(Warning::Holes { mesh: mesh.name.clone(), edges, of });
    }
    if let Some((mesh, curved)) = worst(&|m| m.quality.curved, NOTABLY_CURVED) {
        let angle_deg = math::acos(1.0 - curved).to_degrees();
        warnings.push(Warning::Coarse { mesh: mesh.name.clone(), angle_deg });
    }
    let bodies: Vec<Body> = bed.placements.par_iter().map(|place| Body::new(bed, place)).collect();
    let smallest = bodies.iter().min_by(|a, b| a.size_um().total_cmp(&b.size_um()));
    if let Some(body) = smallest.filter(|body| body.size_um() < longest_um) {
        let (mesh, size_um) = (body.mesh.name.clone(), body.size_um());
        warnings.push(Warning::SmallerThanWaves { mesh, size_um, wavelength_um: longest_um });
    }
    if bed.repeated > 0 {
        warnings.push(Warning::Repeated { placements: bed.repeated });
    }
    let share = overlap(tracer, &bodies, seed);
    if share > NOTABLE {
        warnings.push(Warning::Overlap { share });
    }
    let domain = &bed.domain;
    if domain.sides == Sides::Open {
        return warnings;
    }
    if let Some(body) = bodies.par_iter().find_first(|body| body.is_in_side(bed)) {
        warnings.push(Warning::InSide { mesh: body.mesh.name.clone() });
    }
    let width = (domain.max_um - domain.min_um).truncate().min_element();
    // A single mesh of many parts is a whole bed: its bodies are not told apart.
    let is_one =
        |body: &&Body| body.mesh.closed && (bodies.len() > 1 || body.mesh.particles.len() == 1);
    let widths = width / bodies.iter().filter(is_one).map(Body::size_um).fold(0.0, f64::max);
    if origin == Origin::Given && widths < LEAST_WIDTHS {
        warnings.push(Warning::NarrowPatch { widths });
    }
    warnings
}

/// A mesh in its place, and the box around it, um.
struct Body<'a> {
    mesh: &'a Mesh,
    place: &'a Placement,
    low: DVec3,
    high: DVec3,
}

impl<'a> Body<'a> {
    fn new(bed: &'a Bed, place: &'a Placement) -> Self {
        let (low, high) = Bed::bounds_um(&bed.meshes, std::slice::from_ref(place));
        Self { mesh: &bed.meshes[place.mesh], place, low, high }
    }

    fn size_um(&self) -> f64 {
        (self.high - self.low).max_element()
    }

    /// Whether a point lies within it: its facets, seen from there, fill the whole sphere.
    fn holds(&self, point: DVec3) -> bool {
        let point = self.place.to_scene.inverse().transform_point3(point);
        let angle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|i| self.mesh.vertices[i as usize].as_dvec3() - point);
            let (x, y, z) = (a.length(), b.length(), c.length());
            // Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30(2) 125, 1983, Eq. 8.
            let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            2.0 * math::atan2(a.dot(b.cross(c)), below)
        };
        self.mesh.triangles.iter().map(angle).sum::<f64>().abs() > 2.0 * PI
    }

    /// Whether a facet that rays can meet lies in a side of the domain, within the rounding of its
    /// coordinates.
    fn is_in_side(&self, bed: &Bed) -> bool {
        let Body { mesh, place, low, high } = self;
        let near = 4.0 * mesh.quality.rounding_um * place.to_scene.matrix3.x_axis.length();
        let is_facet = |triangle: [u32; 3], axis: usize, side: f64, inward: f64| {
            let corners = place.corners_um(mesh, triangle);
            // The facets of a solid in the domain are seen from the other side only.
            let is_met = !mesh.closed || place.handedness() * inward * cross(corners)[axis] > 0.0;
            is_met && corners.iter().all(|p| (p[axis] - side).abs() <= near)
        };
        let sides = [(bed.domain.min_um, 1.0), (bed.domain.max_um, -1.0)];
        (0..2).any(|axis| {
            sides.iter().any(|&(corner, inward)| {
                let side = corner[axis];
                let touches = low[axis] - near <= side && side <= high[axis] + near;
                touches && mesh.triangles.iter().any(|t| is_facet(*t, axis, side, inward))
            })
        })
    }
}

/// Whether a mesh is a body with holes, and not a sheet.
fn is_holed(mesh: &Mesh) -> bool {
    if mesh.quality.open_edges == 0 {
        return false;
    }
    let area = |triangle: &[u32; 3]| cross(triangle.map(|i| mesh.vertices[i as usize].as_dvec3()));
    let areas = mesh.triangles.iter().map(area);
    let (sum, total) =
        areas.fold((DVec3::ZERO, 0.0), |(sum, total), area| (sum + area, total + area.length()));
    sum.length() < NEARLY_CLOSED * total
}

/// Share of the facets that lie within a solid placed elsewhere. Seen from a point a little off
/// such a facet, the nearest surface outward is the inner side of another solid, and a point as far
/// below it as [`TOUCHING`] is within that solid too.
fn overlap(tracer: &Tracer, bodies: &[Body], seed: u64) -> f64 {
    let bed = tracer.bed();
    if bed.placements.len() < 2 {
        return 0.0;
    }
    let source = Source::new(seed, Purpose::Coverage);
    let is_within = |probe: u64| {
        // The view and the silhouettes have the streams before this one.
        let mut random = source.stream(u64::MAX - probe);
        let ([which, facet], [u, v]) = (random.pair(), random.pair());
        let of = |share: f64, number: usize| ((share * number as f64) as usize).min(number - 1);
        let own = of(which, bed.placements.len());
        let place = &bed.placements[own];
        let mesh = &bed.meshes[place.mesh];
        let triangle = mesh.triangles[of(facet, mesh.triangles.len())];
        let [a, b, c] = place.corners_um(mesh, triangle);
        let Some(normal) = (place.handedness() * cross([a, b, c])).try_normalize() else {
            return false;
        };
        let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
        let lift = 1e-6 * (b - a).length().max((c - a).length());
        let origin = a + u * (b - a) + v * (c - a) + lift * normal;
        let Some(hit) = tracer.accelerator().closest(origin, normal, f64::INFINITY) else {
            return false;
        };
        let place = &bed.placements[hit.placement];
        let other = &bed.meshes[place.mesh];
        let facet = cross(place.corners_um(other, other.triangles[hit.triangle]));
        hit.placement != own
            && other.closed
            && place.handedness() * facet.dot(normal) > 0.0
            && bodies[hit.placement].holds(origin - TOUCHING * bodies[own].size_um() * normal)
    };
    let within = (0..PROBES).into_par_iter().filter(|&probe| is_within(probe)).count();
    within as f64 / PROBES as f64
}
