//! Failures of the library as the module's exception.

use pyo3::prelude::*;

/// The exception of a failure: its message, its hint, its exit status.
pub fn raised(error: impl Into<soilsig::Error>) -> PyErr {
    let error = error.into();
    let (message, hint, status) = (error.to_string(), error.hint(), error.status() as u8);
    Python::attach(|py| {
        let made = py
            .import("soilsig._error")
            .and_then(|module| module.getattr("Error"))
            .and_then(|class| class.call1((message, hint, status)));
        match made {
            Ok(exception) => PyErr::from_value(exception),
            Err(error) => error,
        }
    })
}
