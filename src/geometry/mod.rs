//! Meshes, where they stand, and the part of the scene that is looked at. Micrometres.

pub mod cut;
pub mod ingest;

use std::collections::{BTreeMap, HashMap};

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::scene::{Sides, View};

/// A triangle mesh about its own origin.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// The prototype's name.
    pub name: String,
    /// Vertices, um, relative to the middle of the mesh, so that single precision keeps its detail
    /// wherever the mesh stands.
    pub vertices: Vec<Vec3>,
    /// Vertex indices of each triangle; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index of each triangle's material in the scene's list.
    pub materials: Vec<u16>,
    /// Whether every edge joins two triangles that run along it in opposite directions: then the mesh
    /// bounds a solid, and a ray that meets a triangle from behind is inside it.
    pub closed: bool,
    /// The middle of each connected part, um: each is a particle.
    pub particles: Vec<Vec3>,
    /// What of it may not be as it was meant.
    pub doubts: Doubts,
}

/// What of a mesh may not be as it was meant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Doubts {
    /// Edges, and those among them along which as many facets do not run one way as the other.
    pub edges: usize,
    /// The latter.
    pub open_edges: usize,
    /// Facets of the file that have an area.
    pub facets: usize,
    /// Those of them whose height is lost in rounding, or is not far above it.
    pub too_fine: usize,
    /// What coordinates are rounded by, um.
    pub rounding_um: f64,
    /// Mean, by area, of 1 - cos between facets and the normals that the file gives for them; 0 if it gives none.
    pub curved: f64,
}

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
    /// Greatest x, y, z, um. Above it there is nothing but sky.
    pub max_um: DVec3,
    /// What stands at the vertical sides.
    pub sides: Sides,
    /// Patches of a field along x and y, 1 and 1 without one.
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
    /// What is looked at.
    pub domain: Domain,
    /// Unit vector from the target to the sensor.
    pub to_sensor: DVec3,
    /// How many materials the scene has.
    pub materials: usize,
}

impl Mesh {
    /// A mesh from points in um in any place; returns the place of its middle as well. Triangles
    /// without area are left out: no ray can meet them. A closed mesh that faces inward is turned over.
    pub fn new(
        name: &str,
        points_um: &[DVec3],
        faces: impl Iterator<Item = ([u32; 3], u16)>,
    ) -> (Self, DVec3) {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &point in points_um {
            min = min.min(point);
            max = max.max(point);
        }
        let middle = if points_um.is_empty() { DVec3::ZERO } else { (min + max) / 2.0 };
        let vertices: Vec<Vec3> = points_um.iter().map(|&p| (p - middle).as_vec3()).collect();
        let mut lost = 0;
        let (triangles, materials): (Vec<_>, Vec<_>) = faces
            .filter(|&(triangle, _)| {
                let is_met = area(triangle.map(|i| vertices[i as usize].as_dvec3())) > 0.0;
                lost += usize::from(!is_met && area(triangle.map(|i| points_um[i as usize])) > 0.0);
                is_met
            })
            .unzip();
        let place = places(&vertices);
        let (edges, open_edges) = edges(&place, &triangles);
        let closed = edges > 0 && open_edges == 0;
        let particles = particles(&place, &vertices, &triangles);
        let mut triangles = triangles;
        if closed && volume(&vertices, &triangles) < 0.0 {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }
        let facets = triangles.len() + lost;
        let doubts = Doubts { edges, open_edges, facets, too_fine: lost, ..Doubts::default() };
        let name = name.to_owned();
        let mut mesh = Self { name, vertices, triangles, materials, closed, particles, doubts };
        mesh.known_to(f64::from(mesh.extent_um()) * HALF_A_PLACE);
        (mesh, middle)
    }

    /// Notes that coordinates are known no better than to this, um: a facet that is not much higher may face anywhere.
    pub(crate) fn known_to(&mut self, rounding_um: f64) {
        if rounding_um <= self.doubts.rounding_um {
            return;
        }
        let is_too_fine = |triangle: &&[u32; 3]| {
            let corners = triangle.map(|i| self.vertices[i as usize].as_dvec3());
            let [a, b, c] = corners;
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            2.0 * area(corners) < SURE * rounding_um * longest
        };
        let lost = self.doubts.facets - self.triangles.len();
        self.doubts.too_fine = lost + self.triangles.iter().filter(is_too_fine).count();
        self.doubts.rounding_um = rounding_um;
    }

