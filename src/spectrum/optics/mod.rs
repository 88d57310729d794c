//! Optics of crystals and powders: what light does at a facet, from few numbers.

mod crystal;
mod fresnel;
mod powder;

pub use crystal::{Axis, Factor, Oscillator, UniaxialCrystal};
pub use fresnel::{hemispherical_mean, normal_reflectance, unpolarised_reflectance};
pub use powder::{Change, PowderForm, PowderParameters, Surface, Volume};
