//! Closest hits through two levels of bounding volumes: the one place that speaks to obvhs.
//!
//! obvhs builds a binary tree over each mesh and one over the placed meshes; the walk from the one
//! into the other is here. Its compressed wide tree is not used: it loses every hit nearer than
//! 1e-4 in units of the ray's parameter.
//!
//! Precision. A ray is held in double precision in the scene. Before it enters a mesh it is
//! moved to where it meets the mesh's bounding sphere and only then turned into the mesh's own
//! coordinates in single precision, so that its rounding is that of the mesh's size, not of the
//! scene's. All boxes are widened by [`ROUNDING`] of the size of what they belong to, which covers
//! the rounding of the box tests.

use std::time::Duration;

use glam::{DAffine3, DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2, node::Bvh2Node};
use obvhs::fast_stack;
use obvhs::ray::{Ray, RayHit};
use rayon::prelude::*;

use crate::geometry::{Bed, Mesh, Placement};

/// Sixteen units in the last place of a single-precision coordinate: a ray in a mesh's coordinates, the
/// box tests and the triangle test each err by a few of them.
pub const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// The two levels over all placed meshes of a bed.
pub struct Accelerator {
    meshes: Vec<MeshTree>,
    instances: Vec<Instance>,
    top: Bvh2,
    /// The top level is built about this point.
    middle: DVec3,
}

struct MeshTree {
    tree: Bvh2,
    /// Corners of the triangles in the tree's order, and their numbers in the mesh.
    corners: Vec<[Vec3A; 3]>,
    numbers: Vec<u32>,
}

struct Instance {
    mesh: usize,
    to_mesh: DAffine3,
    /// Bounding sphere in the scene.
    centre: DVec3,
    radius: f64,
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the ray, um.
    pub t: f64,
    /// Number of the placement.
    pub placement: usize,
    /// Number of the triangle in its mesh.
    pub triangle: usize,
    /// Weights of the triangle's second and third corner.
    pub weights: [f32; 2],
}

impl Accelerator {
    /// Builds both levels.
    pub fn new(bed: &Bed) -> Self {
        let meshes: Vec<MeshTree> = bed.meshes.par_iter().map(MeshTree::new).collect();
        let instances: Vec<Instance> =
            bed.placements.iter().map(|p| Instance::new(p, &bed.meshes[p.mesh])).collect();
        let middle = (bed.domain.min_um + bed.domain.max_um) / 2.0;
        let size = instances
            .iter()
            .map(|i| (i.centre - middle).abs().max_element() + i.radius)
            .fold(0.0, f64::max);
        let boxes: Vec<Aabb> = instances
            .iter()
            .map(|i| {
                let room = DVec3::splat(i.radius + size * ROUNDING);
                let centre = i.centre - middle;
                Aabb::new((centre - room).as_vec3a(), (centre + room).as_vec3a())
            })
            .collect();
        Self { meshes, instances, top: build(&boxes, 1), middle }
    }

    /// One of the bed's meshes by itself.
    pub fn alone(&self, bed: &Bed, mesh: usize) -> Alone<'_> {
        let unmoved = Placement { mesh, to_scene: DAffine3::IDENTITY };
        Alone { mesh: &self.meshes[mesh], instance: Instance::new(&unmoved, &bed.meshes[mesh]) }
    }

    /// The nearest hit within `t_max` um of `origin` along the unit vector `direction`.
    #[inline]
    pub fn closest(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut nearest = t_max;
        let ray =
            Ray::new((origin - self.middle).as_vec3a(), direction.as_vec3a(), 0.0, above(t_max));
        walk(&self.top, ray, |node, ray| {
            let number = self.top.primitive_indices[node.first_index as usize] as usize;
            let instance = &self.instances[number];
            if let Some((t, triangle, weights)) =
                instance.closest(&self.meshes[instance.mesh], origin, direction, nearest)
            {
                nearest = t;
                ray.tmax = above(t);
                best = Some(Hit { t, placement: number, triangle, weights });
            }
        });
        best
    }
}

/// A mesh by itself, about its own middle.
pub struct Alone<'a> {
    mesh: &'a MeshTree,
    instance: Instance,
}

impl Alone<'_> {
    /// Radius of the sphere about the origin that holds the mesh, um.
    pub fn radius_um(&self) -> f64 {
        self.instance.radius
    }

    /// Number of the first triangle that a ray meets.
    pub fn closest(&self, origin: DVec3, direction: DVec3) -> Option<usize> {
        let hit = self.instance.closest(self.mesh, origin, direction, f64::INFINITY);
        hit.map(|(_, triangle, _)| triangle)
    }
}

/// The least single above a double.
fn above(t: f64) -> f32 {
    (t as f32).next_up()
}

fn build(boxes: &[Aabb], per_leaf: u32) -> Bvh2 {
    let settings =
        BvhBuildParams { max_prims_per_leaf: per_leaf, ..BvhBuildParams::medium_build() };
    build_bvh2(boxes, settings, &mut Duration::default())
}

