//! Studies of the method: error against time, and the limits where it fails.

pub mod chart;
pub mod stress;
