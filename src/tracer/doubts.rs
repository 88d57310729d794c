//! Warnings that a bed gives before it is traced.

use std::collections::BTreeSet;

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::{Bed, Mesh, Placement};
use crate::scene::Sides;
use crate::support::random::{Purpose, Source};
use crate::table::remark::Remark;
use crate::tracer::Tracer;

/// A patch narrower than so many of its largest bodies is said to be small.
const LEAST_WIDTHS: f64 = 3.0;

/// Share of the facets in meshes of too fine detail, and of facets within other solids, from which it is said: some
/// narrow facets do no harm, and grains of a drop press a little into each other.
const NOTABLE: f64 = 0.01;

/// A body whose facets add up to so small a vector area, as a share of their area, is closed but for holes; sheets and
/// pits that are meant to be open lie far above.
const NEARLY_CLOSED: f64 = 0.1;

/// Mean of 1 - cos between the facets and the normals that the file gives for them, from which it is said.
const NOTABLY_CURVED: f64 = 0.003;

/// Points on facets that are asked whether they lie within another solid.
const PROBES: u64 = 1 << 12;

/// What speaks against a bed: of each kind the worst.
pub fn of_bed(tracer: &Tracer, longest_um: f64, seed: u64) -> Vec<Remark> {
    let bed = tracer.bed();
    let placed: BTreeSet<usize> = bed.placements.iter().map(|place| place.mesh).collect();
    let placed: Vec<&Mesh> = placed.into_iter().map(|mesh| &bed.meshes[mesh]).collect();
    let worst = |of: &dyn Fn(&Mesh) -> f64| {
        placed.iter().copied().max_by(|a, b| of(a).total_cmp(&of(b))).map(|mesh| (mesh, of(mesh)))
    };
    let mut remarks = Vec::new();
    let too_fine = |m: &Mesh| m.doubts.too_fine as f64 / m.doubts.facets as f64;
    if let Some((mesh, share)) = worst(&too_fine).filter(|(_, share)| *share > NOTABLE) {
        let rounding_um = mesh.doubts.rounding_um;
        remarks.push(Remark::TooFine { mesh: mesh.name.clone(), share, rounding_um });
    }
    let holes = |m: &Mesh| if is_holed(m) { m.doubts.open_edges as f64 } else { 0.0 };
    if let Some((mesh, _)) = worst(&holes).filter(|(_, edges)| *edges > 0.0) {
        let (edges, of) = (mesh.doubts.open_edges, mesh.doubts.edges);
        remarks.push(Remark::Holes { mesh: mesh.name.clone(), edges, of });
    }
    let curved = |m: &Mesh| m.doubts.curved;
    if let Some((mesh, curved)) = worst(&curved).filter(|(_, curved)| *curved > NOTABLY_CURVED) {
        let angle_deg = (1.0 - curved).acos().to_degrees();
        remarks.push(Remark::Coarse { mesh: mesh.name.clone(), angle_deg });
    }
    let bodies: Vec<Body> = bed.placements.par_iter().map(|place| Body::new(bed, place)).collect();
    let smallest = bodies.iter().min_by(|a, b| a.size_um().total_cmp(&b.size_um()));
    if let Some(body) = smallest.filter(|body| body.size_um() < longest_um) {
        let (mesh, size_um) = (body.mesh.name.clone(), body.size_um());
        remarks.push(Remark::SmallerThanWaves { mesh, size_um, wavelength_um: longest_um });
    }
    let share = overlap(tracer, seed);
    if share > NOTABLE {
        remarks.push(Remark::Overlap { share });
    }
    let domain = &bed.domain;
    if domain.sides != Sides::Open
        && let Some(body) = bodies.par_iter().find_first(|body| body.is_in_side(bed))
    {
        remarks.push(Remark::InSide { mesh: body.mesh.name.clone() });
    }
    let width = (domain.max_um - domain.min_um).truncate().min_element();
    // A mesh of many parts that stands alone is a whole bed: its bodies are not told apart.
    let is_one =
        |body: &&Body| body.mesh.closed && (bodies.len() > 1 || body.mesh.particles.len() == 1);
    let widths = width / bodies.iter().filter(is_one).map(Body::size_um).fold(0.0, f64::max);
    if domain.sides != Sides::Open && widths < LEAST_WIDTHS {
        remarks.push(Remark::NarrowPatch { widths });
    }
    remarks
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

    /// Whether a facet that rays can meet lies in a side of the domain, as near as its mesh's coordinates tell.
    fn is_in_side(&self, bed: &Bed) -> bool {
        let Body { mesh, place: Placement { to_scene, .. }, low, high } = self;
        let near = 4.0 * mesh.doubts.rounding_um * to_scene.matrix3.x_axis.length();
        let is_facet = |triangle: &[u32; 3], axis: usize, side: f64, inward: f64| {
            let [a, b, c] =
                triangle.map(|i| to_scene.transform_point3(mesh.vertices[i as usize].as_dvec3()));
            let turned = to_scene.matrix3.determinant().signum() * inward;
            // What bounds a solid of the domain is seen from the other side only.
            let is_met = !mesh.closed || turned * (b - a).cross(c - a)[axis] > 0.0;
            is_met && [a, b, c].iter().all(|p| (p[axis] - side).abs() <= near)
        };
        let sides = [(bed.domain.min_um, 1.0), (bed.domain.max_um, -1.0)];
        (0..2).any(|axis| {
            sides.iter().any(|&(corner, inward)| {
                let side = corner[axis];
                let touches = low[axis] - near <= side && side <= high[axis] + near;
                touches && mesh.triangles.iter().any(|t| is_facet(t, axis, side, inward))
            })
        })
    }
}

