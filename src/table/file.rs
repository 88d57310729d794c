//! Tables as files.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{FORMAT, Table, TableMaterial};
use crate::histogram::Histogram;
use crate::histogram::tally::CELLS;
use crate::radiometry::{Atmosphere, SkyTable};
use crate::scene::{Layers, Origin, Sky};
use crate::support::error::Failure;
use crate::support::file_error::FileError;
use crate::support::output::{self, OutputError};
use crate::support::random::GROUPS;

/// A table cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file cannot be read or is not a table.
    #[error(transparent)]
    File(#[from] FileError),
    /// The tables are not those of several packings.
    #[error(transparent)]
    Packings(FileError),
    /// The tables are not the parts of one trace.
    #[error(transparent)]
    Parts(FileError),
    /// No path met the target.
    #[error("no ray met anything: the sensor looks past the target")]
    Empty,
}

impl Failure for TableError {
    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::File(FileError::Read { .. }) => return None,
            Self::File(FileError::Wrong { .. }) => {
                "make it again: `soilsig trace SCENE --out table.json`"
            }
            Self::Empty => "compare the scene's domain with where its instances stand",
            Self::Packings(_) => "give tables of different beds of one recipe, traced alike",
            Self::Parts(_) => {
                "give the tables of all shards of one `soilsig trace --paths N --shard i/n`, each once"
            }
        };
        Some(hint.into())
    }
}

/// The key of a table that is read first.
#[derive(Deserialize)]
struct Version {
    soilsig_table: u32,
}

