//! Counts of the courses that paths took: what the tracer adds up.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// The rules of a path as numbers, in a form that [`Kept`] tells.
pub type State = Box<[u16]>;

/// How many parts of paths took each rules.
pub type Counts = FxHashMap<State, i64>;

/// Bins of the cosine between a ray and the facet's normal, where a reflectance depends on it.
pub const COSINES: u16 = 64;

/// Bins of the zenith angle at which paths reach the sky, where its radiance depends on it: a degree each.
pub const ZENITHS: u16 = 90;

/// What of a path's rules is kept: the least that the scene asks for.
///
/// A hit is told by its *symbol*, the material and, where kept, the bin of its cosine. If neither order nor cosines
/// are kept a state is the number of hits on each material; else it is the symbols of all hits, in their order or
/// sorted. The zenith bin stands at the end of the state of a path that reached the sky, if it is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kept {
    /// The order of hits: where materials differ in temperature.
    pub order: bool,
    /// Bins of the cosine of each hit; 1 where no reflectance depends on it.
    pub cosines: u16,
    /// Bins of the zenith angle of escape; 1 where the sky is isotropic.
    pub zeniths: u16,
}

impl Kept {
    /// Numbers of hits: enough for one temperature, an isotropic sky and reflectances that do not depend on the angle.
    pub const PLAIN: Self = Self { order: false, cosines: 1, zeniths: 1 };

    /// Whether a state lists the hits, rather than counting those on each material.
    pub fn lists(self) -> bool {
        self.order || self.cosines > 1
    }

    /// How many symbols there are.
    pub fn symbols(self, materials: usize) -> usize {
        materials * usize::from(self.cosines)
    }

    /// Splits the state of an escaped path into its hits and the bin of its zenith angle.
    pub fn split(self, state: &[u16]) -> (&[u16], usize) {
        match state.split_last() {
            Some((&bin, hits)) if self.zeniths > 1 => (hits, bin.into()),
            _ => (state, 0),
        }
    }
}

/// The bin, of so many of equal width, of a number from 0 to 1.
fn bin(bins: u16, value: f64) -> u16 {
    ((value * f64::from(bins)) as u16).min(bins - 1)
}

/// What a path is counted in: at its first hit so many directions are tried, and each that meets the sky brings a part
/// of the path there. More parts cost more rays than they save (docs/tracer_speed.md).
pub const PARTS: u64 = 5;

/// Cells of the view along x and along y: a bed's own parts, whose spread tells what such beds differ by.
pub const CELLS: u16 = 4;

/// Parts of paths that Russian roulette ended, less those that it added, by group or cell.
pub type Ended = BTreeMap<u16, i64>;

/// Counts over some paths. Integers throughout, so that parts add up to the same whole in any
/// order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tally {
    kept: Kept,
    /// Paths traced.
    pub paths: u64,
    /// Paths that met nothing: they saw past the target and say nothing of it.
    pub missed: u64,
    /// Parts of paths that reached the sky: states, with the path's group as one more number at the end.
    pub escaped: Counts,
    /// Parts of paths that were given up, in the same form.
    pub trapped: Counts,
    /// What makes both add up to the paths.
    pub ended: Ended,
    /// All again with the cell of the view that the path began in in place of the group.
    pub by_cell: ByCell,
    /// Parts of paths that left for the sky downward, past the target's lower side.
    pub escaped_downward: u64,
    /// What the sensor sees: first hits on each material.
    pub first_hits: Vec<u64>,
    /// Paths whose rest was given up since it was inside a solid, by the mesh they had left, unless that was the
    /// floor or the sensor, and the one they were in; it is among the trapped.
    pub inside: BTreeMap<(Option<usize>, usize), u64>,
    /// Surfaces hit in all.
    pub hits: u64,
    current: Current,
}

/// Counts by the cells of the view.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ByCell {
    /// Parts of paths that reached the sky.
    pub escaped: Counts,
    /// Parts of paths that were given up.
    pub trapped: Counts,
    /// What makes both add up to the paths.
    pub ended: Ended,
}

/// The path that is under way.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Current {
    group: u16,
    cell: Option<u16>,
    hits: u16,
    /// Parts of the path that are still under way.
    parts: u64,
    /// Paths like it that it stands for.
    stands_for: u64,
    /// Hits on each material, or all symbols.
    state: Vec<u16>,
    /// The key of what is counted next.
    key: Vec<u16>,
}

impl Tally {
    /// An empty tally.
    pub fn new(materials: usize, kept: Kept) -> Self {
        Self {
            kept,
            paths: 0,
            missed: 0,
            escaped: Counts::default(),
            trapped: Counts::default(),
            ended: Ended::new(),
            by_cell: ByCell::default(),
            escaped_downward: 0,
            first_hits: vec![0; materials],
            inside: BTreeMap::new(),
            hits: 0,
            current: Current::default(),
        }
    }

    /// What is kept of a path.
    pub fn kept(&self) -> Kept {
        self.kept
    }

