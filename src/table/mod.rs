//! The bounce table: everything that spectra, temperatures and sky need to know of a traced bed.

mod change;
pub mod cover;
pub mod field;
mod file;
mod light;
mod material;
pub mod materials;
pub mod merge;
mod nodes;
mod prepared;
pub mod stop;
pub mod warning;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::histogram::tally::{Outcomes, Tally};
use crate::histogram::{Histogram, Mean};
use crate::radiometry::{Atmosphere, SkyTable};
use crate::scene::{Layers, Origin, Sky, View};
use crate::spectrum::{Spectrum, SpectrumError};
use crate::table::cover::Cover;
use crate::table::field::FieldSummary;
use crate::table::materials::reflectances;
use crate::table::stop::Reached;
use crate::table::warning::Warning;

pub use change::ChangeError;
pub use file::TableError;
pub use material::{TableMaterial, feature_windows};
pub use nodes::{Nodes, NodesError};
pub use prepared::Prepared;
pub(crate) use prepared::resolved;
pub use stop::{Part, Precision, Stop, StopReason, Target};

/// The format's version, the value of `soilsig_table`.
pub const FORMAT: u32 = 5;

/// A traced bed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Version of the format: 5.
    pub soilsig_table: u32,
    /// The scene's name.
    pub scene: String,
    /// SHA-256 of the scene file and its meshes.
    pub scene_sha256: String,
    /// Temperature of the scene, kelvin.
    pub temperature_k: f64,
    /// Layers of temperature; `temperature_k` is then that of the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layers: Option<Layers>,
    /// Temperature of the sky, kelvin, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_temperature_k: Option<Sky>,
    /// Radiance of the sky, if it was given so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_radiance: Option<SkyTable>,
    /// The atmosphere between target and sensor, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub atmosphere: Option<Atmosphere>,
    /// The direction to the sensor.
    pub view: View,
    /// Seed of the paths.
    pub seed: u64,
    /// Hits after which a path was given up.
    pub max_bounces: u16,
    /// The materials, in the order of the counts.
    pub materials: Vec<TableMaterial>,
    /// Index of the floor's material, if nothing else is made of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<usize>,
    /// Where the geometry comes from.
    #[serde(default, skip_serializing_if = "Origin::is_given")]
    pub origin: Origin,
    /// Seed of the drop, where other tables may be of the same drop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drop: Option<u64>,
    /// The wavelengths at which paths were traced apart, if facets are refractive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<Nodes>,
    /// The field that the bed is a patch of, if it is one of a field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<FieldSummary>,
    /// What was asked of the trace and what it reached.
    pub stop: Stop,
    /// Numbers of the paths traced, from the first to one past the last.
    pub numbers: [u64; 2],
    /// Paths traced.
    pub paths: u64,
    /// Paths that saw past the target: they say nothing of it.
    pub missed: u64,
    /// Parts of paths that escaped downward, past the target's lower side.
    pub escaped_downward: u64,
    /// All hits.
    pub hits: u64,
    /// Paths given up inside a solid.
    pub inside: Vec<Inside>,
    /// What is seen of each prototype.
    pub coverage: BTreeMap<String, Cover>,
    /// Warnings about the bed.
    #[serde(default, skip_serializing_if = "Vec::is_empty", rename = "remarks")]
    pub warnings: Vec<Warning>,
    /// What the paths did.
    pub histogram: Histogram,
    /// The same by cells of the view in place of groups, where the target fills the view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cells: Option<Histogram>,
}

/// Paths given up inside a solid, where two overlap or all but touch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inside {
    /// The solid, by the name of its mesh.
    pub solid: String,
    /// The mesh that the paths had left; `None` for the floor and the sensor.
    pub from: Option<String>,
    /// Number of paths.
    pub paths: u64,
}

impl Table {
    /// Takes the counts of a tally. The caller sets everything else.
    pub fn count(&mut self, tally: &Tally, mesh_names: &[&str]) {
        self.paths = tally.paths;
        self.missed = tally.missed;
        self.escaped_downward = tally.escaped_downward;
        self.hits = tally.hits;
        // Meshes may share a name.
        let mut by_name: BTreeMap<(Option<&str>, &str), u64> = BTreeMap::new();
        for (&(from, solid), &paths) in &tally.inside {
            *by_name.entry((from.map(|mesh| mesh_names[mesh]), mesh_names[solid])).or_default() +=
                paths;
        }
        let inside = |((from, solid), paths): ((Option<&str>, &str), u64)| Inside {
            solid: solid.to_owned(),
            from: from.map(str::to_owned),
            paths,
        };
        self.inside = by_name.into_iter().map(inside).collect();
        self.inside.sort_by(|a, b| {
            b.paths.cmp(&a.paths).then_with(|| (&a.solid, &a.from).cmp(&(&b.solid, &b.from)))
        });
        for (material, &count) in self.materials.iter_mut().zip(&tally.first_hits) {
            material.first_hits = count;
        }
        self.histogram = Histogram::of(tally);
        self.cells = Histogram::by_cell(tally);
    }

