//! What speaks against a result that can still be given: cause and remedy, for the record and in words.
//!
//! Whatever makes a result wrong by more than its interval says is refused or stands here. `soilsig stress` drives each
//! of them from where it is harmless to where it is not (docs/stability.md).

use std::collections::BTreeSet;
use std::fmt;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::{Bed, Mesh, Placement};
use crate::radiometry::Lit;
use crate::random::{Purpose, Source};
use crate::scene::Sides;
use crate::signature::Band;
use crate::spectrum::Spectrum;
use crate::table::Table;
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

/// What speaks against a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Remark {
    /// Facets are finer than the mesh's coordinates tell apart.
    TooFine {
        /// The mesh.
        mesh: String,
        /// Share of its facets.
        share: f64,
        /// What its coordinates are rounded by, um.
        rounding_um: f64,
    },
    /// A solid has holes.
    Holes {
        /// The mesh.
        mesh: String,
        /// Edges of a single facet.
        edges: usize,
        /// Edges in all.
        of: usize,
    },
    /// Facets stand for a surface that the file says to be curved.
    Coarse {
        /// The mesh.
        mesh: String,
        /// Mean angle between facets and normals, degrees.
        angle_deg: f64,
    },
    /// A body is smaller than the waves.
    SmallerThanWaves {
        /// The mesh.
        mesh: String,
        /// Its length, um.
        size_um: f64,
        /// The longest wavelength, um.
        wavelength_um: f64,
    },
    /// Solids pass through each other.
    Overlap {
        /// Share of the facets that lie within another solid.
        share: f64,
    },
    /// Facets lie in a side of the domain.
    InSide {
        /// The mesh.
        mesh: String,
    },
    /// The patch holds few bodies side by side.
    NarrowPatch {
        /// Its shorter side in lengths of the largest body.
        widths: f64,
    },
    /// The bed is so shallow that its floor shows.
    Floor {
        /// Most that a band changes between a black and a white floor.
        effect: f64,
    },
    /// Straight lines between the points of a spectrum miss the curve.
    Undersampled {
        /// The spectrum's file.
        spectrum: String,
        /// By about so much.
        error: f64,
        /// Where, um.
        at_um: f64,
    },
    /// Near grazing incidence reflectance changes much within one bin of cosines.
    GrazingBins {
        /// The view, degrees from nadir.
        zenith_deg: f64,
        /// Half of the change within the bin of the view.
        error: f64,
    },
    /// Mirrors show the sky, whose radiance is taken in bins of its zenith angle.
    ZenithBins {
        /// The view, degrees from nadir.
        zenith_deg: f64,
        /// Half of what the sky changes by from the bin of the view to the next, as a share of a black body's radiance.
        error: f64,
    },
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFine { mesh, share, rounding_um } => write!(
                f,
                "{:.0} % of the facets of {mesh} are too fine for coordinates that are rounded by \
                 {rounding_um:.1e} um: make small parts prototypes of their own, about their own origin",
                100.0 * share
            ),
            Self::Holes { mesh, edges, of } => write!(
                f,
                "{mesh} is closed but for {edges} of {of} edges, which belong to one facet only: rays get \
                 into it; if it is to be a solid, mend it"
            ),
            Self::Coarse { mesh, angle_deg } => write!(
                f,
                "{mesh} stands for a curved surface, and its facets turn away from it by {angle_deg:.1} \
                 degrees on the mean: subdivide it"
            ),
            Self::SmallerThanWaves { mesh, size_um, wavelength_um } => write!(
                f,
                "{mesh} is {size_um:.2e} um long, below the wavelength of {wavelength_um} um: rays do not \
                 hold there; is its unit right?"
            ),
            Self::Overlap { share } => write!(
                f,
                "solids pass through each other: {:.1} % of the facets lie within another solid; rays see \
                 what is outermost",
                100.0 * share
            ),
            Self::InSide { mesh } => write!(
                f,
                "facets of {mesh} lie in a side of the domain, and rays may go either way there: put the side before \
                 or behind them"
            ),
            Self::NarrowPatch { widths } => write!(
                f,
                "the patch is {widths:.1} of its largest bodies wide: patches of that size differ by much; \
                 make it wider, or take the mean of several"
            ),
            Self::Floor { effect } => write!(
                f,
                "the floor shows: between a black and a white one a band changes by {effect:.4}; make the \
                 bed deeper"
            ),
            Self::Undersampled { spectrum, error, at_um } => write!(
                f,
                "the points of {spectrum} are too far apart: straight lines between them miss it by about \
                 {error:.3} near {at_um} um"
            ),
            Self::GrazingBins { zenith_deg, error } => write!(
                f,
                "seen from {zenith_deg} degrees, facets that lie flat are known to {error:.3} only: that is \
                 half of what their reflectance changes by within one bin of cosines"
            ),
            Self::ZenithBins { zenith_deg, error } => write!(
                f,
                "seen from {zenith_deg} degrees, mirrors that lie flat are known to {error:.3} of a black body's radiance \
                 only: that is half of what the sky changes by from one degree of zenith angle to the next"
            ),
        }
    }
}

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

