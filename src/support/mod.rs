//! What every room stands on: failures, files, progress, cache, random numbers, statistics.

pub mod cache;
pub(crate) mod csv;
pub(crate) mod envi;
pub mod error;
pub mod file_error;
pub mod linear;
pub mod monitor;
pub mod output;
pub mod random;
pub mod resources;
mod sobol;
pub mod statistics;
pub mod text;
