//! Closest hits through two levels of bounding volumes: trees of eight-wide nodes over each mesh and over the
//! placed meshes.
//!
//! Precision. Single precision only culls: it leaves out boxes and triangles that the ray misses by more
//! than single precision can err. What is left is decided in double precision, in the coordinates of
//! the mesh, and of two hits at the same distance the one of the lower number is taken. So the result is that
//! of testing every triangle in double precision, to the last bit, whatever the trees, the order of
//! the walk and the machine's vectors.

// What is not inlined has not the machine's features of what it is called from (`lanes`).
#![allow(clippy::inline_always)]

mod lanes;
mod tree;
mod triangles;
mod walk;

use std::cell::RefCell;
use std::marker::PhantomData;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::{Bed, Mesh, Placement};
use lanes::{Lanes, Work};
use tree::{Aabb, Child, Tree, WIDTH};
use triangles::{Block, Cull, Ray};
use walk::{AtLeaf, Slabs, Stack, walk};

/// The two levels over all placed meshes of a bed.
pub struct Accelerator {
    meshes: Arc<[MeshTree]>,
    /// In the order of the top level's leaves.
    instances: Vec<Instance>,
    top: Tree,
    /// The top level is built about this point; the greatest coordinate of its boxes.
    middle: DVec3,
    reach: f32,
    /// The most nodes that a walk puts off.
    put_off: usize,
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

/// What holds all of a placed mesh: grains are rounder than boxes.
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
    /// What the search starts with: any hit up to `t_max` is nearer.
    const fn none(t_max: f64) -> Self {
        let (placement, triangle) = (usize::MAX, usize::MAX);
        Self { t: t_max, placement, triangle, corners: [Vec3::ZERO; 3], weights: [0.0; 2] }
    }

    fn found(self) -> Option<Self> {
        (self.placement != usize::MAX).then_some(self)
    }
}

thread_local! {
    /// Nodes that a walk puts off. One for each thread, so that no ray needs to allocate one.
    static STACK: RefCell<(Vec<f32>, Vec<u32>)> = const { RefCell::new((Vec::new(), Vec::new())) };
}

/// Does what needs a stack of that size.
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
        Self::over(meshes.into(), bed)
    }

    /// The same over other placements of the same meshes.
    #[must_use]
    pub fn of(&self, bed: &Bed) -> Self {
        Self::over(Arc::clone(&self.meshes), bed)
    }

    fn over(meshes: Arc<[MeshTree]>, bed: &Bed) -> Self {
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
                let number = number as usize;
                Instance::new(number, &bed.placements[number], balls[number])
            }));
        });
        let below = meshes.iter().map(|mesh| mesh.tree.put_off()).max().unwrap_or(0);
        let put_off = top.put_off() + below;
        Self { meshes, instances, top, middle, reach, put_off }
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
        with_stack(self.put_off, |stack| {
            let any = false;
            lanes::with_best(InBed { accelerator: self, origin, direction, t_max, any, stack })
                .found()
        })
    }

    /// Whether there is a hit within `t_max` um of `origin` along the unit vector `direction`: less work than to
    /// say where the nearest is.
    #[inline]
    pub fn any(&self, origin: DVec3, direction: DVec3, t_max: f64) -> bool {
        with_stack(self.put_off, |stack| {
            let any = true;
            lanes::with_best(InBed { accelerator: self, origin, direction, t_max, any, stack })
                .found()
                .is_some()
        })
    }
}

/// The search for the nearest hit of all placed meshes.
struct InBed<'a> {
    accelerator: &'a Accelerator,
    origin: DVec3,
    direction: DVec3,
    t_max: f64,
    /// Whether any hit will do.
    any: bool,
    stack: Stack<'a>,
}

impl Work for InBed<'_> {
    type Output = Hit;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Hit {
        let Self { accelerator, origin, direction, t_max, any, stack } = self;
        let mut best = Hit::none(t_max);
        let from_middle = origin - accelerator.middle;
        let reach = accelerator.reach.max(above(from_middle.abs().max_element()));
        let slabs = Slabs::<L>::new(from_middle, direction, reach);
        let lanes = PhantomData::<L>;
        let at = AtInstance { accelerator, origin, direction, any, best: &mut best, lanes };
        walk(&accelerator.top, &slabs, above(t_max), stack, at);
        best
    }
}

/// A leaf of the upper tree: looks for a hit on its mesh.
struct AtInstance<'a, L> {
    accelerator: &'a Accelerator,
    origin: DVec3,
    direction: DVec3,
    any: bool,
    best: &'a mut Hit,
    lanes: PhantomData<L>,
}

impl<L: Lanes> AtLeaf for AtInstance<'_, L> {
    #[inline(always)]
    fn meet(&mut self, leaf: Child, entered: f32, stack: Stack) -> f32 {
        let instance = &self.accelerator.instances[leaf.number()];
        if instance.ball.is_missed(self.origin, self.direction) {
            return above(self.best.t);
        }
        let ray = Ray::new(
            instance.to_mesh.transform_point3(self.origin),
            instance.to_mesh.transform_vector3(self.direction),
        );
        let mesh = &self.accelerator.meshes[instance.mesh];
        mesh.nearest::<L>(&ray, entered, instance.placement, self.any, self.best, stack);
        if self.any && self.best.placement != usize::MAX { END } else { above(self.best.t) }
    }
}