    /// Where the geometry of several beds comes from. Beds that differ are draws; where fines of
    /// some touch, these tell what hulls change.
    ///
    /// # Panics
    /// Without a table.
    pub fn origin_of(beds: &[Self]) -> Origin {
        match beds[0].origin {
            Origin::Given if beds.len() > 1 => Origin::Drawn,
            _ if beds.iter().any(|bed| bed.origin == Origin::Drawn) => Origin::Drawn,
            origin => origin,
        }
    }

    /// The counts as a tally, to which more can be added.
    ///
    /// # Panics
    /// If `mesh_names` lacks a mesh that paths were inside of.
    pub fn tally(&self, mesh_names: &[&str]) -> Tally {
        let number = |name: &str| {
            mesh_names.iter().position(|known| *known == name).expect("the meshes are the same")
        };
        let mut tally = Tally::new(self.materials.len(), self.histogram.kept);
        tally.by_group = self.histogram.outcomes();
        tally.by_cell = self.cells.as_ref().map_or_else(Outcomes::default, Histogram::outcomes);
        tally.paths = self.paths;
        tally.missed = self.missed;
        tally.escaped_downward = self.escaped_downward;
        tally.hits = self.hits;
        tally.first_hits = self.materials.iter().map(|m| m.first_hits).collect();
        for inside in &self.inside {
            let meshes = (inside.from.as_deref().map(number), number(&inside.solid));
            *tally.inside.entry(meshes).or_default() += inside.paths;
        }
        tally
    }

    /// Notes in `stop` how precise the table is.
    pub fn judge(&mut self) -> Result<(), SpectrumError> {
        let wavelengths_um = self.stop.asked.grid.wavelengths_um();
        let bands = self.reflectances(&wavelengths_um)?;
        let precision = Precision::of(&self.histogram, &bands, self.stop.asked.tolerance);
        self.stop.reached = Reached {
            half_width: precision.weight.half_width(),
            widest_at_um: wavelengths_um[precision.widest],
            tolerance: precision.reached,
            trapped: precision.weight.trapped,
            ..self.stop.reached
        };
        Ok(())
    }

    /// The JSON keys in which two tables are not of one trace; empty if both have the same scene,
    /// spectra, rays and rules.
    pub fn differs_from(&self, other: &Self) -> Vec<String> {
        let keys = |table: &Self| match serde_json::to_value(table.rules()) {
            Ok(serde_json::Value::Object(keys)) => keys,
            _ => unreachable!("a table is an object"),
        };
        let (mine, theirs) = (keys(self), keys(other));
        let differ = |key: &&String| mine.get(*key) != theirs.get(*key);
        let all: BTreeSet<&String> = mine.keys().chain(theirs.keys()).collect();
        all.into_iter().filter(differ).cloned().collect()
    }

    /// The table without what its paths counted.
    fn rules(&self) -> Self {
        let reached = Reached::nothing(&self.stop.asked.grid);
        Self {
            stop: Stop { reached, ..self.stop.clone() },
            numbers: [0, 0],
            paths: 0,
            missed: 0,
            escaped_downward: 0,
            hits: 0,
            inside: Vec::new(),
            coverage: BTreeMap::new(),
            materials: self.materials.iter().map(TableMaterial::uncounted).collect(),
            histogram: Histogram::empty(self.histogram.kept),
            cells: None,
            ..self.clone()
        }
    }

    /// Paths that met the target.
    pub fn met(&self) -> u64 {
        self.paths - self.missed
    }

    /// The reflectance of each symbol of the histogram, by the materials' spectra; of nodes the factor
    /// of what was traced there.
    pub fn reflectances(&self, wavelengths_um: &[f64]) -> Result<Vec<Vec<f64>>, SpectrumError> {
        if let Some(nodes) = &self.nodes {
            return nodes.reflectances(&self.materials, wavelengths_um);
        }
        let spectra: Vec<&Spectrum> = self.materials.iter().map(|m| &m.spectrum).collect();
        reflectances(&spectra, self.histogram.kept, wavelengths_um)
    }

    /// The share of a band for which `auto` facets were opaque; `None` without such facets.
    pub fn opaque_share(&self, wavelength_um: f64) -> Option<f64> {
        match &self.nodes {
            Some(nodes) => nodes.opaque_share(wavelength_um),
            None => self.materials.iter().any(|m| m.auto).then_some(1.0),
        }
    }

    /// Share of the light that enters grains which opaque `auto` facets let through, at most; 0
    /// without such facets.
    pub fn lets_through(&self, wavelength_um: f64) -> f64 {
        let most = self.materials.iter().filter_map(|m| m.lets_through(wavelength_um));
        self.opaque_share(wavelength_um).unwrap_or(0.0) * most.fold(0.0, f64::max)
    }

    /// The mean weight that paths bring to the sky, for a reflectance of each symbol.
    pub fn weight(&self, reflectance: &[f64]) -> Mean {
        self.histogram.weight(reflectance)
    }
}
