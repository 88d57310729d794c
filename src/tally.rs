//! Counts of how often paths hit each material: what the tracer adds up.

use std::collections::{BTreeMap, HashMap};

/// Hits on each material, in the scene's order.
pub type State = Box<[u16]>;

/// Counts over some paths. Integers throughout, so that parts add up to the same whole in any
/// order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tally {
    /// Paths traced.
    pub paths: u64,
    /// Paths that met nothing: they saw past the target and say nothing of it.
    pub missed: u64,
    /// Paths that reached the sky after those hits.
    pub escaped: HashMap<State, u64>,
    /// Paths that were given up after those hits.
    pub trapped: HashMap<State, u64>,
    /// Paths that left for the sky downward, past the target's lower side.
    pub escaped_downward: u64,
    /// What the sensor sees: first hits on each material.
    pub first_hits: Vec<u64>,
    /// Paths that were given up since they were inside a solid, by the mesh they had left, unless that was the
    /// floor or the sensor, and the one they were in; they are among the trapped.
    pub inside: BTreeMap<(Option<usize>, usize), u64>,
    /// Surfaces hit in all.
    pub hits: u64,
    current: Vec<u16>,
    current_hits: u16,
}

impl Tally {
    /// An empty tally.
    pub fn new(materials: usize) -> Self {
        Self {
            paths: 0,
            missed: 0,
            escaped: HashMap::new(),
            trapped: HashMap::new(),
            escaped_downward: 0,
            first_hits: vec![0; materials],
            inside: BTreeMap::new(),
            hits: 0,
            current: vec![0; materials],
            current_hits: 0,
        }
    }

    /// Starts a path.
    pub(crate) fn begin(&mut self) {
        self.paths += 1;
        self.current.fill(0);
        self.current_hits = 0;
    }

    /// Counts a hit of the current path; returns the path's hits so far.
    pub(crate) fn hit(&mut self, material: u16) -> u16 {
        if self.current_hits == 0 {
            self.first_hits[usize::from(material)] += 1;
        }
        self.current[usize::from(material)] += 1;
        self.current_hits += 1;
        self.hits += 1;
        self.current_hits
    }

    /// Ends the path in the sky.
    pub(crate) fn escaped(&mut self, downward: bool) {
        if self.current_hits == 0 {
            self.missed += 1;
            return;
        }
        self.escaped_downward += u64::from(downward);
        count(&mut self.escaped, &self.current, 1);
    }

    /// Gives the path up.
    pub(crate) fn trapped(&mut self) {
        count(&mut self.trapped, &self.current, 1);
    }

    /// Gives the path up since it is inside a solid.
    pub(crate) fn buried(&mut self, left: Option<usize>, mesh: usize) {
        *self.inside.entry((left, mesh)).or_default() += 1;
        self.trapped();
    }

    /// Adds the counts of other paths.
    pub fn add(&mut self, other: &Self) {
        self.paths += other.paths;
        self.missed += other.missed;
        self.escaped_downward += other.escaped_downward;
        self.hits += other.hits;
        for (into, from) in
            [(&mut self.escaped, &other.escaped), (&mut self.trapped, &other.trapped)]
        {
            for (state, &number) in from {
                count(into, state, number);
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

fn count(counts: &mut HashMap<State, u64>, state: &[u16], number: u64) {
    match counts.get_mut(state) {
        Some(sum) => *sum += number,
        None => {
            counts.insert(state.into(), number);
        }
    }
}
