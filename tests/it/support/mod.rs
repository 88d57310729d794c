//! What several tests share.

mod measured;
mod place;
mod program;
mod scenes;
mod tools;
mod vectors;

pub use measured::{Noise, l_sky, measured};
pub use place::{Place, shipped};
pub use program::run_in;
pub use scenes::trace_file;
pub use tools::{Tool, a_blender, real_blenders, tool};
pub use vectors::{V, along, cross, dot, sub, unit};