/// The search for the nearest hit of one mesh.
struct InMesh<'a> {
    mesh: &'a MeshTree,
    ray: Ray,
    stack: Stack<'a>,
}

impl Work for InMesh<'_> {
    type Output = Hit;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Hit {
        let mut best = Hit::none(f64::INFINITY);
        self.mesh.nearest::<L>(&self.ray, 0.0, 0, false, &mut best, self.stack);
        best
    }
}

/// A mesh by itself, about its own middle.
pub struct Alone<'a> {
    mesh: &'a MeshTree,
    radius_um: f64,
}

impl Alone<'_> {
    /// Radius of the sphere about the origin that holds the mesh, um.
    pub fn radius_um(&self) -> f64 {
        self.radius_um
    }

    /// Number of the first triangle that a ray meets.
    pub fn closest(&self, origin: DVec3, direction: DVec3) -> Option<usize> {
        let (mesh, ray) = (self.mesh, Ray::new(origin, direction));
        let hit = with_stack(mesh.tree.put_off(), |stack| {
            lanes::with_best(InMesh { mesh, ray, stack }).found()
        });
        hit.map(|hit| hit.triangle)
    }
}

/// Where a ray ends that need not go on: before every box.
const END: f32 = f32::NEG_INFINITY;

/// A single above a double, by two units of the last place at most.
#[inline(always)]
fn above(t: f64) -> f32 {
    let t = t as f32;
    t + (t.abs() * f32::EPSILON + f32::MIN_POSITIVE)
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

    /// Takes the nearest hit of a ray in this mesh's coordinates, if it is nearer than the best so far. The
    /// ray meets nothing before `start`.
    #[inline(always)]
    fn nearest<L: Lanes>(
        &self,
        ray: &Ray,
        start: f32,
        placement: usize,
        any: bool,
        best: &mut Hit,
        stack: Stack,
    ) {
        // Single precision is best near the mesh.
        let start = f64::from(start);
        let origin = ray.origin + start * ray.direction;
        let reach = self.reach.max(above(origin.abs().max_element()));
        let slabs = Slabs::<L>::new(origin, ray.direction, reach);
        let cull = Cull::<L>::new(ray, origin, reach);
        let t_max = above(best.t - start);
        let at = AtBlock { mesh: self, ray, cull, start, placement, any, best, t_max };
        walk(&self.tree, &slabs, t_max, stack, at);
    }
}

/// A leaf of a mesh's tree: looks for a hit on its triangles.
struct AtBlock<'a, L> {
    mesh: &'a MeshTree,
    ray: &'a Ray,
    cull: Cull<L>,
    start: f64,
    placement: usize,
    any: bool,
    best: &'a mut Hit,
    t_max: f32,
}

impl<L: Lanes> AtLeaf for AtBlock<'_, L> {
    #[inline(always)]
    fn meet(&mut self, leaf: Child, _: f32, _: Stack) -> f32 {
        let (placement, best) = (self.placement, &mut *self.best);
        let block = &self.mesh.blocks[leaf.number()];
        let mut met = self.cull.meet(block, leaf, self.t_max);
        while met != 0 {
            let slot = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            if let Some(met) = self.ray.meet(|corner, axis| block.coordinate(corner, axis, slot)) {
                let triangle = block.number(slot);
                let first = (placement, triangle) < (best.placement, best.triangle);
                if met.t < best.t || met.t == best.t && first {
                    let (t, corners, weights) = (met.t, block.corners(slot), met.weights());
                    *best = Hit { t, placement, triangle, corners, weights };
                    self.t_max = above(met.t - self.start);
                    if self.any {
                        return END;
                    }
                }
            }
        }
        self.t_max
    }
}

impl Instance {
    fn new(placement: usize, placed: &Placement, ball: Ball) -> Self {
        Self { placement, mesh: placed.mesh, to_mesh: placed.to_scene.inverse(), ball }
    }
}

