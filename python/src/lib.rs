//! The part of the Python module that is written in Rust. It is thin: what has a shape and a unit
//! for users is made in Python (`python/soilsig`).

#![allow(clippy::needless_pass_by_value, reason = "Python hands over values")]

mod call;
mod failure;
mod scene;
mod sensor;
mod spectrum;
mod table;

use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Numbers as numpy takes them without looking at each.
fn bytes(py: Python<'_>, numbers: impl IntoIterator<Item = f64>) -> Bound<'_, PyBytes> {
    let bytes: Vec<u8> = numbers.into_iter().flat_map(f64::to_ne_bytes).collect();
    PyBytes::new(py, &bytes)
}

#[pymodule]
mod _soilsig {
    #[pymodule_export]
    use crate::call::{call, program};
    #[pymodule_export]
    use crate::scene::{cube, scene, wavelengths};
    #[pymodule_export]
    use crate::sensor::Sensor;
    #[pymodule_export]
    use crate::spectrum::Spectrum;
    #[pymodule_export]
    use crate::table::Table;
}
