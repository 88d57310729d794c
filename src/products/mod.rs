//! What is made of a bed besides its signature: images, scenes for other programs, retrievals, bare grains.

pub mod cube;
pub mod export;
#[cfg(feature = "pipeline")]
pub mod grains;
#[cfg(feature = "netcdf")]
pub mod image;
pub mod retrieve;
