//! Optics of crystals and powders: what light does at a facet, from few numbers.

mod crystal;
mod fresnel;
mod powder;
mod refraction;

pub use crystal::{Axes, Axis, Crystal, Factor, Indices, Oscillator};
pub use fresnel::{hemispherical_mean, normal_reflectance, unpolarised_reflectance};
pub use powder::{Change, PowderForm, PowderParameters, Surface, Volume};
pub use refraction::{Crossing, inward, outward};
