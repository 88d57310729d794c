//! Tables as files.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{FORMAT, Table, TableMaterial};
use crate::histogram::Histogram;
use crate::histogram::tally::CELLS;
use crate::scene::Sky;
use crate::support::error::Failure;
use crate::support::output::{self, OutputError};
use crate::support::random::GROUPS;

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
    /// Tables that are not the parts of one trace.
    #[error("{}: {problem}", path.display())]
    Parts {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// No path met the target.
    #[error("no ray met anything: the sensor looks past the target")]
    Empty,
}

impl Failure for TableError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Form { .. } => "make it again: `soilsig trace SCENE --out table.json`".into(),
            Self::Empty => "compare the scene's domain with where its instances stand".into(),
            Self::Packings { .. } => {
                "give tables of different beds of one recipe, traced alike".into()
            }
            Self::Parts { .. } => {
                "give the tables of all shards of one `soilsig trace --paths N --shard i/n`, each once"
                    .into()
            }
            Self::Read { .. } => return None,
        })
    }
}

/// What of a table is read first.
#[derive(Deserialize)]
struct Version {
    soilsig_table: u32,
}

impl Table {
    /// Reads a table.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        let text = fs::read_to_string(path)
            .map_err(|source| TableError::Read { path: path.to_owned(), source })?;
        let wrong = |problem: String| TableError::Form { path: path.to_owned(), problem };
        let Version { soilsig_table: version } =
            serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        if version != FORMAT {
            return Err(wrong(format!(
                "version {version} is not known; this program reads version {FORMAT}"
            )));
        }
        let table: Self = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        let materials = table.materials.len();
        table.histogram.check(materials, GROUPS).map_err(wrong)?;
        if table.histogram.paths() + table.missed as f64 != table.paths as f64 {
            return Err(wrong("the states do not add up to the paths".into()));
        }
        if let Some(cells) = &table.cells {
            cells.check(materials, (CELLS * CELLS).into()).map_err(wrong)?;
            if !cells.counts_as(&table.histogram) {
                return Err(wrong("the cells count other paths than the groups".into()));
            }
        }
        if table.numbers[1].checked_sub(table.numbers[0]) != Some(table.paths) {
            return Err(wrong("the numbers of the paths are not as many as the paths".into()));
        }
        let own = table.materials.iter().filter_map(|m| m.temperature_k);
        if own.chain([table.temperature_k]).any(|k| !(k.is_finite() && k > 0.0)) {
            return Err(wrong("a temperature is not above 0 K".into()));
        }
        if table.lacks_order() {
            return Err(wrong(
                "materials differ in temperature, and the states do not keep the order of hits"
                    .into(),
            ));
        }
        if let Some(problem) = table.sky_temperature_k.as_ref().and_then(Sky::problem) {
            return Err(wrong(problem));
        }
        if table.sky_radiance.as_ref().is_some_and(|sky| !sky.is_sound()) {
            return Err(wrong("the sky's radiance is none".into()));
        }
        if table.sky_is_by_zenith() && table.histogram.kept.zeniths == 1 {
            return Err(wrong("the sky is by zenith angle, and the states are not".into()));
        }
        if table.atmosphere.as_ref().is_some_and(|atmosphere| !atmosphere.is_sound()) {
            return Err(wrong("the atmosphere is none".into()));
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
                let materials: Vec<_> = t.materials.iter().map(TableMaterial::uncounted).collect();
                let kept = t.histogram.kept;
                (
                    t.scene.clone(),
                    materials,
                    t.temperature_k,
                    (t.sky_temperature_k.clone(), t.sky_radiance.clone(), t.atmosphere.clone()),
                    t.view,
                    kept,
                    // Of a bed in the open alone cells are not counted.
                    (t.cells.is_some(), t.field.is_some()),
                )
            };
            let twin = tables[..i].iter().position(|t| t.scene_sha256 == table.scene_sha256);
            let problem = if of(table) != of(&tables[0]) {
                format!("this is no packing of the scene of {}", paths[0].display())
            } else if let Some(twin) = twin.filter(|&twin| tables[twin].numbers != table.numbers) {
                let other = paths[twin].display();
                format!(
                    "this is another part of the trace of {other}: `soilsig merge` puts them together"
                )
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
        let histogram = Histogram::empty(self.histogram.kept);
        let head = Self { histogram, cells: None, ..self.clone() };
        let mut text = serde_json::to_string_pretty(&head).expect("a table is plain data");
        // The histograms come last.
        text.truncate(text.rfind("\n  \"histogram\"").expect("it is in there"));
        text += "\n  \"histogram\": ";
        text += &self.histogram.json();
        if let Some(cells) = &self.cells {
            text += ",\n  \"cells\": ";
            text += &cells.json();
        }
        text += "\n}\n";
        output::bytes(path, text.as_bytes())
    }
}
