//! Products besides the signature: images, retrievals, scenes for other programs, bare grains.

pub mod cube;
pub mod export;
#[cfg(feature = "pipeline")]
pub mod grains;
#[cfg(feature = "netcdf")]
pub mod image;
pub mod retrieve;
