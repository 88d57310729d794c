//! Triangle meshes. Micrometres.

use std::collections::{BTreeMap, HashMap};

use glam::{DMat3, DVec3, Vec3};

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
    /// Whether every edge joins two triangles that run along it in opposite directions, and no part
    /// is a sheet of two sides. Such a mesh bounds a solid, and a ray that meets a triangle from
    /// behind is inside it.
    pub closed: bool,
    /// The middle of each connected part, um: each is a particle.
    pub particles: Vec<Vec3>,
    /// What may be wrong with it.
    pub quality: Quality,
}

/// What may be wrong with a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Quality {
    /// All edges.
    pub edges: usize,
    /// Edges along which the triangles do not run in opposite directions in pairs.
    pub open_edges: usize,
    /// Facets of the file that have an area.
    pub facets: usize,
    /// Facets that are lower than coordinates resolve, or not much higher.
    pub too_fine: usize,
    /// Rounding of the coordinates, um.
    pub rounding_um: f64,
    /// Mean of 1 - cos between facets and the normals in the file, weighted by area; 0 without
    /// normals.
    pub curved: f64,
}

/// Greatest rounding of a single, relative.
pub(crate) const SINGLE_ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// A facet this many times as high as the rounding of its coordinates faces the right way to about
/// a degree.
const LEAST_HEIGHT: f64 = 64.0;

impl Mesh {
    /// A mesh from points in um, and the position of its middle.
    ///
    /// Triangles without area are left out: no ray can meet them. A closed mesh that faces inward
    /// is turned outward.
    pub fn new(
        name: &str,
        points_um: &[DVec3],
        faces: impl Iterator<Item = ([u32; 3], u16)>,
    ) -> (Self, DVec3) {
        let min = points_um.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let max = points_um.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let middle = (min + max) / 2.0;
        let vertices: Vec<Vec3> = points_um.iter().map(|&p| (p - middle).as_vec3()).collect();
        let mut lost = 0;
        let (mut triangles, materials): (Vec<_>, Vec<_>) = faces
            .filter(|&(triangle, _)| {
                let has_area = cross(corners(&vertices, triangle)).length() > 0.0;
                let had_area = cross(triangle.map(|i| points_um[i as usize])).length() > 0.0;
                lost += usize::from(!has_area && had_area);
                has_area
            })
            .unzip();
        let distinct = distinct(&vertices);
        let uses = edges(&distinct, &triangles);
        let (edges, open_edges) = (uses.len(), uses.values().filter(|edge| edge.turn != 0).count());
        let roots = roots(&distinct, &triangles);
        let particles = particles(&roots, &vertices, &triangles);
        let closed = edges > 0
            && open_edges == 0
            && Body::of_each(&roots, &uses, &vertices, &triangles).all(|body| body.is_solid());
        let volume = |&triangle: &[u32; 3]| signed_volume(corners(&vertices, triangle));
        if closed && triangles.iter().map(volume).sum::<f64>() < 0.0 {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }
        let facets = triangles.len() + lost;
        let quality = Quality { edges, open_edges, facets, too_fine: lost, ..Quality::default() };
        let name = name.to_owned();
        let mut mesh = Self { name, vertices, triangles, materials, closed, particles, quality };
        mesh.set_rounding(f64::from(mesh.extent_um()) * SINGLE_ROUNDING);
        (mesh, middle)
    }

    /// Notes the rounding of the coordinates, um, unless a coarser one is known.
    pub(crate) fn set_rounding(&mut self, rounding_um: f64) {
        if rounding_um <= self.quality.rounding_um {
            return;
        }
        let is_too_fine = |triangle: &&[u32; 3]| {
            let [a, b, c] = corners(&self.vertices, **triangle);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            cross([a, b, c]).length() < LEAST_HEIGHT * rounding_um * longest
        };
        let lost = self.quality.facets - self.triangles.len();
        self.quality.too_fine = lost + self.triangles.iter().filter(is_too_fine).count();
        self.quality.rounding_um = rounding_um;
    }

