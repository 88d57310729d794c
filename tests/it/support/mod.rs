//! What several tests share.

mod blenders;
mod measured;
mod place;
mod program;
mod scenes;
mod vectors;

pub use blenders::real_blenders;
pub use measured::{Noise, l_sky, measured};
pub use place::{Place, shipped};
pub use program::run_in;
pub use scenes::trace_file;
pub use vectors::{V, along, cross, dot, sub, unit};
