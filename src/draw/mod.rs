//! Charts and pictures.

pub mod picture;
pub mod plot;