    /// Volume, um3, and surface, um2, of the parts of each material as placed. An open mesh has
    /// none.
    pub(super) fn volumes_and_surfaces(&self, to_scene: DMat3) -> BTreeMap<u16, (f64, f64)> {
        let mut sums: BTreeMap<u16, (f64, f64)> = BTreeMap::new();
        let scale = to_scene.determinant().abs();
        let triangles = self.triangles.iter().zip(&self.materials).filter(|_| self.closed);
        for (&triangle, &material) in triangles {
            let corners = corners(&self.vertices, triangle);
            let sum = sums.entry(material).or_default();
            sum.0 += signed_volume(corners) * scale;
            sum.1 += cross(corners.map(|corner| to_scene * corner)).length() / 2.0;
        }
        sums
    }

    /// Finds the particles anew.
    pub(super) fn find_particles(&mut self) {
        let roots = roots(&distinct(&self.vertices), &self.triangles);
        self.particles = particles(&roots, &self.vertices, &self.triangles);
    }

    /// The greatest coordinate of any vertex, um. Rounding errors are relative to it.
    pub fn extent_um(&self) -> f32 {
        self.vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f32::max)
    }
}

/// A triangle's normal, twice as long as its area.
pub(crate) fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// How far the normals in a file turn away from its facets: mean of 1 - cos, weighted by area.
#[derive(Default)]
pub(super) struct Curvature {
    sum: f64,
    area: f64,
}

impl Curvature {
    /// Adds a facet, whose normal is as long as twice its area, and the normals at its corners.
    /// Those that are zero or not finite say nothing.
    pub(super) fn add(&mut self, facet: DVec3, normals: impl Iterator<Item = DVec3>) {
        let facet_normal = facet.normalize_or_zero();
        let cosine = |normal: DVec3| normal.dot(facet_normal).abs().min(1.0);
        let (mut sum, mut corners) = (0.0, 0.0);
        for normal in normals.filter_map(DVec3::try_normalize) {
            sum += 1.0 - cosine(normal);
            corners += 1.0;
        }
        if corners > 0.0 {
            self.sum += sum / corners * facet.length();
            self.area += facet.length();
        }
    }

    /// The mean; 0 of no facet.
    pub(super) fn mean(&self) -> f64 {
        if self.area > 0.0 { self.sum / self.area } else { 0.0 }
    }
}

pub(super) fn corners(vertices: &[Vec3], triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|i| vertices[i as usize].as_dvec3())
}

/// Volume of the tetrahedron between a triangle and the origin; negative if it faces the origin.
pub(super) fn signed_volume([a, b, c]: [DVec3; 3]) -> f64 {
    a.dot(b.cross(c)) / 6.0
}

/// For each vertex the first one at the same position: files often repeat vertices.
pub(super) fn distinct(vertices: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::new();
    let distinct = |(number, v): (usize, &Vec3)| {
        // Adding zero makes -0 equal to 0.
        let key = (*v + Vec3::ZERO).to_array().map(f32::to_bits);
        *first.entry(key).or_insert(number as u32)
    };
    vertices.iter().enumerate().map(distinct).collect()
}

/// A vertex for each vertex, the same for all of a connected part of a mesh.
pub(super) fn roots(distinct: &[u32], triangles: &[[u32; 3]]) -> Vec<u32> {
    // Union-find: each vertex points to another of its part; the root points to itself.
    let mut part: Vec<u32> = (0..distinct.len() as u32).collect();
    let root = |part: &mut [u32], mut at: u32| {
        while part[at as usize] != at {
            part[at as usize] = part[part[at as usize] as usize];
            at = part[at as usize];
        }
        at
    };
    for [a, b, c] in triangles.iter().map(|t| t.map(|i| distinct[i as usize])) {
        let a = root(&mut part, a);
        for other in [b, c] {
            let other = root(&mut part, other);
            part[other as usize] = a;
        }
    }
    distinct.iter().map(|&vertex| root(&mut part, vertex)).collect()
}

/// The middles of the connected parts of a mesh.
fn particles(roots: &[u32], vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut boxes: BTreeMap<u32, (Vec3, Vec3)> = BTreeMap::new();
    for &vertex in triangles.iter().flatten() {
        let at = vertices[vertex as usize];
        let (min, max) = boxes.entry(roots[vertex as usize]).or_insert((at, at));
        (*min, *max) = (min.min(at), max.max(at));
    }
    boxes.into_values().map(|(min, max)| (min + max) / 2.0).collect()
}

/// The triangles at an edge.
#[derive(Default)]
struct Edge {
    /// Those that run along it one way, less those that run the other way.
    turn: i32,
    triangles: u32,
}

