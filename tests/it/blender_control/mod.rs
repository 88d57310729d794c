//! How Blender is found and run, shown on scripts that pose as one and on the real ones.

mod doctor;
pub mod fake;
mod jobs;
mod search;
