//! The search for the nearest hit, or any: over the placed meshes, and over the triangles of each.

use std::marker::PhantomData;

use glam::DVec3;

use super::lanes::{Lanes, Work};
use super::tree::{Child, WIDTH};
use super::triangles::{Cull, Ray};
use super::walk::{AtLeaf, Slabs, Stack, walk};
use super::{Accelerator, Ball, Hit, MeshTree};

/// The end of a ray that need not go on: before every box.
const END: f32 = f32::NEG_INFINITY;

/// A single above a double, by two units of the last place at most.
#[inline(always)]
pub(super) fn above(t: f64) -> f32 {
    let t = t as f32;
    t + (t.abs() * f32::EPSILON + f32::MIN_POSITIVE)
}

/// The search for the nearest hit of all placed meshes.
pub(super) struct InBed<'a> {
    pub(super) accelerator: &'a Accelerator,
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    pub(super) t_max: f64,
    /// Whether any hit will do.
    pub(super) any: bool,
    pub(super) stack: Stack<'a>,
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
pub(super) struct InMesh<'a> {
    pub(super) mesh: &'a MeshTree,
    pub(super) ray: Ray,
    pub(super) stack: Stack<'a>,
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

impl MeshTree {
    /// Takes the nearest hit of a ray in this mesh's coordinates, if it is nearer than the best so
    /// far. The ray meets nothing before `start`.
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