/// The edges, by the vertices at their ends.
fn edges(distinct: &[u32], triangles: &[[u32; 3]]) -> HashMap<(u32, u32), Edge> {
    let mut edges: HashMap<(u32, u32), Edge> = HashMap::new();
    for triangle in triangles {
        for side in 0..3 {
            let a = distinct[triangle[side] as usize];
            let b = distinct[triangle[(side + 1) % 3] as usize];
            let edge = edges.entry((a.min(b), a.max(b))).or_default();
            edge.turn += if a < b { 1 } else { -1 };
            edge.triangles += 1;
        }
    }
    edges
}

/// A connected part of a mesh without open edges.
#[derive(Default)]
struct Body {
    volume: f64,
    area: f64,
    triangles: f64,
    edges: f64,
    /// Edges of four triangles or more.
    shared_edges: f64,
}

impl Body {
    fn of_each(
        roots: &[u32],
        edges: &HashMap<(u32, u32), Edge>,
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
    ) -> impl Iterator<Item = Self> {
        let mut bodies: HashMap<u32, Self> = HashMap::new();
        for &triangle in triangles {
            let body = bodies.entry(roots[triangle[0] as usize]).or_default();
            body.volume += signed_volume(corners(vertices, triangle));
            body.area += cross(corners(vertices, triangle)).length() / 2.0;
            body.triangles += 1.0;
        }
        for (&(vertex, _), edge) in edges {
            let body = bodies.entry(roots[vertex as usize]).or_default();
            body.edges += 1.0;
            body.shared_edges += f64::from(u8::from(edge.triangles > 3));
        }
        bodies.into_values()
    }

    /// Whether it holds a volume.
    ///
    /// A sheet drawn from both sides has none. Where its sides are cut into triangles along other
    /// diagonals, a little volume lies between them; but most edges are those of both sides.
    fn is_solid(&self) -> bool {
        let thickness = 2.0 * self.volume.abs() / self.area;
        let is_double = self.shared_edges > DOUBLE * self.edges;
        let least = if is_double { 0.05 * (self.area / self.triangles).sqrt() } else { 0.0 };
        thickness > least.max(1e-6 * self.area.sqrt())
    }
}

/// A share of edges with four triangles that solids, which touch themselves along few, do not have.
const DOUBLE: f64 = 0.15;

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

    /// A metre from the origin.
    fn mesh(faces: &[[u32; 3]]) -> Mesh {
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p + 1e6);
        Mesh::new("tetrahedron", &points, faces.iter().map(|&f| (f, 0))).0
    }

    #[test]
    fn a_mesh_is_closed_if_every_edge_has_two_sides_and_is_turned_outward() {
        let whole = mesh(&TETRAHEDRON);
        assert!(whole.closed && (whole.extent_um() - 0.5).abs() < 1e-6, "detail is kept");
        assert!(!mesh(&TETRAHEDRON[1..]).closed, "a face is missing");
        let mut turned = TETRAHEDRON;
        turned[0].swap(0, 1);
        assert!(!mesh(&turned).closed, "a face is turned over");
        let inward = mesh(&TETRAHEDRON.map(|[a, b, c]| [a, c, b]));
        let volume = inward.volumes_and_surfaces(DMat3::IDENTITY)[&0].0;
        assert!(inward.closed && (volume - 1.0 / 6.0).abs() < 1e-6);
    }

    #[test]
    fn volume_and_surface_are_those_of_a_body_as_it_is_placed() {
        let of = |placed: DMat3, points: [DVec3; 4]| {
            let mesh = Mesh::new("tetrahedron", &points, TETRAHEDRON.iter().map(|&f| (f, 0))).0;
            mesh.volumes_and_surfaces(placed)[&0]
        };
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let stretched = DMat3::from_diagonal(DVec3::new(100.0, -100.0, 1.0));
        let (placed, drawn) =
            (of(stretched, corners), of(DMat3::IDENTITY, corners.map(|p| stretched * p)));
        assert!((placed.0 / drawn.0 - 1.0).abs() < 1e-6 && (placed.1 / drawn.1 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn triangles_without_area_are_left_out() {
        assert_eq!(mesh(&[[0, 1, 2], [0, 1, 1], [2, 2, 2]]).triangles.len(), 1);
    }
}
