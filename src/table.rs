//! The bounce table: everything that spectra, temperature and sky need to know of a traced bed.
//!
//! A path that hits material m n_m times before it reaches the sky carries
//! W = product of rho_m^n_m, rho = 1 - emissivity (Kirchhoff). The joint histogram of (n_1, n_2, ...) is
//! therefore enough to evaluate the bed for any spectra, and costs no further tracing.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::coverage::Cover;
use crate::output::{self, OutputError};
use crate::scene::View;
use crate::spectrum::Spectrum;
use crate::tally::{State, Tally};

/// The format's version, the value of `soilsig_table`.
pub const FORMAT: u32 = 1;

/// A table cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file cannot be read.
    #[error("cannot read the table {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a table.
    #[error("{}: {problem}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// Tables that are not those of several packings.
    #[error("{}: {problem}", path.display())]
    Packings {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// No path met the target.
    #[error("no ray met anything: the sensor looks past the target")]
    Empty,
}

impl TableError {
    /// What the user can do about it.
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Form { .. } => "make it again: `soilsig trace SCENE --out table.json`".into(),
            Self::Empty => "compare the scene's domain with where its instances stand".into(),
            Self::Packings { .. } => {
                "give tables of different beds of one recipe, traced alike".into()
            }
            Self::Read { .. } => return None,
        })
    }
}

/// A traced bed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Version of the format: 1.
    pub soilsig_table: u32,
    /// The scene's name.
    pub scene: String,
    /// SHA-256 of the scene file and its meshes.
    pub scene_sha256: String,
    /// Temperature of the scene, kelvin.
    pub temperature_k: f64,
    /// Temperature of the sky, kelvin, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_temperature_k: Option<f64>,
    /// The direction to the sensor.
    pub view: View,
    /// Seed of the paths.
    pub seed: u64,
    /// Hits after which a path was given up.
    pub max_bounces: u16,
    /// What the counts stand for, in their order.
    pub materials: Vec<TableMaterial>,
    /// Index of the floor's material, if nothing else is made of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<usize>,
    /// Why the trace ended where it did.
    pub stop: Stop,
    /// Paths traced.
    pub paths: u64,
    /// Paths that met nothing, which say nothing of the target.
    pub missed: u64,
    /// Paths that left past the target's lower side.
    pub escaped_downward: u64,
    /// Surfaces hit in all.
    pub hits: u64,
    /// Paths given up inside a solid; they are among the trapped.
    pub inside: Vec<Inside>,
    /// What is seen of each prototype.
    pub coverage: BTreeMap<String, Cover>,
    /// Hits on each material before the sky, and how many paths had them.
    pub escaped: Vec<(State, u64)>,
    /// The same for paths that were given up.
    pub trapped: Vec<(State, u64)>,
}

/// A material as the table counts it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableMaterial {
    /// The scene's name of it.
    pub name: String,
    /// Its emissivity, unless `signature` is given another.
    pub spectrum: Spectrum,
    /// First hits: what of the sensor's view it fills.
    pub first_hits: u64,
}

/// Paths that came to be inside a solid, where two overlap or all but touch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inside {
    /// The solid, by the name of its mesh.
    pub solid: String,
    /// The mesh that the paths had left; `None` for the floor and the sensor.
    pub from: Option<String>,
    /// How many.
    pub paths: u64,
}

/// What was asked of the trace and what it reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Half-width asked for, emissivity, at 95 %.
    pub tolerance: f64,
    /// Widest half-width of any band looked at.
    pub half_width: f64,
    /// Where it is, um.
    pub widest_at_um: f64,
    /// Whether the tolerance was reached.
    pub reached: bool,
    /// What of the half-width paths that were given up leave open: more paths do not lessen it.
    pub trapped: f64,
}

/// Mean and spread of the weight that a path brings to the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    /// Mean over all paths that met the target; trapped paths count with half of their bound.
    pub mean: f64,
    /// Standard error of the mean.
    pub standard_error: f64,
    /// Half of the mean weight of trapped paths: the mean is known no better than that.
    pub trapped: f64,
}

/// Quantile of the standard normal distribution for two-sided 95 %.
pub const Z_95: f64 = 1.959_963_985;

impl Weight {
    /// Half-width of the 95 % interval: noise of the rays and what trapped paths leave open.
    pub fn half_width(&self) -> f64 {
        Z_95 * self.standard_error + self.trapped
    }
}

/// Powers of a reflectance that are computed beforehand.
const POWERS: usize = 64;

