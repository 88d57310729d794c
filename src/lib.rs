//! Thermal-infrared signatures of soil from the geometry of its grains.
//!
//! The data's way, and the module that has charge of each step:
//!
//! | step | module |
//! |---|---|
//! | scene file, strict and documented | [`scene`] |
//! | Blender models and drops the grains, once for each packing | [`beds`], [`blender`] |
//! | bare grains, their descriptors and picture; grains of the user's own | [`grains`], [`library`] |
//! | `.obj` and `.gltf` into meshes and instances | [`ingest`], [`geometry`] |
//! | closest hits through two levels of bounding volumes | [`bvh`] |
//! | backward paths into counts of what they hit | [`course`], [`tracer`], [`tally`] |
//! | the counts, kept and evaluated | [`table`], [`histogram`] |
//! | when the rays are enough | [`stop`] |
//! | emissivity of a facet | [`spectrum`], [`optics`] |
//! | the mean over packings and its error | [`packings`] |
//! | emissivity and radiance of the bed (Eq. 1 to 3) | [`signature`], [`radiometry`] |
//! | emissivity back from measured radiance | [`retrieve`] |
//! | charts and pictures | [`plot`], [`picture`] |
//! | images of the bed, a spectrum for every pixel | [`image`], [`cube`], [`envi`] |
//! | the scene for other programs, and from them | [`export`] |
//! | what a result says of itself, in numbers and in words | [`report`], [`words`], [`remarks`] |
//! | what was done, and doing it again | [`record`], [`cache`] |
//! | where all of it fails, and what is said then | [`stress`] |
//!
//! Lengths are micrometres inside the library, temperatures kelvin, radiance
//! W m-2 sr-1 um-1; names that leave a module carry the unit.

pub mod error;
pub mod features;
pub mod plan;
pub mod plot;
pub mod report;

pub mod interrupt;
pub mod output;

pub mod beds;
pub mod blender;
pub mod budget;
pub mod bvh;
pub mod cache;
pub mod chart;
pub mod course;
pub mod coverage;
pub mod cube;
pub mod depth;
pub mod envi;
pub mod export;
mod field;
pub mod geometry;
pub mod grains;
pub mod histogram;
pub mod image;
pub mod in_field;
pub mod ingest;
mod leaving;
pub mod library;
pub mod merge;
pub mod optics;
pub mod packings;
pub mod picture;
pub mod pipeline;
pub mod progress;
pub mod radiometry;
pub mod random;
pub mod record;
pub mod remarks;
pub mod retrieve;
pub mod scene;
mod section;
pub mod shipped;
pub mod signature;
mod solid;
pub mod spectrum;
pub mod stop;
pub mod stress;
pub mod table;
pub mod tally;
pub mod trace;
pub mod tracer;
pub mod words;
