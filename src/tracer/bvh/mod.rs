//! Closest hits through two levels of bounding volumes: trees of eight-wide nodes over each mesh
//! and over the placed meshes.
//!
//! Single precision only culls: it leaves out boxes and triangles that the ray misses by more than
//! single precision can err. The rest is decided in double precision, in the mesh's coordinates. Of
//! two hits at the same distance the one of the lower number is taken. So the result is that of
//! testing every triangle in double precision, to the last bit. It does not depend on the trees,
//! the order of the walk or the machine's vector width.

// A function that is not inlined lacks the CPU features of its caller (`lanes`).
#![allow(clippy::inline_always)]

mod lanes;
mod search;
#[cfg(test)]
mod tests;
mod tree;
mod triangles;
mod walk;

use std::cell::RefCell;

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::{Bed, Mesh, Placement};
use search::{InBed, InMesh};
use tree::{Aabb, Tree, WIDTH};
use triangles::{Block, Ray};
use walk::Stack;

/// The two levels over all placed meshes of a bed.
pub struct Accelerator {
    meshes: Vec<MeshTree>,
    /// In the order of the top level's leaves.
    instances: Vec<Instance>,
    top: Tree,
    /// The origin of the top level.
    middle: DVec3,
    /// The greatest coordinate of its boxes.
    reach: f32,
    /// The most nodes on a walk's stack.
    stack: usize,
}

struct MeshTree {
    tree: Tree,
    blocks: Vec<Block>,
    reach: f32,
}

#[derive(Clone, Copy)]
struct Instance {
    placement: usize,
    mesh: usize,
    to_mesh: DAffine3,
    ball: Ball,
}

/// A sphere around a placed mesh: grains are rounder than boxes.
#[derive(Clone, Copy)]
struct Ball {
    centre: DVec3,
    radius_squared: f64,
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
    /// Its corners, as the mesh holds them.
    pub corners: [Vec3; 3],
    /// Weights of the second and third corner.
    pub weights: [f64; 2],
}

impl Hit {
    /// The start of a search: any hit up to `t_max` is nearer.
    const fn none(t_max: f64) -> Self {
        let (placement, triangle) = (usize::MAX, usize::MAX);
        Self { t: t_max, placement, triangle, corners: [Vec3::ZERO; 3], weights: [0.0; 2] }
    }

    fn found(self) -> Option<Self> {
        (self.placement != usize::MAX).then_some(self)
    }
}

thread_local! {
    /// The stack of a walk: one for each thread, so that no ray allocates one.
    static STACK: RefCell<(Vec<f32>, Vec<u32>)> = const { RefCell::new((Vec::new(), Vec::new())) };
}

/// Does work that needs a stack of this size.
#[inline(always)]
fn with_stack<T>(size: usize, work: impl FnOnce(Stack) -> T) -> T {
    STACK.with_borrow_mut(|stack| {
        let (near, children) = stack;
        if near.len() < size {
            near.resize(size, 0.0);
            children.resize(size, 0);
        }
        work(Stack { near, children })
    })
}

impl Accelerator {
    /// Builds both levels.
    pub fn new(bed: &Bed) -> Self {
        let meshes: Vec<MeshTree> = bed.meshes.par_iter().map(MeshTree::new).collect();
        let middle = (bed.domain.min_um + bed.domain.max_um) / 2.0;
        let (boxes, balls): (Vec<Aabb>, Vec<Ball>) = bed
            .placements
            .par_iter()
            .map(|placement| {
                let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
                let vertices = &bed.meshes[placement.mesh].vertices;
                let placed = |vertex: &Vec3| placement.to_scene.transform_point3(vertex.as_dvec3());
                for vertex in vertices {
                    let point = placed(vertex) - middle;
                    min = min.min(point);
                    max = max.max(point);
                }
                let centre = DVec3::midpoint(min, max) + middle;
                let from_centre = |vertex| placed(vertex).distance_squared(centre);
                let ball = Ball {
                    centre,
                    radius_squared: vertices.iter().map(from_centre).fold(0.0, f64::max),
                };
                // Rounded outward.
                let below = |x: f64| (x as f32).next_down();
                let above = |x: f64| (x as f32).next_up();
                let point = |p: DVec3, f: fn(f64) -> f32| glam::Vec3A::new(f(p.x), f(p.y), f(p.z));
                (Aabb::new(point(min, below), point(max, above)), ball)
            })
            .unzip();
        let reach =
            boxes.iter().map(|b| b.min.abs().max(b.max.abs()).max_element()).fold(0.0, f32::max);
        let mut instances = Vec::with_capacity(boxes.len());
        let top = Tree::new(&boxes, 1, |members| {
            instances.extend(members.iter().map(|&number| {
                let placement = number as usize;
                let Placement { mesh, to_scene } = bed.placements[placement];
                Instance { placement, mesh, to_mesh: to_scene.inverse(), ball: balls[placement] }
            }));
        });
        let below = meshes.iter().map(|mesh| mesh.tree.stack()).max().unwrap_or(0);
        let stack = top.stack() + below;
        Self { meshes, instances, top, middle, reach, stack }
    }

    /// One of the bed's meshes by itself.
    pub fn alone(&self, bed: &Bed, mesh: usize) -> Alone<'_> {
        let radius_um =
            bed.meshes[mesh].vertices.iter().map(|v| v.as_dvec3().length()).fold(0.0, f64::max);
        Alone { mesh: &self.meshes[mesh], radius_um }
    }

    /// The nearest hit within `t_max` um of `origin` along the unit vector `direction`.
    #[inline]
    pub fn closest(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
        self.search(origin, direction, t_max, false)
    }

    /// Whether there is a hit within `t_max` um of `origin` along the unit vector `direction`: less
    /// work than to find the nearest.
    #[inline]
    pub fn any(&self, origin: DVec3, direction: DVec3, t_max: f64) -> bool {
        self.search(origin, direction, t_max, true).is_some()
    }

    #[inline(always)]
    fn search(&self, origin: DVec3, direction: DVec3, t_max: f64, any: bool) -> Option<Hit> {
        with_stack(self.stack, |stack| {
            let search = InBed { accelerator: self, origin, direction, t_max, any, stack };
            lanes::with_best(search).found()
        })
    }
}

/// A mesh by itself, about its own middle.
pub struct Alone<'a> {
    mesh: &'a MeshTree,
    radius_um: f64,
}

impl Alone<'_> {
    /// Radius of the sphere about the origin that contains the mesh, um.
    pub fn radius_um(&self) -> f64 {
        self.radius_um
    }

    /// Number of the first triangle that a ray meets.
    pub fn closest(&self, origin: DVec3, direction: DVec3) -> Option<usize> {
        let (mesh, ray) = (self.mesh, Ray::new(origin, direction));
        let hit = with_stack(mesh.tree.stack(), |stack| {
            lanes::with_best(InMesh { mesh, ray, stack }).found()
        });
        hit.map(|hit| hit.triangle)
    }
}

impl MeshTree {
    fn new(mesh: &Mesh) -> Self {
        let corners =
            |number: u32| mesh.triangles[number as usize].map(|i| mesh.vertices[i as usize]);
        let boxes: Vec<Aabb> = (0..mesh.triangles.len() as u32)
            .map(|number| {
                let [a, b, c] = corners(number);
                Aabb::new(a.min(b).min(c).into(), a.max(b).max(c).into())
            })
            .collect();
        let mut blocks = Vec::new();
        let tree = Tree::new(&boxes, WIDTH, |members| blocks.push(Block::new(members, corners)));
        Self { tree, blocks, reach: mesh.extent_um() }
    }
}