/// What speaks against the signature of packings of one recipe, their beds included; `floor_effect` is what a black and a
/// white floor differ by. Of each kind the first.
pub fn of_result(
    packings: &[Table],
    bands: &[Band],
    tolerance: f64,
    floor_effect: Option<f64>,
) -> Vec<Remark> {
    let table = &packings[0];
    let mut remarks: Vec<Remark> = packings.iter().flat_map(|t| t.remarks.clone()).collect();
    remarks.extend(
        floor_effect.filter(|effect| *effect > tolerance).map(|effect| Remark::Floor { effect }),
    );
    let span = [bands[0].wavelength_um, bands[bands.len() - 1].wavelength_um];
    for material in &table.materials {
        if let Spectrum::Tabulated(points) = &material.spectrum
            && let Some((error, at_um)) = points.sampling_error(span)
            && error > tolerance
        {
            let spectrum = points.file.clone();
            remarks.push(Remark::Undersampled { spectrum, error, at_um });
        }
    }
    remarks.extend(
        grazing_bins(table, bands)
            .filter(|(_, error)| *error > tolerance)
            .map(|(zenith_deg, error)| Remark::GrazingBins { zenith_deg, error }),
    );
    remarks.extend(
        zenith_bins(table, bands)
            .filter(|(_, error)| *error > tolerance)
            .map(|(zenith_deg, error)| Remark::ZenithBins { zenith_deg, error }),
    );
    let mut kinds = Vec::new();
    remarks.retain(|remark| {
        let kind = std::mem::discriminant(remark);
        let is_new = !kinds.contains(&kind);
        kinds.push(kind);
        is_new
    });
    remarks
}

/// The view's zenith angle, and half of what the sky's radiance changes by from its bin to the next where mirrors show it,
/// in the worst band.
fn zenith_bins(table: &Table, bands: &[Band]) -> Option<(f64, f64)> {
    let specular = table.materials.iter().map(|m| m.specular).fold(0.0, f64::max);
    let um: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let lit = if specular > 0.0 { table.lit(&um).ok()? } else { Vec::new() };
    let change = |lit: &Lit| {
        let last = lit.l_sky.len() - 1;
        let bin = (table.view.zenith_deg / 90.0 * lit.l_sky.len() as f64) as usize;
        let at = |bin: usize| lit.l_sky[bin.min(last)];
        let most = (at(bin) - at(bin + 1)).abs().max((at(bin) - at(bin.saturating_sub(1))).abs());
        specular * most / 2.0 / lit.l_blackbody
    };
    let error = lit.iter().map(change).filter(|error| error.is_finite()).max_by(f64::total_cmp)?;
    Some((table.view.zenith_deg, error))
}

/// The view's zenith angle, and half of what the reflectance of any facet by angle changes by within the bin of its
/// cosine, in the worst band.
fn grazing_bins(table: &Table, bands: &[Band]) -> Option<(f64, f64)> {
    let cosines = f64::from(table.histogram.kept.cosines);
    let bin = (table.view.zenith_deg.to_radians().cos() * cosines).floor().min(cosines - 1.0);
    let change = |spectrum: &Spectrum, um: f64| {
        let at = |edge: f64| spectrum.reflectance_at(um, edge / cosines).unwrap_or(0.0);
        (at(bin) - at(bin + 1.0)).abs() / 2.0
    };
    let angular = table.materials.iter().map(|m| &m.spectrum).filter(|s| s.is_angular());
    angular
        .flat_map(|spectrum| bands.iter().map(move |b| (spectrum, b.wavelength_um)))
        .map(|(spectrum, um)| change(spectrum, um))
        .max_by(f64::total_cmp)
        .map(|error| (table.view.zenith_deg, error))
}
