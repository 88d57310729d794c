//! From the root of a tree to the leaves that a ray meets, nearer ones first.

use super::lanes::Lanes;
use super::tree::{Child, Node, Tree, WIDTH};
use glam::{DVec3, Vec3};

/// What single precision may have moved a ray and a box or triangle against each other, as a share of
/// the greatest coordinate of either: sixteen units in the last place.
///
/// A box: its planes are exact; the ray's origin is rounded once, the inverse of the direction and the products
/// of it once each (1 + 2 + 2 units), the difference once (2 units).
pub const ROUNDING: f32 = 1.0 / (1 << 20) as f32;

/// Nodes still to be visited: the distance in the upper half, the child in the lower, so that they sort by
/// distance. As long as it ever was; how much of it is in use goes beside it.
pub struct Stack {
    entries: Vec<u64>,
    used: usize,
}

impl Stack {
    pub const fn new() -> Self {
        Self { entries: Vec::new(), used: 0 }
    }
}

/// A ray in single precision, as wide as its rounding.
pub struct Slabs<L> {
    inverse: [L; 3],
    /// Products of the inverse and the origin, moved apart by the rounding.
    enter: [L; 3],
    leave: [L; 3],
    /// Which planes are met first and last.
    first: [usize; 3],
    last: [usize; 3],
}

impl<L: Lanes> Slabs<L> {
    /// For boxes and an origin whose coordinates are at most `reach`.
    #[inline(always)]
    pub fn new(origin: DVec3, direction: DVec3, reach: f32) -> Self {
        let room = reach * ROUNDING;
        let (origin, direction) = (origin.as_vec3(), direction.as_vec3());
        // So near to zero that the ray does not get anywhere along that axis.
        let least = direction.abs().max_element() * 1e-18;
        let tiny = Vec3::splat(least);
        let direction = Vec3::select(direction.abs().cmplt(tiny), tiny, direction);
        let inverse = direction.recip();
        let along = origin * inverse;
        let room = inverse.abs() * room;
        let (enter, leave) = (along + room, along - room);
        let backward = |axis: usize| if direction[axis] < 0.0 { 3 } else { 0 };
        let first = [backward(0), 1 + backward(1), 2 + backward(2)];
        Self {
            inverse: splat(inverse),
            enter: splat(enter),
            leave: splat(leave),
            first,
            last: [3 - first[0], 5 - first[1], 7 - first[2]],
        }
    }

    /// Where the ray enters each child's box, and a bit for each that it meets within `t_max`.
    #[inline(always)]
    fn meet(&self, node: &Node, t_max: f32) -> (L, u32) {
        let [x, y, z] = self.first;
        let entered = cross(node, x, self.inverse[0], self.enter[0])
            .max(cross(node, y, self.inverse[1], self.enter[1]))
            .max(cross(node, z, self.inverse[2], self.enter[2]).max(L::splat(0.0)));
        let [x, y, z] = self.last;
        let left = cross(node, x, self.inverse[0], self.leave[0])
            .min(cross(node, y, self.inverse[1], self.leave[1]))
            .min(cross(node, z, self.inverse[2], self.leave[2]).min(L::splat(t_max)));
        (entered, entered.at_most(left))
    }
}

#[inline(always)]
fn splat<L: Lanes>(v: Vec3) -> [L; 3] {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

/// Where the ray meets the planes of that number.
#[inline(always)]
fn cross<L: Lanes>(node: &Node, plane: usize, inverse: L, along: L) -> L {
    L::load(&node.planes[plane % 6]).mul_sub(inverse, along)
}

/// What is done at a leaf.
pub trait Visit {
    /// Told where the ray enters the leaf; returns the ray's new end. To be inlined, which a closure would not be.
    fn leaf(&mut self, leaf: Child, entered: f32, stack: &mut Stack) -> f32;
}

impl<F: FnMut(Child, f32, &mut Stack) -> f32> Visit for F {
    #[inline(always)]
    fn leaf(&mut self, leaf: Child, entered: f32, stack: &mut Stack) -> f32 {
        self(leaf, entered, stack)
    }
}

/// Calls `leaf` with the leaves that the ray meets and where it enters them; `leaf` returns the ray's
/// new end. What stands on the stack stays there.
#[inline(always)]
pub fn walk<L: Lanes>(
    tree: &Tree,
    slabs: &Slabs<L>,
    mut t_max: f32,
    stack: &mut Stack,
    mut visit: impl Visit,
) {
    let base = stack.used;
    let mut used = base;
    let mut current = Child::ROOT;
    let mut entered = 0.0;
    loop {
        while !current.is_leaf() {
            let node = &tree.0[current.number()];
            let (near, mut met) = slabs.meet(node, t_max);
            if met == 0 {
                break;
            }
            let near = near.store();
            let slot = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            current = node.children[slot];
            entered = near[slot];
            if met == 0 {
                continue;
            }
            if stack.entries.len() < used + WIDTH {
                stack.entries.resize(2 * (used + WIDTH), 0);
            }
            let entries = &mut stack.entries[used..used + WIDTH];
            let mut nearest = entry(entered, current);
            let mut count = 0;
            while met != 0 {
                let slot = met.trailing_zeros() as usize % WIDTH;
                met &= met - 1;
                let other = entry(near[slot], node.children[slot]);
                // The nearest is next; farther ones lie below.
                let farther = nearest.max(other);
                nearest = nearest.min(other);
                let mut place = count % WIDTH;
                while place > 0 && entries[place - 1] < farther {
                    entries[place] = entries[place - 1];
                    place -= 1;
                }
                entries[place] = farther;
                count += 1;
            }
            used += count;
            (entered, current) = parts(nearest);
        }
        if current.is_leaf() {
            stack.used = used;
            t_max = visit.leaf(current, entered, stack);
        }
        loop {
            if used == base {
                stack.used = base;
                return;
            }
            used -= 1;
            (entered, current) = parts(stack.entries[used]);
            if entered <= t_max {
                break;
            }
        }
    }
}

#[inline(always)]
fn entry(entered: f32, child: Child) -> u64 {
    u64::from(entered.to_bits()) << 32 | u64::from(child.0)
}

#[inline(always)]
fn parts(entry: u64) -> (f32, Child) {
    (f32::from_bits((entry >> 32) as u32), Child(entry as u32))
}
