//! What several tests share.

mod bed;
mod faults;
mod measured;
mod place;
mod scenes;
mod told;
mod tools;
mod vectors;

pub use bed::SmallBed;
pub use faults::{Found, failing_library, found, killed_after, left_over};
pub use measured::{Noise, l_sky, measured};
pub use place::{Place, shipped, shipped_json, shipped_path};
pub use scenes::{emissivity, trace_file};
pub use told::{message, told, without_fractions, without_numbers, without_places};
pub use tools::{Tool, a_blender, executable, real_blenders, tool, with_script};
pub use vectors::{V, XorShift, along, cross, dot, sub, unit};