/// Whether a mesh is a body with holes, and not a sheet.
fn is_holed(mesh: &Mesh) -> bool {
    if mesh.doubts.open_edges == 0 {
        return false;
    }
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| mesh.vertices[i as usize].as_dvec3());
        (b - a).cross(c - a)
    };
    let areas = mesh.triangles.iter().map(area);
    let (sum, total) =
        areas.fold((DVec3::ZERO, 0.0), |(sum, total), area| (sum + area, total + area.length()));
    sum.length() < NEARLY_CLOSED * total
}

/// Share of the facets that lie within a solid placed elsewhere: of a point a little off its facet the nearest surface
/// outward is the inner side of another solid.
fn overlap(tracer: &Tracer, seed: u64) -> f64 {
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
        let Placement { mesh, to_scene } = &bed.placements[own];
        let mesh = &bed.meshes[*mesh];
        let corners = mesh.triangles[of(facet, mesh.triangles.len())];
        let [a, b, c] =
            corners.map(|i| to_scene.transform_point3(mesh.vertices[i as usize].as_dvec3()));
        let turned = if to_scene.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        let Some(normal) = (turned * (b - a).cross(c - a)).try_normalize() else { return false };
        let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
        let lift = 1e-6 * (b - a).length().max((c - a).length());
        let origin = a + u * (b - a) + v * (c - a) + lift * normal;
        let Some(hit) = tracer.accelerator().closest(origin, normal, f64::INFINITY) else {
            return false;
        };
        let place = &bed.placements[hit.placement];
        let other = &bed.meshes[place.mesh];
        let [a, b, c] = other.triangles[hit.triangle]
            .map(|i| place.to_scene.transform_vector3(other.vertices[i as usize].as_dvec3()));
        let turned = if place.to_scene.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        let outward = turned * (b - a).cross(c - a).dot(normal);
        hit.placement != own && other.closed && outward > 0.0
    };
    let within = (0..PROBES).into_par_iter().filter(|&probe| is_within(probe)).count();
    within as f64 / PROBES as f64
}
