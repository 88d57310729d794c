//! Thermal-infrared emissivity and radiance of soil from the geometry of its grains.
//!
//! A [`Scene`] names meshes, where they stand, what they are made of, and from where they are
//! seen. [`trace`] follows paths through it, once, into a bounce [`Table`]: counts of how often
//! each path hit each material before it reached the sky. The table gives emissivity and
//! radiance for any spectra, bands and temperatures without further tracing: [`evaluate`].
//!
//! ```
//! use soilsig::{Grid, Request, Scene, Target, Unwatched, evaluate, trace};
//!
//! let scene = Scene::read("scenes/settled_patch.json".as_ref())?;
//! let grid = Grid::new(8.0, 12.0, 0.5).expect("a grid of bands");
//! let table = trace(scene, Request::new(&grid, Target::of(0.02)), &Unwatched)?;
//! let bands = evaluate(&[table], &grid.wavelengths_um())?;
//! let at_9_um = bands[2].emissivity;
//! assert!((at_9_um.mean - 0.815).abs() < at_9_um.half_width + 0.005);
//! # Ok::<(), soilsig::Error>(())
//! ```
//!
//! | task | begin with |
//! |---|---|
//! | read a scene | [`Scene::read`], [`scene`] |
//! | trace it, with progress and cancellation | [`trace`], [`Request`], [`Monitor`] |
//! | read, merge and evaluate tables | [`Table::read`], [`merge`], [`evaluate`] |
//! | make and read spectra | [`Spectrum`], [`spectrum`] |
//! | ask where the uncertainty comes from | [`Budget`] |
//! | emissivity and temperature from radiance | [`radiometry`] |
//! | an image with a spectrum in every pixel | `image` (feature `netcdf`) |
//!
//! Lengths and wavelengths are micrometres, temperatures kelvin, radiances W m-2 sr-1 um-1;
//! names carry the unit. The library prints nothing and keeps no state for the whole process.
//!
//! | feature | what it adds |
//! |---|---|
//! | `cli` (default) | the program `soilsig`, and all below |
//! | `pipeline` | beds from Blender, and the whole way from a recipe to a curve; needs `plots` |
//! | `plots` | charts and pictures |
//! | `gltf` | meshes from glTF |
//! | `netcdf` | radiance images: ENVI, NetCDF and pictures; needs `plots` |
//! | `schema` | the formats of files as JSON Schema |

#![cfg_attr(
    not(feature = "cli"),
    allow(dead_code, unused_imports, reason = "some parts serve the program alone")
)]
#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests write no results"))]
#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod radiometry;
pub mod scene;
pub mod spectrum;

// The rooms are open to the tests and benches of this crate.
#[cfg(all(feature = "internals", feature = "pipeline"))]
pub mod beds;
#[cfg(all(not(feature = "internals"), feature = "pipeline"))]
mod beds;
#[cfg(all(feature = "internals", feature = "pipeline"))]
pub mod blender;
#[cfg(all(not(feature = "internals"), feature = "pipeline"))]
mod blender;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[cfg(all(feature = "internals", feature = "plots"))]
pub mod draw;
#[cfg(all(not(feature = "internals"), feature = "plots"))]
mod draw;
#[cfg(feature = "internals")]
pub mod geometry;
#[cfg(not(feature = "internals"))]
mod geometry;
#[cfg(feature = "internals")]
pub mod histogram;
#[cfg(not(feature = "internals"))]
mod histogram;
#[cfg(all(feature = "internals", feature = "pipeline"))]
pub mod inverse;
#[cfg(all(not(feature = "internals"), feature = "pipeline"))]
mod inverse;
#[cfg(all(feature = "internals", feature = "pipeline"))]
pub mod pipeline;
#[cfg(all(not(feature = "internals"), feature = "pipeline"))]
mod pipeline;
#[cfg(feature = "internals")]
pub mod products;
#[cfg(not(feature = "internals"))]
mod products;
#[cfg(feature = "internals")]
pub mod report;
#[cfg(not(feature = "internals"))]
mod report;
#[cfg(feature = "internals")]
pub mod signature;
#[cfg(not(feature = "internals"))]
mod signature;
#[cfg(all(feature = "internals", feature = "pipeline"))]
pub mod studies;
#[cfg(all(not(feature = "internals"), feature = "pipeline"))]
mod studies;
#[cfg(feature = "internals")]
pub mod support;
#[cfg(not(feature = "internals"))]
mod support;
#[cfg(all(feature = "internals", feature = "cli"))]
pub mod sweep;
#[cfg(all(not(feature = "internals"), feature = "cli"))]
mod sweep;
#[cfg(feature = "internals")]
pub mod table;
#[cfg(not(feature = "internals"))]
mod table;
#[cfg(feature = "internals")]
pub mod tracer;
#[cfg(not(feature = "internals"))]
mod tracer;

pub use histogram::{Estimate, Histogram, Mean};
#[cfg(feature = "netcdf")]
pub use products::image;
pub use scene::{Grid, Scene};
pub use signature::budget::{Budget, Share};
pub use signature::jacobian::jacobian;
pub use signature::{Band, csv_text, evaluate};
pub use spectrum::Spectrum;
pub use support::error::{Error, Failure, Status};
pub use support::monitor::{Interrupted, Monitor, Unwatched};
pub use table::merge::merge;
pub use table::{Prepared, Table, TableError, Target};
pub use tracer::Tracer;
pub use tracer::trace::Request;

/// Reads the files that a placed scene names, and traces it until its bands reach the target.
///
/// # Errors
/// A file that cannot be used, a sensor that looks past the target, or a monitor that stops it.
pub fn trace(scene: Scene, request: Request, monitor: &dyn Monitor) -> Result<Table, Error> {
    let tracer = tracer::trace::tracer(&scene)?;
    let prepared = Prepared::new(scene, &request.grid.wavelengths_um())?;
    tracer::trace::trace(&tracer, &prepared, request, monitor)
}