impl Ball {
    /// Whether a ray misses it for certain, by more than double precision can err.
    #[inline(always)]
    fn is_missed(&self, origin: DVec3, direction: DVec3) -> bool {
        let to_centre = self.centre - origin;
        let (along, squared) = (to_centre.dot(direction), to_centre.length_squared());
        let rounding = 1e-12 * (squared + self.radius_squared + self.centre.length_squared());
        squared - along * along.max(0.0) > self.radius_squared + rounding
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Domain;
    use crate::scene::Sides;
    use crate::support::random::{Purpose, Source, Stream};
    use lanes::Portable;

    fn point(random: &mut Stream) -> DVec3 {
        let ([x, y], [z, _]) = (random.pair(), random.pair());
        DVec3::new(x, y, z) * 2.0 - 1.0
    }

    /// Soups of triangles, slivers and coplanar neighbours among them, scaled, turned and sheared.
    fn bed(random: &mut Stream, extent_um: f64) -> Bed {
        let meshes = (0..3).map(|number| {
            let count = [1, 70, 900][number];
            let mut points = Vec::new();
            for i in 0..count {
                let (at, size) = (point(random), 10_f64.powf(2.0 * random.pair()[0] - 2.5));
                let (b, c) = (at + size * point(random), at + size * point(random));
                points.extend([
                    at,
                    b,
                    if i % 5 == 0 { at + (b - at) * 1.001 + 1e-6 * c } else { c },
                ]);
                if i % 3 == 0 {
                    points.extend([c, b, b + c - at]);
                }
            }
            for p in &mut points {
                *p *= extent_um;
            }
            let faces = (0..points.len() as u32 / 3).map(|i| ([3 * i, 3 * i + 1, 3 * i + 2], 0));
            Mesh::new("soup", &points, faces).0
        });
        let meshes: Vec<Mesh> = meshes.collect();
        let placements = (0..40).map(|i| {
            let mut to_scene = DAffine3::from_scale_rotation_translation(
                DVec3::ONE + 0.5 * point(random),
                glam::DQuat::from_scaled_axis(3.0 * point(random)),
                2.0 * extent_um * point(random),
            );
            if i % 4 == 0 {
                to_scene.matrix3.x_axis *= -1.0;
            }
            Placement { mesh: i % 3, to_scene }
        });
        let domain = Domain {
            min_um: DVec3::splat(-extent_um),
            max_um: DVec3::splat(extent_um),
            sides: Sides::Open,
            patches: [1, 1],
            floor: None,
        };
        let placements = placements.collect();
        Bed { meshes, placements, domain, to_sensor: DVec3::Z, materials: 1 }
    }

    /// Every triangle of every placement, in double precision.
    fn every(bed: &Bed, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
        let mut best = Hit::none(t_max);
        for (placement, place) in bed.placements.iter().enumerate() {
            let to_mesh = place.to_scene.inverse();
            let ray =
                Ray::new(to_mesh.transform_point3(origin), to_mesh.transform_vector3(direction));
            let mesh = &bed.meshes[place.mesh];
            for (triangle, corners) in mesh.triangles.iter().enumerate() {
                let corners = corners.map(|i| mesh.vertices[i as usize]);
                let met = ray.meet(|corner, axis| corners[corner][axis].into());
                if let Some(met) = met.filter(|met| met.t < best.t) {
                    let (t, weights) = (met.t, met.weights());
                    best = Hit { t, placement, triangle, corners, weights };
                }
            }
        }
        best.found()
    }

    #[test]
    fn the_walk_finds_to_the_last_bit_what_testing_every_triangle_finds() {
        for (number, extent_um) in [1e-3, 300.0, 1e6].into_iter().enumerate() {
            let mut random = Source::new(5, Purpose::Result).stream(number as u64);
            let bed = bed(&mut random, extent_um);
            let accelerator = Accelerator::new(&bed);
            let (mut hits, mut near) = (0, None);
            for i in 0..3000 {
                let random = &mut random;
                let mut direction = point(random).normalize();
                let origin = match (i % 4, near) {
                    // On a facet, as after a hit.
                    (1 | 2, Some(on)) => on,
                    // From far away, and along an axis.
                    (3, _) => {
                        direction = [DVec3::X, DVec3::Y, -DVec3::Z][i / 4 % 3];
                        extent_um * (point(random) - 1000.0 * direction)
                    }
                    _ => 2.0 * extent_um * point(random),
                };
                if i % 2 == 0 {
                    // At an edge, or at a corner: which side of it the ray passes is for doubles to say.
                    let place = &bed.placements[(random.pair()[0] * 40.0) as usize];
                    let mesh = &bed.meshes[place.mesh];
                    let number = (random.pair()[0] * mesh.triangles.len() as f64) as usize;
                    let [a, b, _] =
                        mesh.triangles[number].map(|i| mesh.vertices[i as usize].as_dvec3());
                    let share = if i % 8 == 0 { 0.0 } else { random.pair()[0] };
                    let at = place.to_scene.transform_point3(a.lerp(b, share));
                    direction = (at - origin).normalize();
                }
                let t_max = if i % 5 == 0 { extent_um } else { f64::INFINITY };
                let found = accelerator.closest(origin, direction, t_max);
                let expected = every(&bed, origin, direction, t_max);
                assert_eq!(found, expected, "ray {i} in {extent_um} um");
                for any in [false, true] {
                    let found = with_stack(accelerator.put_off, |stack| {
                        let accelerator = &accelerator;
                        let search = InBed { accelerator, origin, direction, t_max, any, stack };
                        search.run::<Portable>().found()
                    });
                    if any {
                        assert_eq!(found.is_some(), expected.is_some(), "any, without vectors");
                    } else {
                        assert_eq!(found, expected, "without vectors");
                    }
                }
                let any = accelerator.any(origin, direction, t_max);
                assert_eq!(any, expected.is_some(), "any of ray {i} in {extent_um} um");
                hits += usize::from(found.is_some());
                near = found.map(|hit| origin + hit.t * direction).or(near);
            }
            assert!(hits > 1000, "{hits} hits tell little");
        }
    }
}
