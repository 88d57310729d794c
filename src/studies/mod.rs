//! Studies of the method itself: error against time, and where the method fails.

pub mod chart;
pub mod stress;
