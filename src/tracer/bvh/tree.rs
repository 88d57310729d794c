//! A tree of nodes with eight children, made from the binary tree that obvhs builds. No other
//! module uses obvhs.

use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};

use crate::geometry::MOST_PLACEMENTS;

pub use obvhs::aabb::Aabb;

/// Children of a node, and the most entries of a leaf.
pub const WIDTH: usize = 8;

/// A node's eight children, their boxes by coordinate.
#[repr(C, align(64))]
pub struct Node {
    /// Least x, y and z of each child, then greatest x, y and z.
    pub planes: [[f32; WIDTH]; 6],
    /// As `Child`.
    pub children: [u32; WIDTH],
}

/// Number of an inner node; or of a leaf's block, with its first slot and number of entries.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Child(pub u32);

impl Child {
    pub const ROOT: Self = Self(0);
    const LEAF: u32 = 1 << 31;
    const NUMBER_BITS: u32 = 25;
    const FIRST: u32 = 28;

    fn node(number: usize) -> Self {
        const { assert!(MOST_PLACEMENTS < 1 << Self::NUMBER_BITS) };
        assert!(number < 1 << Self::NUMBER_BITS, "no bed has as many");
        Self(number as u32)
    }

    fn leaf(number: usize, first: usize, holds: usize) -> Self {
        let Self(number) = Self::node(number);
        let (first, holds) = ((first as u32) << Self::FIRST, (holds - 1) as u32);
        Self(Self::LEAF | first | holds << Self::NUMBER_BITS | number)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Number of the node or block.
    #[inline(always)]
    pub fn number(self) -> usize {
        (self.0 & ((1 << Self::NUMBER_BITS) - 1)) as usize
    }

    /// A bit for each slot of the leaf.
    #[inline(always)]
    pub fn held(self) -> u32 {
        0xff >> (7 - (self.0 >> Self::NUMBER_BITS & 7)) << (self.0 >> Self::FIRST & 7)
    }
}

pub struct Tree {
    /// The first is the root.
    pub nodes: Vec<Node>,
    /// The most inner nodes between the root and a leaf.
    depth: usize,
}

/// Cost of testing a node's eight boxes, relative to testing a leaf.
const NODE_COST: f32 = 1.0;

impl Tree {
    /// Builds a tree over boxes. Calls `block` with the entries of each block, at most `per_block`,
    /// in the order of the blocks. Leaves that fit share a block: most are smaller, and neighbours
    /// are met by the same rays.
    pub fn new(boxes: &[Aabb], per_block: usize, mut block: impl FnMut(&[u32])) -> Self {
        let mut nodes = vec![Node::EMPTY];
        if boxes.is_empty() {
            return Self { nodes, depth: 1 };
        }
        let mut deepest = 1;
        let settings = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
        let binary = build_bvh2(boxes, settings, &mut Duration::default());
        let costs = Costs::new(&binary, per_block);
        let mut blocks = 0;
        let mut open = vec![(0, 0, 1)];
        let (mut children, mut members) =
            (Vec::with_capacity(WIDTH), Vec::with_capacity(2 * WIDTH));
        while let Some((from, into, depth)) = open.pop() {
            deepest = deepest.max(depth);
            children.clear();
            if costs.is_leaf(from) {
                children.push(from);
            } else {
                costs.split(from, WIDTH, &mut children);
            }
            for (slot, &child) in children.iter().enumerate() {
                let aabb = binary.nodes[child].aabb();
                for axis in 0..3 {
                    nodes[into].planes[axis][slot] = aabb.min[axis];
                    nodes[into].planes[axis + 3][slot] = aabb.max[axis];
                }
                let Child(number) = if costs.is_leaf(child) {
                    let mut first = members.len();
                    costs.members(child, &mut members);
                    if members.len() > per_block {
                        block(&members[..first]);
                        blocks += 1;
                        members.drain(..first);
                        first = 0;
                    }
                    Child::leaf(blocks, first, members.len() - first)
                } else {
                    nodes.push(Node::EMPTY);
                    open.push((child, nodes.len() - 1, depth + 1));
                    Child::node(nodes.len() - 1)
                };
                nodes[into].children[slot] = number;
            }
        }
        if !members.is_empty() {
            block(&members);
        }
        Self { nodes, depth: deepest }
    }