/// The mean weight for one reflectance of each material.
///
/// Sums run over the states in the order given: the same order gives the same bits.
pub fn weight<'a>(
    escaped: impl Iterator<Item = (&'a [u16], u64)>,
    trapped: impl Iterator<Item = (&'a [u16], u64)>,
    reflectance: &[f64],
) -> Weight {
    // States are many, powers few.
    let powers: Vec<Vec<f64>> = reflectance
        .iter()
        .map(|rho| {
            std::iter::successors(Some(1.0), |power| Some(power * rho)).take(POWERS).collect()
        })
        .collect();
    let power = |material: usize, n: u16| {
        let listed = powers[material].get(usize::from(n)).copied();
        listed.unwrap_or_else(|| reflectance[material].powi(i32::from(n)))
    };
    let product = |state: &[u16]| -> f64 {
        state.iter().enumerate().map(|(material, &n)| power(material, n)).product()
    };
    let (mut paths, mut sum, mut squares, mut open) = (0.0, 0.0, 0.0, 0.0);
    let states = escaped.map(|state| (state, 1.0)).chain(trapped.map(|state| (state, 0.5)));
    for ((state, count), share) in states {
        let (count, w) = (count as f64, share * product(state));
        paths += count;
        sum += count * w;
        squares += count * w * w;
        if share < 1.0 {
            open += count * w;
        }
    }
    let mean = sum / paths;
    // One path tells nothing of the spread: then it is the widest that a weight from 0 to 1 can have.
    let variance = if paths < 2.0 {
        0.25
    } else {
        (squares / paths - mean * mean).max(0.0) * paths / (paths - 1.0)
    };
    Weight { mean, standard_error: (variance / paths).sqrt(), trapped: open / paths }
}

fn pairs(states: &[(State, u64)]) -> impl Iterator<Item = (&[u16], u64)> {
    states.iter().map(|(state, count)| (&**state, *count))
}

/// Histogram states in lexical order.
pub fn sorted(states: &HashMap<State, u64>) -> Vec<(State, u64)> {
    let mut list: Vec<_> = states.iter().map(|(state, &count)| (state.clone(), count)).collect();
    list.sort_unstable();
    list
}

impl Table {
    /// The counts of a tally, with everything else that a table holds left to the caller.
    pub fn count(&mut self, tally: &Tally, mesh_names: &[&str]) {
        self.paths = tally.paths;
        self.missed = tally.missed;
        self.escaped_downward = tally.escaped_downward;
        self.hits = tally.hits;
        let name = |mesh: usize| mesh_names[mesh].to_owned();
        self.inside = tally
            .inside
            .iter()
            .map(|(&(from, solid), &paths)| Inside {
                solid: name(solid),
                from: from.map(name),
                paths,
            })
            .collect();
        self.inside.sort_by_key(|inside| std::cmp::Reverse(inside.paths));
        for (material, &count) in self.materials.iter_mut().zip(&tally.first_hits) {
            material.first_hits = count;
        }
        self.escaped = sorted(&tally.escaped);
        self.trapped = sorted(&tally.trapped);
    }

    /// Paths that met the target.
    pub fn met(&self) -> u64 {
        self.paths - self.missed
    }

    /// The mean weight for one reflectance of each material.
    pub fn weight(&self, reflectance: &[f64]) -> Weight {
        weight(pairs(&self.escaped), pairs(&self.trapped), reflectance)
    }

    /// Reads a table.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        let text = fs::read_to_string(path)
            .map_err(|source| TableError::Read { path: path.to_owned(), source })?;
        let wrong = |problem: String| TableError::Form { path: path.to_owned(), problem };
        let table: Self = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        if table.soilsig_table != FORMAT {
            return Err(wrong(format!(
                "version {} is not known; this program reads version {FORMAT}",
                table.soilsig_table
            )));
        }
        let states = || table.escaped.iter().chain(&table.trapped);
        if states().any(|(state, _)| state.len() != table.materials.len()) {
            return Err(wrong("a state does not count each material".into()));
        }
        if states().map(|(_, count)| count).sum::<u64>() + table.missed != table.paths {
            return Err(wrong("the states do not add up to the paths".into()));
        }
        let temperatures = [Some(table.temperature_k), table.sky_temperature_k];
        if temperatures.into_iter().flatten().any(|k| !(k.is_finite() && k > 0.0)) {
            return Err(wrong("a temperature is not above 0 K".into()));
        }
        if table.floor.is_some_and(|floor| floor >= table.materials.len()) {
            return Err(wrong("the floor's material is none of the materials".into()));
        }
        if let Some(problem) = table.materials.iter().find_map(|m| m.spectrum.problem()) {
            return Err(wrong(problem));
        }
        if table.met() == 0 {
            return Err(TableError::Empty);
        }
        Ok(table)
    }

    /// Reads the tables of several packings of one recipe.
    ///
    /// # Errors
    /// Besides those of [`Table::read`]: a table of another scene than the first, or the same bed twice.
    pub fn read_packings(paths: &[PathBuf]) -> Result<Vec<Self>, TableError> {
        let tables: Vec<Self> =
            paths.iter().map(|path| Self::read(path)).collect::<Result<_, _>>()?;
        for (i, table) in tables.iter().enumerate().skip(1) {
            let of = |t: &Self| {
                let named: Vec<_> =
                    t.materials.iter().map(|m| (m.name.clone(), m.spectrum.clone())).collect();
                (t.scene.clone(), named, t.temperature_k, t.sky_temperature_k, t.view)
            };
            let twin = tables[..i].iter().position(|t| t.scene_sha256 == table.scene_sha256);
            let problem = if of(table) != of(&tables[0]) {
                format!("this is no packing of the scene of {}", paths[0].display())
            } else if let Some(twin) = twin {
                format!("this is the same bed as {}", paths[twin].display())
            } else {
                continue;
            };
            return Err(TableError::Packings { path: paths[i].clone(), problem });
        }
        Ok(tables)
    }

    /// Writes the table as JSON, one state a line.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        let head = Self { escaped: Vec::new(), trapped: Vec::new(), ..self.clone() };
        let mut text = serde_json::to_string_pretty(&head).expect("a table is plain data");
        for (key, states) in [("escaped", &self.escaped), ("trapped", &self.trapped)] {
            let lines: Vec<String> = states
                .iter()
                .map(|state| format!("    {}", serde_json::to_string(state).expect("plain data")))
                .collect();
            if !lines.is_empty() {
                text = text.replace(
                    &format!("\"{key}\": []"),
                    &format!("\"{key}\": [\n{}\n  ]", lines.join(",\n")),
                );
            }
        }
        text.push('\n');
        output::bytes(path, text.as_bytes())
    }
}
