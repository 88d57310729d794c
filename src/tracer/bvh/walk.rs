//! A walk from the root of a tree to the leaves that a ray meets, nearer ones first.

use glam::{DVec3, Vec3A};

use super::lanes::Lanes;
use super::tree::{Child, Node, Tree};

/// Greatest error of a ray against a box in single precision, as a share of the greatest coordinate
/// of either: sixteen units of the last place.
///
/// The planes of a box are exact. The ray's origin is rounded once, the inverse of the direction
/// and its products once each (1 + 2 + 2 units), the difference once (2 units).
pub const ROUNDING: f32 = 1.0 / (1 << 20) as f32;

/// Nodes still to be visited: where the ray enters them, and their numbers.
pub struct Stack<'a> {
    pub near: &'a mut [f32],
    pub children: &'a mut [u32],
}

/// A ray in single precision, as wide as its rounding error.
pub struct Slabs<L> {
    inverse: [L; 3],
    /// Products of the inverse and the origin, moved apart by the rounding.
    enter: [L; 3],
    leave: [L; 3],
    /// The planes met first and last.
    first: [usize; 3],
    last: [usize; 3],
}

impl<L: Lanes> Slabs<L> {
    /// For boxes and an origin whose coordinates are at most `reach`.
    #[inline(always)]
    pub fn new(origin: DVec3, direction: DVec3, reach: f32) -> Self {
        let room = reach * ROUNDING;
        let (origin, direction) = (origin.as_vec3a(), direction.as_vec3a());
        // So near to zero that the ray does not advance along that axis.
        let tiny = Vec3A::splat(direction.abs().max_element() * 1e-18);
        let direction = Vec3A::select(direction.abs().cmplt(tiny), tiny, direction);
        let inverse = direction.recip();
        let along = origin * inverse;
        let room = inverse.abs() * room;
        let backward = direction.is_negative_bitmask() as usize;
        let first = [0, 1, 2].map(|axis| axis + 3 * (backward >> axis & 1));
        Self {
            inverse: splat(inverse),
            enter: splat(along + room),
            leave: splat(along - room),
            first,
            last: [3 - first[0], 5 - first[1], 7 - first[2]],
        }
    }

    /// Where the ray enters each child's box and where it leaves it, or ends.
    #[inline(always)]
    fn meet(&self, node: &Node, t_max: f32) -> (L, L) {
        let [x, y, z] = self.first;
        let entered = cross(node, x, self.inverse[0], self.enter[0])
            .greater(cross(node, y, self.inverse[1], self.enter[1]))
            .greater(cross(node, z, self.inverse[2], self.enter[2]).greater(L::splat(0.0)));
        let [x, y, z] = self.last;
        let left = cross(node, x, self.inverse[0], self.leave[0])
            .lesser(cross(node, y, self.inverse[1], self.leave[1]))
            .lesser(cross(node, z, self.inverse[2], self.leave[2]).lesser(L::splat(t_max)));
        (entered, left)
    }
}

#[inline(always)]
fn splat<L: Lanes>(v: Vec3A) -> [L; 3] {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

/// Where the ray meets the planes of that number.
#[inline(always)]
fn cross<L: Lanes>(node: &Node, plane: usize, inverse: L, along: L) -> L {
    L::load(&node.planes[plane.min(5)]).mul_sub(inverse, along)
}

/// What is done at a leaf that a ray enters at some distance. Returns the ray's new end.
///
/// It must be inlined to have the CPU features of its caller. A closure would not be inlined where
/// there are several walks, and each operation on lanes in it would become a call.
pub trait AtLeaf {
    fn meet(&mut self, leaf: Child, entered: f32, stack: Stack) -> f32;
}

/// Calls `leaf` with the leaves that the ray meets and where it enters them. `leaf` may use the
/// rest of the stack.
///
/// All children that are met go through the stack: eight are sorted at once, without a branch that
/// the processor could mispredict.
#[inline(always)]
pub fn walk<L: Lanes>(
    tree: &Tree,
    slabs: &Slabs<L>,
    mut t_max: f32,
    stack: Stack,
    mut leaf: impl AtLeaf,
) {
    let Stack { near, children } = stack;
    let mut used = 0;
    let mut current = Child::ROOT;
    loop {
        let node = &tree.nodes[current.number()];
        let (enter, leave) = slabs.meet(node, t_max);
        let room = "the stack has the size that `Tree::stack` says";
        let (sorted, _) = near[used..].split_first_chunk_mut().expect(room);
        let (beside, _) = children[used..].split_first_chunk_mut().expect(room);
        used += enter.sort_at_most(leave, &node.children, (sorted, beside));
        loop {
            if used == 0 {
                return;
            }
            used -= 1;
            let entered = near[used];
            if entered > t_max {
                continue;
            }
            current = Child(children[used]);
            if !current.is_leaf() {
                break;
            }
            let stack = Stack { near: &mut near[used..], children: &mut children[used..] };
            t_max = leaf.meet(current, entered, stack);
        }
    }
}
