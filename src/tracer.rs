//! Backward paths from the sensor into counts of hits per material.
//!
//! Facets are opaque and Lambertian and directions are drawn by the cosine, so a path does not
//! depend on wavelength: one path serves every band.

use glam::DVec3;
use rayon::prelude::*;

use crate::bvh::{Accelerator, Hit};
use crate::error::Error;
use crate::geometry::{Bed, Domain};
use crate::interrupt;
use crate::random::{Purpose, Source, Stream};
use crate::scene::Sides;
use crate::tally::Tally;

/// Paths that one thread traces at a go. Fixed, so that the work is cut the same way for any number of
/// threads.
const BLOCK: u64 = 1024;

/// Reflections at the domain's mirror sides between two hits after which a path is given up as
/// trapped: a level ray through an empty gap could go on for ever.
const MOST_MIRRORS: u32 = 10_000;

/// By how much a ray's origin is lifted off its facet, as a share of the greatest coordinate: 256 times what
/// a double is rounded by. Hit points and their way from the mesh's coordinates into the scene's and into
/// another mesh's take some ten roundings, so that the origin is certainly on the outer side of the facet and
/// of those in its plane. For a bed one metre wide it is 3e-8 um.
const LIFT: f64 = 128.0 * f64::EPSILON;

/// A bed made ready for tracing.
pub struct Tracer {
    bed: Bed,
    accelerator: Accelerator,
    /// Distance by which a ray's origin is lifted off each placement's facets, um.
    lift_um: Vec<f64>,
    max_bounces: u16,
    footprint: Footprint,
}

/// The parallelogram from which the sensor's rays start.
pub(crate) struct Footprint {
    pub(crate) corner: DVec3,
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
}

impl Footprint {
    /// Within mirror sides the plan of the domain at its top: the bed goes on beyond it, so any part of
    /// its plan sees the same. In the open a rectangle across the line of sight that covers all of
    /// the domain's box, so that the target is seen whole from any side.
    pub(crate) fn new(domain: &Domain, to_sensor: DVec3) -> Self {
        let (min, max) = (domain.min_um, domain.max_um);
        let size = max - min;
        if domain.sides == Sides::Mirror {
            let corner = DVec3::new(min.x, min.y, max.z);
            return Self { corner, right: size.x * DVec3::X, up: size.y * DVec3::Y };
        }
        let level = DVec3::Z.cross(to_sensor);
        let right = if level.length() > 1e-9 { level.normalize() } else { DVec3::X };
        let up = to_sensor.cross(right);
        let middle = (min + max) / 2.0;
        // Half the extent of the box along a unit vector.
        let reach = |axis: DVec3| (size.dot(axis.abs())) / 2.0;
        let corner = middle + reach(to_sensor) * to_sensor - reach(right) * right - reach(up) * up;
        Self { corner, right: 2.0 * reach(right) * right, up: 2.0 * reach(up) * up }
    }

    fn at(&self, [u, v]: [f64; 2]) -> DVec3 {
        self.corner + u * self.right + v * self.up
    }
}

/// What became of a ray.
///
/// A ray is inside a solid if it meets a closed mesh from behind. The sensor is above everything, so that
/// comes only of solids that overlap, or of a hit so near to where two touch that the lifted origin is in
/// the other one.
enum Event {
    /// Of no mesh if it is the floor.
    Hit {
        mesh: Option<usize>,
        material: u16,
        point: DVec3,
        normal: DVec3,
    },
    Inside {
        mesh: usize,
    },
    Sky {
        downward: bool,
    },
    Lost,
}

impl Tracer {
    /// Builds the acceleration structure; a path that has hit `max_bounces` surfaces is given up as
    /// trapped.
    pub fn new(bed: Bed, max_bounces: u16) -> Self {
        let accelerator = Accelerator::new(&bed);
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
        let footprint = Footprint::new(&bed.domain, bed.to_sensor);
        Self { bed, accelerator, lift_um, max_bounces, footprint }
    }

    /// The bed that is traced.
    pub fn bed(&self) -> &Bed {
        &self.bed
    }

    /// The closest-hit structure.
    pub fn accelerator(&self) -> &Accelerator {
        &self.accelerator
    }

    /// Traces the paths of the numbers `first..first + paths`. `progress` is told how many paths
    /// were done, from any thread.
    pub fn trace(
        &self,
        seed: u64,
        purpose: Purpose,
        first: u64,
        paths: u64,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Tally, Error> {
        let source = Source::new(seed, purpose);
        let empty = || Tally::new(self.bed.materials);
        (0..paths.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                if interrupt::requested() {
                    return Err(Error::Interrupted);
                }
                let mut tally = empty();
                let start = first + block * BLOCK;
                let end = (start + BLOCK).min(first + paths);
                for number in start..end {
                    self.path(&mut source.path(number), &mut tally);
                }
                progress(end - start);
                Ok(tally)
            })
            .try_reduce(empty, |mut sum, part| {
                sum.add(&part);
                Ok(sum)
            })
    }

