//! Counts of what paths did: what the tracer adds up.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use rustc_hash::FxHashMap;

use super::kept::{Kept, PARTS, WEIGHTS};
use crate::support::math;

/// The hits of a path as numbers, in a form that [`Kept`] describes.
pub type State = Box<[u16]>;

/// Parts of paths by state; the last number of a key is the path's group or cell.
pub type Counts = FxHashMap<State, i64>;

/// Parts of paths that Russian roulette ended, less those that it added, by group or cell.
pub type Rouletted = BTreeMap<u16, i64>;

/// Cells of the view along x and along y. Their spread tells how much such beds differ.
pub const CELLS: u16 = 4;

/// The bin, of `bins` of equal width, of a number from 0 to 1.
fn bin(bins: u16, value: f64) -> u16 {
    ((value * f64::from(bins)) as u16).min(bins - 1)
}

/// How paths ended, in parts of paths.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Outcomes {
    /// Reached the sky.
    pub escaped: Counts,
    /// Given up.
    pub given_up: Counts,
    /// Ended by Russian roulette, less those that it added. With it all add up to the paths.
    pub rouletted: Rouletted,
}

/// Counts over some paths. All are integers, so that parts of a trace add up to the same whole in
/// any order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tally {
    kept: Kept,
    /// Paths traced.
    pub paths: u64,
    /// Paths that saw past the target: they say nothing of it.
    pub missed: u64,
    /// How the others ended, by group.
    pub by_group: Outcomes,
    /// The same by the cell of the view in which the path began, where the view has cells.
    pub by_cell: Outcomes,
    /// Parts of paths that escaped downward, past the target's lower side.
    pub escaped_downward: u64,
    /// First hits on each material: what the sensor sees.
    pub first_hits: Vec<u64>,
    /// Paths given up inside a solid, by the mesh that they had left (`None`: the floor or the
    /// sensor) and the mesh of the solid.
    pub inside: BTreeMap<(Option<usize>, usize), u64>,
    /// All hits.
    pub hits: u64,
    current: Current,
}

/// The path that is traced now.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Current {
    group: u16,
    cell: Option<u16>,
    hits: u16,
    /// Parts of the path that have not ended.
    parts: u64,
    /// Paths like it that it stands for.
    stands_for: u64,
    /// Hits on each material, or all symbols.
    state: Vec<u16>,
    /// The key of the next count.
    key: Vec<u16>,
}

/// How a path of weight 1 ended that was traced at one node.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Light {
    /// The weight that it brings to the sky.
    pub reached_sky: f64,
    /// The weight with which it was given up.
    pub given_up: f64,
    /// Hits on the floor, whose reflectance the weights leave out.
    pub floor_hits: u16,
    /// Whether it left past the target's lower side.
    pub downward: bool,
    /// The material that it met first.
    pub first: u16,
    /// Faces that it met.
    pub faces: u32,
}

impl Tally {
    /// An empty tally.
    pub fn new(materials: usize, kept: Kept) -> Self {
        Self {
            kept,
            paths: 0,
            missed: 0,
            by_group: Outcomes::default(),
            by_cell: Outcomes::default(),
            escaped_downward: 0,
            first_hits: vec![0; materials],
            inside: BTreeMap::new(),
            hits: 0,
            current: Current::default(),
        }
    }

    /// What is recorded of each path.
    pub fn kept(&self) -> Kept {
        self.kept
    }

    /// A path that was traced apart at each node meets nothing.
    pub(crate) fn light_misses(&mut self) {
        self.missed += 1;
    }

    /// What a path of weight 1 does at a node.
    pub(crate) fn light(&mut self, node: u16, light: &Light) {
        if node == 0 {
            self.first_hits[usize::from(light.first)] += 1;
        }
        self.hits += u64::from(light.faces);
        let units = |weight: f64| (weight * WEIGHTS as f64).round() as i64;
        let [reached_sky, given_up] = [light.reached_sky, light.given_up].map(units);
        let current = &mut self.current;
        current.state.clear();
        current.state.push(node);
        let floor = current.state.len() + usize::from(light.floor_hits);
        current.state.resize(floor, self.kept.nodes);
        if reached_sky > 0 {
            let counts = [&mut self.by_group.escaped, &mut self.by_cell.escaped];
            current.count(self.kept, None, reached_sky, counts);
        }
        if given_up > 0 {
            let counts = [&mut self.by_group.given_up, &mut self.by_cell.given_up];
            current.count(self.kept, None, given_up, counts);
        }
        let absorbed = WEIGHTS as i64 - reached_sky - given_up;
        *self.by_group.rouletted.entry(current.group).or_default() += absorbed;
        if let Some(cell) = current.cell {
            *self.by_cell.rouletted.entry(cell).or_default() += absorbed;
        }
        if light.downward {
            self.escaped_downward += reached_sky as u64;
        }
    }

    /// Starts a path; `cell` is that of the view, if it has any.
    pub(crate) fn begin(&mut self, group: u16, cell: Option<u16>) {
        self.paths += 1;
        let current = &mut self.current;
        (current.group, current.cell, current.hits) = (group, cell, 0);
        (current.parts, current.stands_for) = (PARTS, 1);
        current.state.clear();
        if !self.kept.lists() {
            current.state.resize(self.first_hits.len(), 0);
        }
    }

