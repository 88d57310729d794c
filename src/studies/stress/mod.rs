//! The atlas of failure: each row drives one thing from where it is harmless to where the method fails, through the
//! tool's own code, measures the error against a closed form or a finer reference, and notes what the tool says of it.
//!
//! A row may break; what it may not do is break in silence ([`Row::silent`]). `tests/stress.rs` holds every row to that,
//! docs/stability.md shows them.
//!
//! | family | module |
//! |---|---|
//! | Eq. 2, temperatures, reflectance | `equations` |
//! | units, distance, detail, rays | `precision` |
//! | meshes, solids, views, patches | `geometry` |
//! | sampling of spectra, opacity | `spectra` |
//! | tiny and huge numbers | `counts` |
//! | the rigid-body drop, in Blender | `bullet` |

mod bullet;
mod counts;
mod equations;
mod geometry;
mod page;
mod precision;
mod scenes;
mod spectra;

use std::path::Path;

use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::table::Target;

pub use page::{line, write};

/// How thoroughly rows are swept, and by what.
pub struct Setting<'a> {
    /// Fewer points and rays: all rows without Blender in some ten seconds.
    pub quick: bool,
    /// Where it is noted which Blenders were asked what they are; results are not kept.
    pub cache: &'a Cache,
    /// The Blender to use, if not the one that is found.
    pub blender: Option<&'a Path>,
    /// Whether rows that need a Blender are left out.
    pub without_blender: bool,
    /// Whoever may stop it.
    pub monitor: &'a dyn Monitor,
}

impl Setting<'_> {
    /// What the rays of a point are to reach.
    fn target(&self) -> Target {
        Target { max_paths: 1 << 18, ..Target::of(if self.quick { 0.01 } else { 0.005 }) }
    }

    /// All points of a sweep, or every other one with both ends.
    fn of<T: Copy>(&self, all: &[T]) -> Vec<T> {
        let kept = |i: usize| !self.quick || i.is_multiple_of(2) || i + 1 == all.len();
        (0..all.len()).filter(|&i| kept(i)).map(|i| all[i]).collect()
    }
}

/// One point of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The value of what is swept.
    pub x: f64,
    /// Error of the result, in the unit that the row states; `None` where there is none since the tool refused.
    pub error: Option<f64>,
    /// How far the result claims to be known: half-width of its 95 % interval, or the limit that the row states.
    pub claimed: f64,
    /// What the tool said of it: the line with the row's words.
    pub said: Option<String>,
    /// The exit status that goes with it.
    pub status: u8,
}

impl Point {
    /// Whether the error is beyond what the result claims: twice its half-width, which chance alone passes once in
    /// ten thousand points.
    pub fn is_broken(&self) -> bool {
        self.error.is_some_and(|error| error > 2.0 * self.claimed)
    }

    /// Whether the tool refused to give a result.
    pub fn is_refused(&self) -> bool {
        self.error.is_none()
    }
}

/// What is on the horizontal axis of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swept {
    /// Name and unit.
    pub name: &'static str,
    /// Whether its axis is logarithmic.
    pub log: bool,
}

/// One row of the atlas.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its key: the name of its file and of its test.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What is swept.
    pub swept: Swept,
    /// What the error is of, and against what.
    pub error: &'static str,
    /// What the tool does about it.
    pub does: &'static str,
    /// The points, ascending.
    pub points: Vec<Point>,
    /// Why the row was left out, if it was.
    pub left_out: Option<String>,
}

impl Row {
    /// Where a property holds, in words.
    pub fn range(&self, holds: impl Fn(&Point) -> bool) -> String {
        let at: Vec<bool> = self.points.iter().map(holds).collect();
        let x = |i: usize| short(self.points[i].x);
        let Some(first) = at.iter().position(|&is| is) else { return "nowhere".into() };
        if at.iter().all(|&is| is) {
            return "everywhere".into();
        }
        let last = at.iter().rposition(|&is| is).expect("there is one");
        let gap = at.iter().position(|&is| !is).expect("there is one");
        match (at[0], at[at.len() - 1]) {
            (false, true) => format!("from {}", x(first)),
            (true, false) => format!("up to {}", x(last)),
            (false, false) if first == last => format!("at {}", x(first)),
            (false, false) => format!("{} to {}", x(first), x(last)),
            (true, true) => {
                let again = at.iter().rposition(|&is| !is).expect("there is one") + 1;
                format!("up to {} and from {}", x(gap - 1), x(again))
            }
        }
    }

    /// Points at which the result is wrong beyond what it claims, and the tool says nothing.
    pub fn silent(&self) -> Vec<&Point> {
        self.points.iter().filter(|point| point.is_broken() && point.said.is_none()).collect()
    }

    /// What the tool says where it says most.
    pub fn says(&self) -> Option<&str> {
        let saying = self.points.iter().filter(|point| point.said.is_some());
        let worst = saying.max_by(|a, b| {
            let size = |p: &Point| p.error.unwrap_or(f64::INFINITY);
            size(a).total_cmp(&size(b))
        });
        worst.and_then(|point| point.said.as_deref())
    }
}

/// A number in a table.
fn short(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

type Make = fn(&Setting) -> Result<Row, Error>;

/// Every row by its name, in the order of the page.
const ROWS: [(&str, Make); 30] = [
    ("sky_nears_target", equations::sky_nears_target),
    ("target_temperature", equations::target_temperature),
    ("two_temperatures", equations::two_temperatures),
    ("sky_by_zenith", equations::sky_by_zenith),
    ("white_cavity", equations::white_cavity),
    ("units", precision::units),
    ("distance_in_file", precision::distance_in_file),
    ("distance_of_instance", precision::distance_of_instance),
    ("detail", precision::detail),
    ("slivers", precision::slivers),
    ("gap", precision::gap),
    ("facet_in_side", precision::facet_in_side),
    ("holes", geometry::holes),
    ("overlap", geometry::overlap),
    ("coarse_sphere", geometry::coarse_sphere),
    ("grazing_view", geometry::grazing_view),
    ("grazing_mirror", geometry::grazing_mirror),
    ("shallow_bed", geometry::shallow_bed),
    ("narrow_patch", geometry::narrow_patch),
    ("christiansen_sampling", spectra::christiansen_sampling),
    ("reststrahlen_sampling", spectra::reststrahlen_sampling),
    ("not_opaque", spectra::not_opaque),
    ("few_paths", counts::few_paths),
    ("particles_of_field", counts::particles_of_field),
    ("materials", counts::materials),
    ("grains_of_recipe", counts::grains_of_recipe),
    ("bullet_substeps", bullet::substeps),
    ("bullet_scale", bullet::scale),
    ("bullet_margin", bullet::margin),
    ("bullet_gravity", bullet::gravity),
];

/// The names of all rows, in the order of the page.
pub fn names() -> impl Iterator<Item = &'static str> {
    ROWS.iter().map(|(name, _)| *name)
}

/// Sweeps a row.
///
/// # Errors
/// What has nothing to do with the sweep: a temporary folder that cannot be written, an interrupt.
///
/// # Panics
/// If there is no row of that name.
pub fn row(name: &str, setting: &Setting) -> Result<Row, Error> {
    let (_, make) = ROWS.iter().find(|(known, _)| *known == name).expect("a row's name");
    let row = make(setting)?;
    assert_eq!(row.name, name);
    Ok(row)
}