    /// Volume, um3, and surface, um2, of the parts of each material as they are placed; of an open mesh nothing.
    fn volumes_and_surfaces(&self, to_scene: DMat3) -> BTreeMap<u16, (f64, f64)> {
        let mut sums: BTreeMap<u16, (f64, f64)> = BTreeMap::new();
        let scale = to_scene.determinant().abs();
        let triangles = self.triangles.iter().zip(&self.materials).filter(|_| self.closed);
        for (&triangle, &material) in triangles {
            let corners = corners(&self.vertices, triangle);
            let sum = sums.entry(material).or_default();
            sum.0 += volume_below(corners) * scale;
            sum.1 += area(corners.map(|corner| to_scene * corner));
        }
        sums
    }

    /// The greatest coordinate of any vertex, um: what rounding errors are measured by.
    pub fn extent_um(&self) -> f32 {
        self.vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f32::max)
    }
}

/// What a single is rounded by at most, as a share of it.
pub(crate) const HALF_A_PLACE: f64 = 1.0 / (1 << 24) as f64;

/// A facet so many times as high as what coordinates are rounded by faces where it should to a degree.
const SURE: f64 = 64.0;

fn area([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length() / 2.0
}

/// How far the normals that a file gives for a facet's corners turn away from it: the mean of 1 - cos, and the facet's
/// area as its weight; `facet` is its normal, as long as its area.
pub(crate) fn turned_away(facet: DVec3, normals: &[DVec3]) -> (f64, f64) {
    let cosine =
        |normal: &DVec3| (normal.normalize_or_zero().dot(facet.normalize_or_zero())).abs().min(1.0);
    let mean =
        normals.iter().map(|normal| 1.0 - cosine(normal)).sum::<f64>() / normals.len() as f64;
    (mean * facet.length(), facet.length())
}

/// Volume within a closed mesh, um3; negative if its triangles face inward.
fn volume(vertices: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    triangles.iter().map(|&triangle| volume_below(corners(vertices, triangle))).sum()
}

fn corners(vertices: &[Vec3], triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|i| vertices[i as usize].as_dvec3())
}

/// Volume of the tetrahedron between a triangle and the origin, with its sign.
fn volume_below([a, b, c]: [DVec3; 3]) -> f64 {
    a.dot(b.cross(c)) / 6.0
}

/// Of each vertex the first that is in the same place: files often repeat vertices.
fn places(vertices: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::new();
    let place = |(number, v): (usize, &Vec3)| {
        // Adding zero makes -0 and 0 one place.
        let key = (*v + Vec3::ZERO).to_array().map(f32::to_bits);
        *first.entry(key).or_insert(number as u32)
    };
    vertices.iter().enumerate().map(place).collect()
}

/// The middles of the parts of a mesh that hang together.
fn particles(place: &[u32], vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    // Each place points to another of its part, and the one that points to itself stands for the part.
    let mut part: Vec<u32> = (0..place.len() as u32).collect();
    let root = |part: &mut [u32], mut at: u32| {
        while part[at as usize] != at {
            part[at as usize] = part[part[at as usize] as usize];
            at = part[at as usize];
        }
        at
    };
    for [a, b, c] in triangles.iter().map(|t| t.map(|i| place[i as usize])) {
        let a = root(&mut part, a);
        for other in [b, c] {
            let other = root(&mut part, other);
            part[other as usize] = a;
        }
    }
    let mut boxes: BTreeMap<u32, (Vec3, Vec3)> = BTreeMap::new();
    for &vertex in triangles.iter().flatten() {
        let at = vertices[vertex as usize];
        let (min, max) = boxes.entry(root(&mut part, place[vertex as usize])).or_insert((at, at));
        (*min, *max) = (min.min(at), max.max(at));
    }
    boxes.into_values().map(|(min, max)| (min + max) / 2.0).collect()
}

