//! The study file: a scene, and what is varied in it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::histogram::estimate;
use crate::pipeline::Source;
use crate::scene::{Change, Facets, Grid, Scene, shipped};
use crate::support::error::{Error, Failure};
use crate::support::file_error::FileError;

/// The format's version, the value of `soilsig_study`.
pub(super) const FORMAT: u32 = 1;

/// Most points of a study.
pub const MOST_POINTS: usize = 1_000_000;

/// The key by which an axis or `set` gives powders' facets another meaning.
pub(super) const FACETS: &str = "facets";

/// A study file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct StudyError(#[from] FileError);

impl Failure for StudyError {
    fn hint(&self) -> Option<String> {
        self.0.hint().or_else(|| {
            Some(
                "`soilsig schema study` prints the format; docs/guide/sweeps.md explains it".into(),
            )
        })
    }
}

/// A study: beds of one scene at many points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// The study file. The scene file that it names is relative to its folder.
    #[serde(skip)]
    pub file: PathBuf,
    /// Version of the format: 1.
    pub soilsig_study: u32,
    /// Name of the study.
    pub name: String,
    /// Free text: the heading of charts and page. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// The scene: a shipped coverage, or a file relative to the study file.
    pub source: Source,
    /// Values that replace the scene's at every point, each as `KEY=VALUE`. `facets` is a key too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>"))]
    pub set: Vec<Change>,
    /// What is varied. Every value of an axis meets every value of the others.
    pub axes: Vec<Axis>,
    /// How axes with a `range` and no `number` are sampled, all of them together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample: Option<Sample>,
    /// Seeds: at each point a bed is dropped and traced for each. Default: 1.
    #[serde(default = "one_seed")]
    #[cfg_attr(feature = "schema", schemars(length(min = 1, max = estimate::MOST)))]
    pub seeds: Vec<u64>,
    /// Half-width of the 95 % interval in emissivity that every band of a point is to reach.
    /// Default: 0.005.
    #[serde(default = "usual_tolerance")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1)))]
    pub tolerance: f64,
    /// Most paths of a bed. Default: 67108864.
    #[serde(default = "usual_paths")]
    #[cfg_attr(feature = "schema", schemars(range(min = 2)))]
    pub max_paths: u64,
    /// The bands. Default: 7.5 to 14 um in steps of 0.01 um.
    #[serde(default = "usual_bands")]
    pub bands: Grid,
    /// What is kept of each bed. Default: `tables`.
    #[serde(default)]
    pub keep: Keep,
}

fn one_seed() -> Vec<u64> {
    vec![1]
}

const fn usual_tolerance() -> f64 {
    0.005
}

const fn usual_paths() -> u64 {
    1 << 26
}

const fn usual_bands() -> Grid {
    Grid::PAPER
}

/// Something that is varied: give one of `values`, `range` and `cases`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Name of the axis: a column of the results.
    #[cfg_attr(feature = "schema", schemars(regex(pattern = r"^[A-Za-z][A-Za-z0-9_]{0,39}$")))]
    pub name: String,
    /// The key that is varied, as `--set` takes it, or several that take the same value; of
    /// `cases` none.
    #[serde(default, skip_serializing_if = "Keys::is_none")]
    pub key: Keys,
    /// Values, each any JSON.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<Value>>,
    /// A range of numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<Range>,
    /// Named changes of several keys.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cases: Option<Vec<Case>>,
}

/// One key, or several.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged, expecting = "a key is a text, or a list of texts")]
pub enum Keys {
    /// One.
    One(String),
    /// Several.
    Several(Vec<String>),
}

impl Default for Keys {
    fn default() -> Self {
        Self::Several(Vec::new())
    }
}

impl Keys {
    pub(super) fn all(&self) -> &[String] {
        match self {
            Self::One(key) => std::slice::from_ref(key),
            Self::Several(keys) => keys,
        }
    }

    pub(super) fn is_none(&self) -> bool {
        self.all().is_empty()
    }
}

/// A range of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// First number.
    pub from: f64,
    /// Last number.
    pub to: f64,
    /// How many numbers, both ends included, equally spaced. Without it the range is sampled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 2)))]
    pub number: Option<usize>,
    /// Whether the logarithms are equally spaced. Default: no.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub log: bool,
    /// Whether numbers are rounded to whole ones. Default: no.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub whole: bool,
}

