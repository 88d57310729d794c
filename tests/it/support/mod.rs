//! What several tests share.

mod bed;
mod faults;
mod measured;
mod meshes;
mod place;
mod scenes;
pub mod slurm;
mod told;
mod tools;
mod vectors;

pub use bed::{HOME, OfBlenders, SmallBed};
pub use faults::{Found, failing_library, found, killed_after, left_over};
pub use measured::{Noise, l_sky, measured};
pub use meshes::{
    PIT_CORNERS, PIT_FACES, area, facets, load, load_from, load_scene, pit_lines, scene_of,
};
pub use place::{Place, shared_cache, shipped, shipped_json, shipped_path};
pub use scenes::{emissivity, trace_file};
pub use told::{message, told, without_fractions, without_numbers, without_places};
pub use tools::{Tool, a_blender, executable, real_blenders, tool, with_script};
pub use vectors::{V, XorShift, along, cross, dot, sub, unit};