    /// Starts a path; `cell` is that of the view, if the view has any.
    pub(crate) fn begin(&mut self, group: u16, cell: Option<u16>) {
        self.paths += 1;
        self.current.group = group;
        self.current.cell = cell;
        self.current.hits = 0;
        self.current.parts = PARTS;
        self.current.stands_for = 1;
        self.current.state.clear();
        if !self.kept.lists() {
            self.current.state.resize(self.first_hits.len(), 0);
        }
    }

    /// Counts a hit of the current path at a cosine; returns its symbol and the path's hits so far.
    pub(crate) fn hit(&mut self, material: u16, by_angle: bool, cosine: f64) -> (usize, u16) {
        let current = &mut self.current;
        if current.hits == 0 {
            self.first_hits[usize::from(material)] += 1;
        }
        let cosines = self.kept.cosines;
        let symbol = material * cosines + if by_angle { bin(cosines, cosine) } else { 0 };
        if self.kept.lists() {
            current.state.push(symbol);
        } else {
            current.state[usize::from(material)] += 1;
        }
        current.hits += 1;
        self.hits += 1;
        (symbol.into(), current.hits)
    }

    /// The share of the current path that is still under way.
    pub(crate) fn share(&self) -> f64 {
        self.current.parts as f64 / PARTS as f64
    }

    /// How many paths like it the current one stands for.
    pub(crate) fn stands_for(&self) -> u64 {
        self.current.stands_for
    }

    /// Parts of the current path reach the sky, one along each direction of which the cosine with the vertical is given.
    pub(crate) fn escaped(&mut self, cosines: &[f64]) {
        let by_zenith = self.kept.zeniths > 1;
        // Those that nothing tells apart are counted at once.
        for alike in cosines.chunk_by(|a, b| !by_zenith && (*a < 0.0) == (*b < 0.0)) {
            self.escaped_along(alike[0], alike.len() as u64);
        }
    }

    /// What is left of the current path reaches the sky.
    pub(crate) fn ended(&mut self, cosine: f64) {
        self.escaped_along(cosine, self.current.parts);
    }

    fn escaped_along(&mut self, cosine: f64, parts: u64) {
        self.current.parts -= parts;
        if self.current.hits == 0 {
            self.missed += 1;
            return;
        }
        self.escaped_downward += if cosine < 0.0 { parts } else { 0 };
        let zenith = (self.kept.zeniths > 1)
            .then(|| bin(self.kept.zeniths, cosine.clamp(0.0, 1.0).acos() / FRAC_PI_2));
        self.current.count(
            self.kept,
            zenith,
            parts as i64,
            &mut self.escaped,
            &mut self.by_cell.escaped,
        );
    }

    /// What is left of the current path is given up.
    pub(crate) fn trapped(&mut self) {
        let parts = self.current.parts as i64;
        self.current.count(self.kept, None, parts, &mut self.trapped, &mut self.by_cell.trapped);
    }

    /// The same since it is inside a solid.
    pub(crate) fn buried(&mut self, left: Option<usize>, mesh: usize) {
        *self.inside.entry((left, mesh)).or_default() += self.current.stands_for;
        self.trapped();
    }

    /// Russian roulette: of `times` paths like the current one all but one are ended, and it stands for all.
    pub(crate) fn roulette(&mut self, times: u64, goes_on: bool) {
        let parts = self.current.parts as i64;
        self.current.parts = if goes_on { self.current.parts * times } else { 0 };
        self.current.stands_for *= times;
        let ended = parts - self.current.parts as i64;
        *self.ended.entry(self.current.group).or_default() += ended;
        if let Some(cell) = self.current.cell {
            *self.by_cell.ended.entry(cell).or_default() += ended;
        }
    }

    /// Adds the counts of other paths.
    pub fn add(&mut self, other: &Self) {
        self.paths += other.paths;
        self.missed += other.missed;
        self.escaped_downward += other.escaped_downward;
        self.hits += other.hits;
        let (ours, theirs) = (&mut self.by_cell, &other.by_cell);
        for (into, from) in [
            (&mut self.escaped, &other.escaped),
            (&mut self.trapped, &other.trapped),
            (&mut ours.escaped, &theirs.escaped),
            (&mut ours.trapped, &theirs.trapped),
        ] {
            for (state, &number) in from {
                count(into, state, number);
            }
        }
        for (into, from) in [(&mut self.ended, &other.ended), (&mut ours.ended, &theirs.ended)] {
            for (&group, &number) in from {
                *into.entry(group).or_default() += number;
            }
        }
        for (sum, &number) in self.first_hits.iter_mut().zip(&other.first_hits) {
            *sum += number;
        }
        for (&meshes, &number) in &other.inside {
            *self.inside.entry(meshes).or_default() += number;
        }
    }
}

impl Current {
    /// Counts what of the path ends here.
    fn count(
        &mut self,
        kept: Kept,
        zenith: Option<u16>,
        parts: i64,
        counts: &mut Counts,
        by_cell: &mut Counts,
    ) {
        self.key.clear();
        self.key.extend_from_slice(&self.state);
        if kept.lists() && !kept.order {
            self.key.sort_unstable();
        }
        self.key.extend(zenith);
        self.key.push(self.group);
        count(counts, &self.key, parts);
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