/// How many edges there are, and along how many of them as many triangles do not run one way as the other.
fn edges(place: &[u32], triangles: &[[u32; 3]]) -> (usize, usize) {
    let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
    for triangle in triangles {
        for side in 0..3 {
            let a = place[triangle[side] as usize];
            let b = place[triangle[(side + 1) % 3] as usize];
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    (balance.len(), balance.values().filter(|&&sum| sum != 0).count())
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

    /// The bed without so many of its lowest placements, by their middles; a dusty grain is one.
    #[must_use]
    pub fn without_lowest(&self, number: usize) -> Self {
        let mut placements = self.placements.clone();
        let height = |place: &Placement| place.to_scene.translation.z;
        placements.sort_by(|a, b| height(a).total_cmp(&height(b)));
        placements.drain(..number.min(placements.len()));
        Self { placements, ..self.clone() }
    }

    /// How many particles the domain has: those whose middle lies within its sides.
    pub fn particles(&self) -> u64 {
        let within = |place: &Placement| {
            let middles = self.meshes[place.mesh].particles.iter();
            let middle = |m: &Vec3| place.to_scene.transform_point3(m.as_dvec3()).truncate();
            let (min, max) = (self.domain.min_um.truncate(), self.domain.max_um.truncate());
            middles.map(middle).filter(|m| m.cmpge(min).all() && m.cmplt(max).all()).count()
        };
        self.placements.iter().map(|place| within(place) as u64).sum()
    }

    /// The mean chord of the particles of each material, um, by lines from all sides: 4 V / S of what its closed meshes
    /// hold, exact for convex particles (Cauchy). `None` where a material has no closed mesh.
    pub fn mean_chords_um(&self) -> Vec<Option<f64>> {
        let mut sums = vec![(0.0, 0.0); self.materials];
        for place in &self.placements {
            let mesh = &self.meshes[place.mesh];
            // Parts of other materials stand beside, not within: of each the volume is that within its own triangles.
            for (material, (volume, surface)) in mesh.volumes_and_surfaces(place.to_scene.matrix3) {
                let sum: &mut (f64, f64) = &mut sums[usize::from(material)];
                sum.0 += volume;
                sum.1 += surface;
            }
        }
        sums.into_iter().map(|(v, s)| (v > 0.0).then(|| 4.0 * v / s)).collect()
    }

    /// How many triangles the scene would have without instances.
    pub fn triangles(&self) -> usize {
        self.placements.iter().map(|p| self.meshes[p.mesh].triangles.len()).sum()
    }
}

/// Unit vector to the sensor.
pub fn to_sensor(view: View) -> DVec3 {
    let (zenith, azimuth) = (view.zenith_deg.to_radians(), view.azimuth_deg.to_radians());
    DVec3::new(zenith.sin() * azimuth.cos(), zenith.sin() * azimuth.sin(), zenith.cos())
}

/// Most patches of a field along a side: the random numbers that choose one have 24 bits.
pub(crate) const MOST_PATCHES: u32 = 1 << 16;

/// Patches along x and y of a field that has at least so many particles and is as near to a square as it can
/// be; `None` if they are too many, or the patch has none.
pub(crate) fn patches(bed: &Bed, particles: f64) -> Option<[u32; 2]> {
    let size = bed.domain.max_um - bed.domain.min_um;
    let wanted = (particles / bed.particles() as f64).ceil();
    let along_x = (wanted * size.y / size.x).sqrt().round().max(1.0);
    let along_y = (wanted / along_x).ceil();
    let fits = |number: f64| number <= f64::from(MOST_PATCHES);
    (fits(along_x) && fits(along_y)).then_some([along_x as u32, along_y as u32])
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

    fn mesh(faces: &[[u32; 3]]) -> Mesh {
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p + 1e6);
        Mesh::new("tetrahedron", &points, faces.iter().map(|&f| (f, 0))).0
    }

    #[test]
    fn a_mesh_is_closed_only_if_every_edge_has_two_sides() {
        assert!(mesh(&TETRAHEDRON).closed);
        assert!(!mesh(&TETRAHEDRON[1..]).closed, "a face is missing");
        let mut turned = TETRAHEDRON;
        turned[0].swap(0, 1);
        assert!(!mesh(&turned).closed, "a face is turned over");
    }

    #[test]
    fn a_closed_mesh_that_faces_inward_is_turned_outward() {
        let inward = TETRAHEDRON.map(|[a, b, c]| [a, c, b]);
        let mesh = mesh(&inward);
        assert!(mesh.closed && volume(&mesh.vertices, &mesh.triangles) > 0.0);
    }

    #[test]
    fn the_mean_chord_is_that_of_a_body_as_it_is_placed() {
        let chord = |placed: DMat3, points: [DVec3; 4]| {
            let mesh = Mesh::new("tetrahedron", &points, TETRAHEDRON.iter().map(|&f| (f, 0))).0;
            let volume: f64 = mesh.volumes_and_surfaces(placed).values().map(|of| of.0).sum();
            let surface: f64 = mesh.volumes_and_surfaces(placed).values().map(|of| of.1).sum();
            4.0 * volume / surface
        };
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let stretched = DMat3::from_diagonal(DVec3::new(100.0, -100.0, 1.0));
        let drawn = chord(DMat3::IDENTITY, corners.map(|p| stretched * p));
        assert!((chord(stretched, corners) / drawn - 1.0).abs() < 1e-6);
    }

    #[test]
    fn triangles_without_area_are_left_out() {
        assert_eq!(mesh(&[[0, 1, 2], [0, 1, 1], [2, 2, 2]]).triangles.len(), 1);
    }

    #[test]
    fn detail_is_kept_a_metre_away_from_the_origin() {
        let mesh = mesh(&TETRAHEDRON);
        assert!((mesh.extent_um() - 0.5).abs() < 1e-6);
    }
}
