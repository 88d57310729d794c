//! Thermal-infrared signatures of soil from the geometry of its grains.

pub mod beds;
pub mod blender;
pub mod cli;
pub mod draw;
pub mod geometry;
pub mod histogram;
pub mod pipeline;
pub mod products;
pub mod radiometry;
pub mod report;
pub mod scene;
pub mod signature;
pub mod spectrum;
pub mod studies;
pub mod support;
pub mod table;
pub mod tracer;
