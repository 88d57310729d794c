//! The tracer against closed forms of radiative exchange, within three standard errors of 1e-4 at
//! most.
//!
//! Surfaces are grey, opaque and Lambertian. Where there is no formula the figures are solutions of
//! the integral equation for the radiosity (Siegel and Howell, Thermal Radiation Heat Transfer,
//! tell how to set it up), good to the digits given.

mod bodies;
mod cavities;
mod convex;
mod estimate;
mod exchange;
mod grooves;
mod scene_files;
