//! From temperatures, sky and atmosphere to radiance, and back to emissivity (Carson & Salvaggio
//! 2015, section 2, Eq. 1 to 3).
//!
//! Spectral radiance is in W m-2 sr-1 um-1, wavelength in um, temperature in K.

pub mod air;
mod atmosphere;
mod columns;
mod equations;
mod error;
mod lit;
mod models;
mod planck;
mod retrieval;
mod separation;
mod sky;

pub use atmosphere::Atmosphere;
pub use columns::Columns;
pub(crate) use columns::{BRIGHTEST, MISSING_MARKS};
pub use equations::{
    amplification, at_sensor, emissivity, emissivity_error, l_downwelling, l_target,
};
pub use error::RadiometryError;
pub use lit::Lit;
pub use planck::{brightness_temperature_k, planck, planck_derivative};
pub use retrieval::{Assumed, Measured, Retrieved, Temperature, masked_in_words, masked_um};
pub use separation::{Method, separate};
pub use sky::SkyTable;
