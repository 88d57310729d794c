//! What every room stands on: failures, files, progress, cache, random numbers, statistics.

pub mod cache;
pub(crate) mod csv;
pub(crate) mod envi;
pub mod error;
pub mod file_error;
pub mod linear;
pub(crate) mod memory;
pub mod monitor;
pub mod output;
pub mod random;
mod sobol;
pub mod statistics;
pub mod text;