/// Calls `leaf` for the leaves that the ray meets, nearer ones first; `leaf` may shorten the ray.
#[inline]
fn walk(tree: &Bvh2, ray: Ray, mut leaf: impl FnMut(&Bvh2Node, &mut Ray)) {
    let mut visit = |node: &Bvh2Node, ray: &mut Ray, _: &mut RayHit| {
        leaf(node, ray);
        true
    };
    fast_stack!(u32, (96, 192), tree.max_depth, stack, {
        tree.ray_traverse_dynamic(&mut stack, ray, &mut RayHit::none(), &mut visit);
    });
}

impl MeshTree {
    fn new(mesh: &Mesh) -> Self {
        let room = Vec3A::splat(mesh.extent_um() * ROUNDING as f32);
        let corners = |number: u32| {
            mesh.triangles[number as usize].map(|i| Vec3A::from(mesh.vertices[i as usize]))
        };
        let boxes: Vec<Aabb> = (0..mesh.triangles.len() as u32)
            .map(|number| {
                let [a, b, c] = corners(number);
                Aabb::new(a.min(b).min(c) - room, a.max(b).max(c) + room)
            })
            .collect();
        let tree = build(&boxes, 4);
        let numbers = tree.primitive_indices.clone();
        Self { tree, corners: numbers.iter().map(|&n| corners(n)).collect(), numbers }
    }
}

impl Instance {
    fn new(placement: &Placement, mesh: &Mesh) -> Self {
        let to_scene = placement.to_scene;
        let centre = to_scene.translation;
        let radius = mesh
            .vertices
            .iter()
            .map(|v| (to_scene.matrix3 * v.as_dvec3()).length_squared())
            .fold(0.0, f64::max)
            .sqrt();
        Self {
            mesh: placement.mesh,
            to_mesh: to_scene.inverse(),
            centre,
            radius: radius * (1.0 + ROUNDING),
        }
    }

    #[inline]
    fn closest(
        &self,
        mesh: &MeshTree,
        origin: DVec3,
        direction: DVec3,
        nearest: f64,
    ) -> Option<(f64, usize, [f32; 2])> {
        // The sphere first: it is cheap, turns most rays away, and tells where to start.
        let to_centre = self.centre - origin;
        let along = to_centre.dot(direction);
        let half_chord_squared =
            self.radius * self.radius - (to_centre - along * direction).length_squared();
        if half_chord_squared < 0.0 {
            return None;
        }
        let half_chord = half_chord_squared.sqrt();
        let start = (along - half_chord).max(0.0);
        if along + half_chord < 0.0 || start > nearest {
            return None;
        }
        let local_origin = self.to_mesh.transform_point3(origin + start * direction);
        let local_direction = self.to_mesh.matrix3 * direction;
        let length = local_direction.length();
        let ray = Ray::new(
            local_origin.as_vec3a(),
            (local_direction / length).as_vec3a(),
            0.0,
            above((nearest - start) * length),
        );
        let shear = Shear::new(ray.direction);
        let mut best = None;
        walk(&mesh.tree, ray, |node, ray| {
            for number in node.first_index..node.first_index + node.prim_count {
                let corners = &mesh.corners[number as usize];
                if let Some((t, weights)) = shear.meet(corners, ray.origin, ray.tmax) {
                    ray.tmax = t;
                    best = Some((t, number, weights));
                }
            }
        });
        let (t, number, weights) = best?;
        let t = start + f64::from(t) / length;
        (t <= nearest).then(|| (t, mesh.numbers[number as usize] as usize, weights))
    }
}

/// A ray's direction as a shear that turns it into the z axis: the watertight triangle test of
/// Woop, Benthin and Wald (J. Comput. Graph. Tech. 2(1), 2013). No ray passes between two
/// triangles that share an edge.
struct Shear {
    axes: [usize; 3],
    factors: Vec3,
}

impl Shear {
    fn new(direction: Vec3A) -> Self {
        let z = direction.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            (x, y) = (y, x);
        }
        let scale = 1.0 / direction[z];
        Self {
            axes: [x, y, z],
            factors: Vec3::new(direction[x] * scale, direction[y] * scale, scale),
        }
    }

    /// Distance and weights of the second and third corner, if the ray meets the triangle, from
    /// either side, at 0 or further and nearer than `t_max`.
    #[inline]
    fn meet(&self, corners: &[Vec3A; 3], origin: Vec3A, t_max: f32) -> Option<(f32, [f32; 2])> {
        let [x, y, z] = self.axes;
        let s = self.factors;
        let [a, b, c] = corners.map(|corner| {
            let p = corner - origin;
            [p[x] - s.x * p[z], p[y] - s.y * p[z], s.z * p[z]]
        });
        let side = |p: [f32; 3], q: [f32; 3]| p[0] * q[1] - p[1] * q[0];
        let (mut u, mut v, mut w) = (side(c, b), side(a, c), side(b, a));
        if u == 0.0 || v == 0.0 || w == 0.0 {
            // On an edge, as far as single precision can tell: let double precision decide.
            let exact = |p: [f32; 3], q: [f32; 3]| {
                (f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0])) as f32
            };
            (u, v, w) = (exact(c, b), exact(a, c), exact(b, a));
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / sum;
        (t >= 0.0 && t < t_max).then(|| (t, [v / sum, w / sum]))
    }
}
