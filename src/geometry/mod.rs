//! Meshes, where they stand, and the part of the scene that the sensor sees. Micrometres.

pub mod cut;
pub mod ingest;
mod mesh;
mod parts;

use glam::{DAffine3, DVec3, Vec3};

use crate::scene::{Sides, View};
use crate::support::math;

pub use mesh::Mesh;
pub(crate) use mesh::cross;
pub use parts::Parts;

/// A mesh in its place.
#[derive(Debug, Clone)]
pub struct Placement {
    /// Index of the mesh.
    pub mesh: usize,
    /// From the mesh's coordinates to the scene's.
    pub to_scene: DAffine3,
}

/// The part of the scene that the sensor sees, and what bounds it.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain {
    /// Least x, y, z, um. Below it there is nothing.
    pub min_um: DVec3,
    /// Greatest x, y, z, um. Above it there is only sky.
    pub max_um: DVec3,
    /// What stands at the vertical sides.
    pub sides: Sides,
    /// Patches of a field along x and y; 1 and 1 without one.
    pub patches: [u32; 2],
    /// Height, um, and material of an opaque plane.
    pub floor: Option<(f64, u16)>,
}

/// All that the tracer needs to know of a scene.
#[derive(Debug, Clone)]
pub struct Bed {
    /// The distinct meshes.
    pub meshes: Vec<Mesh>,
    /// Where they stand.
    pub placements: Vec<Placement>,
    /// How many more were left out, since they stand exactly where another of the same mesh stands.
    pub repeated: usize,
    /// The part that the sensor sees.
    pub domain: Domain,
    /// Unit vector from the target to the sensor.
    pub to_sensor: DVec3,
    /// Number of materials of the scene.
    pub materials: usize,
}

impl Domain {
    /// A domain without floor and field.
    pub fn new(min_um: DVec3, max_um: DVec3, sides: Sides) -> Self {
        Self { min_um, max_um, sides, patches: [1, 1], floor: None }
    }
}

impl Placement {
    /// The corners of a triangle of its mesh in the scene, um.
    pub(crate) fn corners_um(&self, mesh: &Mesh, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|i| self.to_scene.transform_point3(mesh.vertices[i as usize].as_dvec3()))
    }

    /// -1 if the placement mirrors its mesh, so that triangles run clockwise seen from outside.
    pub(crate) fn handedness(&self) -> f64 {
        if self.to_scene.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 }
    }
}

impl Bed {
    /// The box around all placed meshes, um.
    pub fn bounds_um(meshes: &[Mesh], placements: &[Placement]) -> (DVec3, DVec3) {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for placement in placements {
            for vertex in &meshes[placement.mesh].vertices {
                let point = placement.to_scene.transform_point3(vertex.as_dvec3());
                min = min.min(point);
                max = max.max(point);
            }
        }
        (min, max)
    }

    /// Number of particles of the domain: those whose middle lies within its sides.
    pub fn particles(&self) -> u64 {
        let within = |place: &Placement| {
            let middles = self.meshes[place.mesh].particles.iter();
            let middle = |m: &Vec3| place.to_scene.transform_point3(m.as_dvec3()).truncate();
            let (min, max) = (self.domain.min_um.truncate(), self.domain.max_um.truncate());
            middles.map(middle).filter(|m| m.cmpge(min).all() && m.cmplt(max).all()).count()
        };
        self.placements.iter().map(|place| within(place) as u64).sum()
    }

    /// The mean chord of the particles of each material, um: 4 V / S of its closed meshes, exact
    /// for convex particles (Cauchy). `None` where a material has no closed mesh.
    pub fn mean_chords_um(&self) -> Vec<Option<f64>> {
        let mut sums = vec![(0.0, 0.0); self.materials];
        for place in &self.placements {
            let mesh = &self.meshes[place.mesh];
            for (material, (volume, surface)) in mesh.volumes_and_surfaces(place.to_scene.matrix3) {
                let sum: &mut (f64, f64) = &mut sums[usize::from(material)];
                sum.0 += volume;
                sum.1 += surface;
            }
        }
        sums.into_iter().map(|(v, s)| (v > 0.0).then(|| 4.0 * v / s)).collect()
    }

    /// Number of triangles without instances.
    pub fn triangles(&self) -> usize {
        self.placements.iter().map(|p| self.meshes[p.mesh].triangles.len()).sum()
    }
}

/// Unit vector to the sensor.
pub fn to_sensor(view: View) -> DVec3 {
    let (zenith, azimuth) = (view.zenith_deg.to_radians(), view.azimuth_deg.to_radians());
    let ((sin_z, cos_z), (sin_a, cos_a)) = (math::sin_cos(zenith), math::sin_cos(azimuth));
    DVec3::new(sin_z * cos_a, sin_z * sin_a, cos_z)
}

/// Most placements of a bed, and most triangles of a mesh: the tracer numbers them with 25 bits, the
/// triangles in blocks of four or more.
pub(crate) const MOST_PLACEMENTS: usize = (1 << 25) - 1;
pub(crate) const MOST_TRIANGLES: usize = 4 * MOST_PLACEMENTS;

/// Most patches of a field along a side: the random numbers that choose one have 24 bits.
pub(crate) const MOST_PATCHES: u32 = 1 << 16;

/// Patches along x and y of a field that has at least this many particles and is nearly square.
/// `None` if there would be too many patches, or the patch has no particle.
pub(crate) fn patches(bed: &Bed, particles: f64) -> Option<[u32; 2]> {
    let size = bed.domain.max_um - bed.domain.min_um;
    let wanted = (particles / bed.particles() as f64).ceil();
    let along_x = (wanted * size.y / size.x).sqrt().round().max(1.0);
    let along_y = (wanted / along_x).ceil();
    let fits = |number: f64| number <= f64::from(MOST_PATCHES);
    (fits(along_x) && fits(along_y)).then_some([along_x as u32, along_y as u32])
}
