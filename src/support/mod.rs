//! What every room stands on: failures, files, progress, cache, random numbers, statistics.

pub mod cache;
pub(crate) mod csv;
pub(crate) mod envi;
pub mod error;
pub mod file_error;
pub mod hermite;
pub mod linear;
pub mod lock;
pub mod math;
pub mod monitor;
#[cfg(feature = "netcdf")]
pub(crate) mod netcdf;
pub mod output;
mod place;
pub mod random;
pub mod resources;
pub mod ro_crate;
pub mod scratch;
mod sobol;
pub mod statistics;
pub mod text;
pub mod trust;
