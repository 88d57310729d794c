//! What every room stands on: failures, files, interruption, progress, the cache, random numbers, statistics.

pub mod cache;
pub mod envi;
pub mod error;
pub mod file_error;
pub mod monitor;
pub mod output;
pub mod random;
mod sobol;
pub mod statistics;