    /// The most nodes on a walk's stack, with room to write eight at a time.
    pub fn stack(&self) -> usize {
        self.depth * (WIDTH - 1) + WIDTH
    }
}

impl Node {
    /// No ray meets these boxes.
    const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [Child::ROOT.0; WIDTH],
    };
}

/// The least expected cost of each binary subtree as up to eight children of one wide node, by
/// surface areas: Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs through
/// compressed wide BVHs" (High-Performance Graphics 2017), section 3.
struct Costs<'a> {
    binary: &'a Bvh2,
    /// For each binary node: its cost as at most 1, 2, ... 7 children; last that of the best split
    /// in 8.
    costs: Vec<[f32; WIDTH]>,
    leaf: Vec<bool>,
}

impl<'a> Costs<'a> {
    fn new(binary: &'a Bvh2, per_leaf: usize) -> Self {
        let count = binary.nodes.len();
        let mut order = Vec::with_capacity(count);
        let mut open = vec![0];
        while let Some(node) = open.pop() {
            order.push(node);
            let it = &binary.nodes[node];
            if !it.is_leaf() {
                open.extend([it.first_index as usize, it.first_index as usize + 1]);
            }
        }
        let mut all = Self { binary, costs: vec![[0.0; WIDTH]; count], leaf: vec![true; count] };
        let mut holds = vec![1_usize; count];
        for &node in order.iter().rev() {
            let it = &binary.nodes[node];
            let area = it.aabb().half_area();
            if it.is_leaf() {
                all.costs[node] = [area; WIDTH];
                continue;
            }
            let (left, right) = (it.first_index as usize, it.first_index as usize + 1);
            holds[node] = holds[left] + holds[right];
            let inner = area * NODE_COST + all.best(node, WIDTH).0;
            all.leaf[node] = holds[node] <= per_leaf && area <= inner;
            let mut costs = [0.0; WIDTH];
            costs[0] = if all.leaf[node] { area } else { inner };
            for slots in 2..WIDTH {
                costs[slots - 1] = all.best(node, slots).0.min(costs[slots - 2]);
            }
            all.costs[node] = costs;
        }
        all
    }

    fn is_leaf(&self, node: usize) -> bool {
        self.leaf[node]
    }

    /// Least cost of a binary node's two children in this many slots, and the slots of the first.
    fn best(&self, node: usize, slots: usize) -> (f32, usize) {
        let left = self.binary.nodes[node].first_index as usize;
        let cost =
            |first: usize| self.costs[left][first - 1] + self.costs[left + 1][slots - first - 1];
        (1..slots)
            .map(|first| (cost(first), first))
            .fold((f32::INFINITY, 1), |a, b| if b.0 < a.0 { b } else { a })
    }

    /// The binary nodes that become the children of one wide node.
    fn split(&self, node: usize, slots: usize, children: &mut Vec<usize>) {
        let left = self.binary.nodes[node].first_index as usize;
        let (_, first) = self.best(node, slots);
        for (child, slots) in [(left, first), (left + 1, slots - first)] {
            let costs = &self.costs[child];
            let fewest = (1..=slots).find(|&fewer| costs[fewer - 1] <= costs[slots - 1]);
            match fewest {
                Some(1) | None => children.push(child),
                Some(fewer) => self.split(child, fewer, children),
            }
        }
    }

    /// The entries of a subtree.
    fn members(&self, node: usize, members: &mut Vec<u32>) {
        let it = &self.binary.nodes[node];
        if it.is_leaf() {
            members.push(self.binary.primitive_indices[it.first_index as usize]);
        } else {
            self.members(it.first_index as usize, members);
            self.members(it.first_index as usize + 1, members);
        }
    }
}
