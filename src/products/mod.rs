//! Products besides the signature: images, retrievals, scenes for other programs, bare grains.

pub mod cube;
pub mod export;
pub mod grains;
pub mod image;
pub mod retrieve;