impl Table {
    /// Reads a table.
    ///
    /// # Errors
    /// The file cannot be read, is not a table of this version, or contradicts itself.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        Self::parse(&fs::read_to_string(path).map_err(FileError::read(path))?, path)
    }

    /// Reads a table from the text of a file.
    ///
    /// # Errors
    /// As for [`Table::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, TableError> {
        let json = |error: serde_json::Error| FileError::wrong(path, error.to_string());
        let Version { soilsig_table: version } = serde_json::from_str(text).map_err(json)?;
        if version != FORMAT {
            let problem =
                format!("version {version} is not known; this program reads version {FORMAT}");
            return Err(FileError::wrong(path, problem).into());
        }
        let table: Self = serde_json::from_str(text).map_err(json)?;
        if let Some(problem) = table.problem() {
            return Err(FileError::wrong(path, problem).into());
        }
        if table.met() == 0 {
            return Err(TableError::Empty);
        }
        Ok(table)
    }

    /// The first contradiction in a table, if there is one.
    fn problem(&self) -> Option<String> {
        if let Some((place, problem)) = self.layers.as_ref().and_then(Layers::problem) {
            return Some(format!("layers.{place}: {problem}"));
        }
        let materials = self.materials.len();
        let checked = self.histogram.check(materials, GROUPS).and_then(|()| {
            self.cells
                .as_ref()
                .map_or(Ok(()), |cells| cells.check(materials, (CELLS * CELLS).into()))
        });
        if let Err(problem) = checked {
            return Some(problem);
        }
        let temperatures = self.materials.iter().filter_map(|m| m.temperature_k);
        let is_temperature = |k: f64| k.is_finite() && k > 0.0;
        let [first, end] = self.numbers;
        let problems = [
            (
                self.histogram.paths() + self.missed as f64 != self.paths as f64,
                "the states do not add up to the paths",
            ),
            (
                self.cells.as_ref().is_some_and(|cells| !cells.counts_as(&self.histogram)),
                "the cells count other paths than the groups",
            ),
            (
                end.checked_sub(first) != Some(self.paths),
                "the numbers of the paths are not as many as the paths",
            ),
            (
                !temperatures.chain([self.temperature_k]).all(is_temperature),
                "a temperature is not above 0 K",
            ),
            (
                self.lacks_order(),
                "facets differ in temperature, but the states do not record the order of hits or their layers",
            ),
            (
                !self.sky_radiance.as_ref().is_none_or(SkyTable::is_sound),
                "sky_radiance is malformed: unsorted, negative, too bright, or of unequal columns",
            ),
            (
                self.sky_is_by_zenith() && self.histogram.kept.zeniths == 1,
                "the sky is by zenith angle, but the states are not",
            ),
            (
                !self.atmosphere.as_ref().is_none_or(Atmosphere::is_sound),
                "atmosphere is malformed: unsorted, out of range, or columns of different length",
            ),
            (
                self.nodes.is_some() && self.layers.is_some(),
                "light through grains is traced at one temperature, but there are layers",
            ),
            (
                usize::from(self.histogram.kept.nodes)
                    != self.nodes.as_ref().map_or(0, |nodes| nodes.wavelength_um.len()),
                "the histogram has other nodes than the table",
            ),
            (
                self.floor.is_some_and(|floor| floor >= materials),
                "floor is not the index of a material",
            ),
        ];
        let problem = problems.into_iter().find(|(is_wrong, _)| *is_wrong);
        let problem = problem.map(|(_, problem)| problem.to_owned());
        problem
            .or_else(|| self.sky_temperature_k.as_ref().and_then(Sky::problem))
            .or_else(|| self.materials.iter().find_map(|m| m.spectrum.problem()))
            .or_else(|| self.nodes.as_ref().and_then(|nodes| nodes.problem(materials)))
    }

    /// Reads the tables of several packings of one recipe.
    ///
    /// # Errors
    /// Besides those of [`Table::read`]: a table of another scene than the first, or the same bed
    /// twice.
    pub fn read_packings(paths: &[PathBuf]) -> Result<Vec<Self>, TableError> {
        let tables: Vec<Self> =
            paths.iter().map(|path| Self::read(path)).collect::<Result<_, _>>()?;
        let of = |t: &Self| {
            (
                t.scene.clone(),
                t.materials.iter().map(TableMaterial::uncounted).collect::<Vec<_>>(),
                (t.temperature_k, t.layers.clone()),
                (t.sky_temperature_k.clone(), t.sky_radiance.clone(), t.atmosphere.clone()),
                (t.view, t.histogram.kept),
                // A bed in the open alone has no cells.
                (t.cells.is_some(), t.field.is_some()),
            )
        };
        for (i, table) in tables.iter().enumerate().skip(1) {
            let twin = tables[..i].iter().position(|t| t.scene_sha256 == table.scene_sha256);
            let nodes = [table, &tables[0]].map(|t| t.nodes.as_ref());
            let are_alike = match nodes {
                [Some(a), Some(b)] => a.are_those_of(b),
                _ => true,
            };
            let problem = if of(table) != of(&tables[0]) || !are_alike {
                format!("this is not a packing of the scene of {}", paths[0].display())
            } else if let Some(twin) = twin {
                let other = paths[twin].display();
                if tables[twin].numbers == table.numbers {
                    format!("this is the same bed as {other}")
                } else {
                    format!(
                        "this is another part of the trace of {other}: `soilsig merge` puts them \
                         together"
                    )
                }
            } else {
                continue;
            };
            return Err(TableError::Packings(FileError::wrong(&paths[i], problem)));
        }
        if let Some((i, problem)) = unpaired(&tables) {
            return Err(TableError::Packings(FileError::wrong(&paths[i], problem)));
        }
        Ok(tables)
    }

    /// Writes the table as JSON, one state a line.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        output::bytes(path, self.text().as_bytes())
    }

    /// The text of its file.
    pub fn text(&self) -> String {
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
        text
    }
}

/// A table that does not go with the others: hulls and fines that touch go together in pairs.
fn unpaired(tables: &[Table]) -> Option<(usize, &'static str)> {
    let of = |origin| tables.iter().enumerate().filter(move |(_, t)| t.origin == origin);
    let (_, _) = (of(Origin::DrawnApart).next()?, of(Origin::Drawn).next()?);
    let is_pair = |touching: &Table| {
        touching.drop.is_some() && of(Origin::DrawnApart).any(|(_, t)| t.drop == touching.drop)
    };
    let (alone, _) = of(Origin::Drawn).find(|(_, t)| !is_pair(t)).or_else(|| {
        let few = of(Origin::Drawn).count() < 2;
        of(Origin::Drawn).next().filter(|_| few)
    })?;
    Some((
        alone,
        "its fines touch, those of other beds do not: give the beds of hulls of the same drops \
         too, of two drops or more, or leave out one of both kinds",
    ))
}