impl Range {
    /// The number at a share of the range, 0 to 1, rounded to twelve digits.
    pub(super) fn at(&self, share: f64) -> Value {
        use crate::support::math;
        let Self { from, to, log, whole, .. } = *self;
        let number =
            if log { from * math::pow(to / from, share) } else { from + (to - from) * share };
        let number = if whole { number.round() } else { number };
        let number: f64 = format!("{number:.11e}").parse().expect("a number");
        // Keys of whole numbers take no 3.0, and keys of others take 3.
        if number.fract() == 0.0 && number.abs() < 9e15 {
            Value::from(number as i64)
        } else {
            Value::from(number)
        }
    }
}

/// Changes under one name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name in the results.
    pub name: String,
    /// Changes of the scene, each as `KEY=VALUE`.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>"))]
    pub set: Vec<Change>,
}

/// How ranges are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// The method.
    pub method: Method,
    /// The number of points. Of `sobol` a power of two covers the ranges best.
    pub points: usize,
    /// Seed of the points. Default: 1.
    #[serde(default = "first_seed")]
    pub seed: u64,
}

const fn first_seed() -> u64 {
    1
}

/// A way to sample several ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Sobol' points with Owen scrambling.
    Sobol,
    /// A Latin hypercube: each of `points` parts of every range has one point.
    LatinHypercube,
}

/// What is kept of each bed, beside its record.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// The bounce table: some 20 kB.
    #[default]
    Tables,
    /// The signature as well: some 100 kB.
    Signatures,
    /// The bed as well, for `soilsig trace` and `soilsig image`: some megabytes.
    Beds,
}

impl Study {
    /// Reads a study file and checks it.
    ///
    /// # Errors
    /// The file cannot be read, is no study, or asks for what there is not.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        let text = fs::read_to_string(path).map_err(FileError::read(path))?;
        let mut study: Self = serde_json::from_str(text.trim_start_matches('\u{feff}'))
            .map_err(|error| FileError::wrong(path, error.to_string()))?;
        if let Some((place, problem)) = study.problem() {
            return Err(FileError::wrong_at(path, place, problem).into());
        }
        path.clone_into(&mut study.file);
        Ok(study)
    }

    /// How many points its axes make; `None` if no number holds them.
    pub(super) fn points(&self) -> Option<usize> {
        let sampled = self.sample.map_or(1, |sample| sample.points);
        let mut of_axes = self.axes.iter().filter(|axis| !axis.is_sampled()).map(Axis::places);
        of_axes.try_fold(sampled, usize::checked_mul)
    }

    /// Its scene, without any changes.
    pub fn scene(&self) -> Result<Scene, Error> {
        match &self.source {
            Source::Scene(path) => {
                let folder = self.file.parent().unwrap_or(Path::new(""));
                Ok(Scene::read(&folder.join(path))?)
            }
            Source::Coverage(name) => Ok(shipped::named(name).ok_or_else(|| {
                let problem = format!("{name:?} is not a coverage");
                StudyError::from(FileError::wrong_at(&self.file, "source.coverage", problem))
            })?),
        }
    }

    /// Heading of charts and page.
    pub fn title(&self) -> &str {
        self.description.as_ref().unwrap_or(&self.name)
    }
}

impl Axis {
    /// Whether its points are sampled together with others'.
    pub(super) fn is_sampled(&self) -> bool {
        self.range.is_some_and(|range| range.number.is_none())
    }

    /// How many places it has, unless it is sampled.
    pub(super) fn places(&self) -> usize {
        let of_range = self.range.and_then(|range| range.number);
        let values = self.values.as_ref().map(Vec::len);
        values.or(self.cases.as_ref().map(Vec::len)).or(of_range).unwrap_or_default()
    }

    /// The keys that it varies.
    pub(super) fn keys(&self) -> BTreeSet<&str> {
        let of_cases = self.cases.iter().flatten().flat_map(|case| &case.set).map(Change::key);
        self.key.all().iter().map(String::as_str).chain(of_cases).collect()
    }
}

/// Facets by the key `facets`.
pub(super) fn facets(value: &Value) -> Result<Facets, String> {
    serde_json::from_value(value.clone()).map_err(|error| error.to_string())
}