    /// One path, from the sensor until it leaves for the sky or is given up.
    fn path(&self, random: &mut Stream, tally: &mut Tally) {
        let mut origin = self.footprint.at(random.pair());
        let mut direction = -self.bed.to_sensor;
        let mut left = None;
        tally.begin();
        loop {
            match self.next(origin, direction) {
                Event::Sky { downward } => return tally.escaped(downward),
                Event::Lost => return tally.trapped(),
                Event::Inside { mesh } => return tally.buried(left, mesh),
                Event::Hit { mesh, material, point, normal } => {
                    left = mesh;
                    if tally.hit(material) >= self.max_bounces {
                        return tally.trapped();
                    }
                    origin = point;
                    direction = cosine_direction(normal, random.pair());
                }
            }
        }
    }

    /// Follows a ray to the next surface, through the mirrors at the domain's sides.
    fn next(&self, mut origin: DVec3, mut direction: DVec3) -> Event {
        for _ in 0..MOST_MIRRORS {
            let (t_exit, exit) = self.exit(origin, direction);
            if let Some(hit) = self.accelerator.closest(origin, direction, t_exit) {
                return self.at_mesh(&hit, direction);
            }
            origin += t_exit * direction;
            match exit {
                Exit::Sky => return Event::Sky { downward: direction.z < 0.0 },
                Exit::Floor(z_um, material) => {
                    // The floor is above everything below it by decree: no lift is needed to stay off it.
                    let point = DVec3::new(origin.x, origin.y, z_um);
                    let normal = if direction.z < 0.0 { DVec3::Z } else { -DVec3::Z };
                    return Event::Hit { mesh: None, material, point, normal };
                }
                Exit::Mirror { axis, at_um } => {
                    origin[axis] = at_um;
                    direction[axis] = -direction[axis];
                }
            }
        }
        Event::Lost
    }

    /// Where a ray that meets no mesh leaves the domain.
    fn exit(&self, origin: DVec3, direction: DVec3) -> (f64, Exit) {
        let Domain { min_um: min, max_um: max, sides, floor } = self.bed.domain;
        let mut nearest = (f64::INFINITY, Exit::Sky);
        if let Some((z_um, material)) = floor {
            let t = (z_um - origin.z) / direction.z;
            if t > 0.0 {
                nearest = (t, Exit::Floor(z_um, material));
            }
        }
        if sides == Sides::Mirror {
            for axis in 0..3 {
                if direction[axis] == 0.0 {
                    continue;
                }
                let at_um = if direction[axis] > 0.0 { max[axis] } else { min[axis] };
                let t = ((at_um - origin[axis]) / direction[axis]).max(0.0);
                if t < nearest.0 {
                    let exit = if axis == 2 { Exit::Sky } else { Exit::Mirror { axis, at_um } };
                    nearest = (t, exit);
                }
            }
        }
        nearest
    }

    /// The hit point, lifted off the surface, and the normal on the ray's side.
    fn at_mesh(&self, hit: &Hit, direction: DVec3) -> Event {
        let place = &self.bed.placements[hit.placement];
        let mesh = &self.bed.meshes[place.mesh];
        let [a, b, c] = mesh.triangles[hit.triangle].map(|i| mesh.vertices[i as usize].as_dvec3());
        let [v, w] = hit.weights;
        let point = place.to_scene.transform_point3(a + v * (b - a) + w * (c - a));
        let matrix = place.to_scene.matrix3;
        let (ab, ac) = (matrix * (b - a), matrix * (c - a));
        let cross = ab.cross(ac);
        let mirrored = matrix.determinant() < 0.0;
        let outward = cross.normalize() * if mirrored { -1.0 } else { 1.0 };
        let behind = outward.dot(direction) > 0.0;
        if behind && mesh.closed {
            return Event::Inside { mesh: place.mesh };
        }
        let normal = if behind { -outward } else { outward };
        // The narrower a triangle, the less certain is which way it faces.
        let narrow = ab.length() * ac.length() / cross.length();
        Event::Hit {
            mesh: Some(place.mesh),
            material: mesh.materials[hit.triangle],
            point: point + self.lift_um[hit.placement] * narrow * normal,
            normal,
        }
    }

    /// Width and height of the sensor's view, um.
    pub fn view_um(&self) -> [f64; 2] {
        [self.footprint.right.length(), self.footprint.up.length()]
    }

    /// What the sensor sees at a place of its view, 0 to 1 from the left and from below: the material
    /// and the cosine between the facet's normal and the direction to the sensor.
    pub fn look(&self, place: [f64; 2]) -> Option<(u16, f64)> {
        match self.next(self.footprint.at(place), -self.bed.to_sensor) {
            Event::Hit { material, normal, .. } => Some((material, normal.dot(self.bed.to_sensor))),
            Event::Sky { .. } | Event::Lost | Event::Inside { .. } => None,
        }
    }

    /// The mesh, unless it is the floor, and the material that the sensor sees at a place of its view.
    pub fn first(&self, place: [f64; 2]) -> Option<(Option<usize>, u16)> {
        match self.next(self.footprint.at(place), -self.bed.to_sensor) {
            Event::Hit { mesh, material, .. } => Some((mesh, material)),
            Event::Sky { .. } | Event::Lost | Event::Inside { .. } => None,
        }
    }
}

/// How a ray leaves the domain.
enum Exit {
    Sky,
    Floor(f64, u16),
    Mirror { axis: usize, at_um: f64 },
}

/// A direction about the normal with density cos / pi.
fn cosine_direction(normal: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
    let r = u.sqrt();
    // u < 1, so the direction never lies in the surface.
    (r * cos * tangent + r * sin * bitangent + (1.0 - u).sqrt() * normal).normalize()
}
