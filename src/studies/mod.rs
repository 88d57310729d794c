//! Studies of the method: error against time, and the limits where it fails.

#![allow(clippy::disallowed_methods, reason = "truths and axes of studies, no results")]

pub mod chart;
pub mod stress;