    /// Counts a hit of the current path on a layer of a material; returns its symbol and the path's
    /// hits so far.
    pub(crate) fn hit(
        &mut self,
        (material, layer): (u16, u16),
        by_angle: bool,
        cosine: f64,
    ) -> (usize, u16) {
        let current = &mut self.current;
        if current.hits == 0 {
            self.first_hits[usize::from(material)] += 1;
        }
        let cosines = self.kept.cosines;
        let symbol = (material * self.kept.layers.max(1) + layer) * cosines
            + if by_angle { bin(cosines, cosine) } else { 0 };
        if self.kept.lists() {
            current.state.push(symbol);
        } else {
            current.state[usize::from(material)] += 1;
        }
        current.hits += 1;
        self.hits += 1;
        (symbol.into(), current.hits)
    }

    /// The share of the current path that has not ended.
    pub(crate) fn share(&self) -> f64 {
        self.current.parts as f64 / PARTS as f64
    }

    /// Number of paths like it that the current one stands for.
    pub(crate) fn stands_for(&self) -> u64 {
        self.current.stands_for
    }

    /// Parts of the current path reach the sky, one along each direction, of which the cosine with
    /// the vertical is given.
    pub(crate) fn parts_reached_sky(&mut self, cosines: &[f64]) {
        let by_zenith = self.kept.zeniths > 1;
        // Those in one bin are counted at once.
        for alike in cosines.chunk_by(|a, b| !by_zenith && (*a < 0.0) == (*b < 0.0)) {
            self.escape(alike[0], alike.len() as u64);
        }
    }

    /// The rest of the current path reaches the sky.
    pub(crate) fn reached_sky(&mut self, cosine: f64) {
        self.escape(cosine, self.current.parts);
    }

    fn escape(&mut self, cosine: f64, parts: u64) {
        self.current.parts -= parts;
        if self.current.hits == 0 {
            self.missed += 1;
            return;
        }
        self.escaped_downward += if cosine < 0.0 { parts } else { 0 };
        let zenith = (self.kept.zeniths > 1)
            .then(|| bin(self.kept.zeniths, math::acos(cosine.clamp(0.0, 1.0)) / FRAC_PI_2));
        let counts = [&mut self.by_group.escaped, &mut self.by_cell.escaped];
        self.current.count(self.kept, zenith, parts as i64, counts);
    }

    /// The rest of the current path is given up.
    pub(crate) fn give_up(&mut self) {
        let parts = self.current.parts as i64;
        let counts = [&mut self.by_group.given_up, &mut self.by_cell.given_up];
        self.current.count(self.kept, None, parts, counts);
    }

    /// The rest of the current path is given up: after it left one mesh it is inside another.
    pub(crate) fn give_up_inside(&mut self, left: Option<usize>, mesh: usize) {
        *self.inside.entry((left, mesh)).or_default() += self.current.stands_for;
        self.give_up();
    }

    /// Russian roulette: of `times` paths like the current one all but one are ended, and it stands
    /// for all.
    pub(crate) fn roulette(&mut self, times: u64, goes_on: bool) {
        let parts = self.current.parts as i64;
        self.current.parts = if goes_on { self.current.parts * times } else { 0 };
        self.current.stands_for *= times;
        let ended = parts - self.current.parts as i64;
        *self.by_group.rouletted.entry(self.current.group).or_default() += ended;
        if let Some(cell) = self.current.cell {
            *self.by_cell.rouletted.entry(cell).or_default() += ended;
        }
    }

    /// Adds the counts of other paths.
    pub fn add(&mut self, other: &Self) {
        self.paths += other.paths;
        self.missed += other.missed;
        self.escaped_downward += other.escaped_downward;
        self.hits += other.hits;
        self.by_group.add(&other.by_group);
        self.by_cell.add(&other.by_cell);
        for (sum, &number) in self.first_hits.iter_mut().zip(&other.first_hits) {
            *sum += number;
        }
        for (&meshes, &number) in &other.inside {
            *self.inside.entry(meshes).or_default() += number;
        }
    }
}

impl Outcomes {
    fn add(&mut self, other: &Self) {
        for (state, &parts) in &other.escaped {
            count(&mut self.escaped, state, parts);
        }
        for (state, &parts) in &other.given_up {
            count(&mut self.given_up, state, parts);
        }
        for (&group, &parts) in &other.rouletted {
            *self.rouletted.entry(group).or_default() += parts;
        }
    }
}

impl Current {
    /// Counts parts that end here, by group and by cell.
    fn count(
        &mut self,
        kept: Kept,
        zenith: Option<u16>,
        parts: i64,
        [by_group, by_cell]: [&mut Counts; 2],
    ) {
        self.key.clear();
        self.key.extend_from_slice(&self.state);
        if kept.lists() && !kept.order {
            self.key.sort_unstable();
        }
        self.key.extend(zenith);
        self.key.push(self.group);
        count(by_group, &self.key, parts);
        if let (Some(cell), Some(last)) = (self.cell, self.key.last_mut()) {
            *last = cell;
            count(by_cell, &self.key, parts);
        }
    }
}

fn count(counts: &mut Counts, state: &[u16], number: i64) {
    match counts.get_mut(state) {
        Some(sum) => *sum += number,
        None => {
            counts.insert(state.into(), number);
        }
    }
}
