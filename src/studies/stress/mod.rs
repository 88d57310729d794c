//! The atlas of failure. Each row drives one quantity from where it is harmless to where the method
//! fails. It compares the result with a closed form or a finer reference, and records the tool's
//! words.
//!
//! A row may break, but not in silence ([`Row::silent`]): a test holds every row to that.
//!
//! | rows | module |
//! |---|---|
//! | the words of each row | `rows.csv` |
//! | Eq. 2, temperatures, reflectance | `equations` |
//! | units, distance, detail, rays | `precision` |
//! | meshes, solids, views, patches | `geometry` |
//! | sampling of spectra, opacity | `spectra` |
//! | very small and very large numbers | `counts` |
//! | the rigid-body drop in Blender | `bullet` |

mod bullet;
mod counts;
mod equations;
mod geometry;
mod page;
mod precision;
mod shape;
mod spectra;
mod stage;

use std::path::Path;

use serde::Deserialize;
use serde_json::Value;

use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::table::Target;

use shape::Shape;
use stage::{Measured, Outcome, Stage};

pub use page::{line, write};

/// The settings of all sweeps.
pub struct Setting<'a> {
    /// Fewer points and rays: all rows without Blender take some ten seconds.
    pub quick: bool,
    /// The cache that remembers Blenders; results are not kept.
    pub cache: &'a Cache,
    /// The Blender to use; `None` searches for one.
    pub blender: Option<&'a Path>,
    /// Whether to leave out the rows that need Blender.
    pub without_blender: bool,
    /// Can stop the sweeps.
    pub monitor: &'a dyn Monitor,
}

impl Setting<'_> {
    /// The target of the rays of each point.
    fn target(&self) -> Target {
        Target { max_paths: 1 << 18, ..Target::of(if self.quick { 0.01 } else { 0.005 }) }
    }

    /// All values of a sweep, or every other one with both ends.
    fn values<'v>(&self, all: &'v [f64]) -> impl Iterator<Item = f64> + use<'v> {
        let (step, last) = (if self.quick { 2 } else { 1 }, all.len() - 1);
        (0..all.len()).filter(move |i| i.is_multiple_of(step) || *i == last).map(|i| all[i])
    }

    /// A point for each value of a sweep. `words` mark the tool's line about the failure.
    fn sweep(
        &self,
        all: &[f64],
        words: &str,
        measure: impl Fn(f64) -> Result<Measured, Error>,
    ) -> Result<Vec<Point>, Error> {
        self.values(all).map(|x| Ok(measure(x)?.at(x, words))).collect()
    }

    /// Traces a scene around one mesh at 9 um.
    fn run(&self, scene: Value, mesh: &Shape) -> Result<Outcome, Error> {
        Stage::new(self, scene, mesh).run()
    }
}

/// One point of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The swept value.
    pub x: f64,
    /// Error of the result, in the unit that the row states; `None` if the tool refused.
    pub error: Option<f64>,
    /// Half-width of the result's 95 % interval, or the limit that the row states.
    pub claimed: f64,
    /// The tool's line about the failure.
    pub said: Option<String>,
    /// The exit status.
    pub status: u8,
}

impl Point {
    /// Whether the error is more than twice the half-width, which chance exceeds once in ten
    /// thousand points.
    pub fn is_broken(&self) -> bool {
        self.error.is_some_and(|error| error > 2.0 * self.claimed)
    }

    /// Whether the tool gave no result.
    pub fn is_refused(&self) -> bool {
        self.error.is_none()
    }
}

/// One row of the atlas.
#[derive(Debug, Clone, Deserialize)]
pub struct Row {
    /// Its key: the name of its file and of its test.
    pub name: String,
    /// Heading.
    pub title: String,
    /// Name and unit of the swept quantity.
    pub swept: String,
    /// Whether the axis of the swept quantity is logarithmic.
    pub log: bool,
    /// The quantity of the error, and its reference.
    pub error: String,
    /// How the tool handles the failure.
    pub does: String,
    /// The points, ascending.
    #[serde(skip)]
    pub points: Vec<Point>,
    /// Why the row was left out.
    #[serde(skip)]
    pub left_out: Option<String>,
}

impl Row {
    /// The values at which a property holds, in words.
    pub fn range(&self, holds: impl Fn(&Point) -> bool) -> String {
        let at: Vec<bool> = self.points.iter().map(holds).collect();
        let x = |i: usize| short(self.points[i].x);
        let ends = |is: bool| {
            Some((at.iter().position(|&at| at == is)?, at.iter().rposition(|&at| at == is)?))
        };
        let Some((first, last)) = ends(true) else { return "nowhere".into() };
        let Some((first_not, last_not)) = ends(false) else { return "everywhere".into() };
        match (at[0], at[at.len() - 1]) {
            (false, true) => format!("from {}", x(first)),
            (true, false) => format!("up to {}", x(last)),
            (false, false) if first == last => format!("at {}", x(first)),
            (false, false) => format!("{} to {}", x(first), x(last)),
            (true, true) => format!("up to {} and from {}", x(first_not - 1), x(last_not + 1)),
        }
    }

    /// Points whose error is beyond what the result claims, without a word of the tool.
    pub fn silent(&self) -> Vec<&Point> {
        self.points.iter().filter(|point| point.is_broken() && point.said.is_none()).collect()
    }

    /// The tool's words at the largest error.
    pub fn says(&self) -> Option<&str> {
        let size = |p: &Point| p.error.unwrap_or(f64::INFINITY);
        let saying = self.points.iter().filter(|point| point.said.is_some());
        saying.max_by(|a, b| size(a).total_cmp(&size(b)))?.said.as_deref()
    }
}

/// A number for a table.
fn short(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

type Sweep = fn(&Setting) -> Result<Vec<Point>, Error>;

/// Names functions by themselves.
macro_rules! sweeps {
    ($($module:ident: $($name:ident)*;)*) => { &[$($((stringify!($name), $module::$name)),*),*] };
}

/// The sweep of every row by its name, in the order of the page.
const SWEEPS: &[(&str, Sweep)] = sweeps! {
    equations: sky_nears_target target_temperature two_temperatures sky_by_zenith white_cavity;
    precision: units distance_in_file distance_of_instance detail slivers gap facet_in_side;
    geometry: holes overlap coarse_sphere grazing_view grazing_mirror shallow_bed narrow_patch;
    spectra: christiansen_sampling reststrahlen_sampling not_opaque;
    counts: few_paths particles_of_field materials grains_of_recipe;
    bullet: bullet_substeps bullet_scale bullet_margin bullet_gravity;
};

/// The names of all rows, in the order of the page.
pub fn names() -> impl Iterator<Item = &'static str> {
    SWEEPS.iter().map(|(name, _)| *name)
}

/// Sweeps a row.
///
/// # Errors
/// A temporary folder that cannot be written, an interrupt.
///
/// # Panics
/// If there is no row of that name.
pub fn row(name: &str, setting: &Setting) -> Result<Row, Error> {
    let mut rows = csv::Reader::from_reader(include_str!("rows.csv").as_bytes());
    let mut rows = rows.deserialize().map(|row| row.expect("rows.csv has the columns of a row"));
    let mut row = rows.find(|row: &Row| row.name == name).expect("the name of a row");
    let (_, sweep) = SWEEPS.iter().find(|(known, _)| *known == name).expect("each row has a sweep");
    if name.starts_with("bullet") {
        row.left_out = bullet::left_out(setting);
    }
    if row.left_out.is_none() {
        row.points = sweep(setting)?;
    }
    Ok(row)
}
