//! Spectra.

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use soilsig::spectrum::Tabulated;

use crate::bytes;
use crate::failure::raised;

/// A spectrum of facets.
#[pyclass(frozen, module = "soilsig._soilsig")]
#[derive(Clone)]
pub struct Spectrum(pub soilsig::Spectrum);

#[pymethods]
impl Spectrum {
    /// A spectrum in the words of the command line.
    #[staticmethod]
    fn find(text: &str) -> PyResult<Self> {
        soilsig::cli::spectrum(text).map(Self).map_err(raised)
    }

    /// A spectrum of points, with straight lines between them.
    #[staticmethod]
    fn of_points(name: &str, points: Vec<(f64, f64)>) -> PyResult<Self> {
        let points = Tabulated::new(name, &points).map_err(raised)?;
        Ok(Self(soilsig::Spectrum::Tabulated(points)))
    }

    /// The emissivity at each wavelength, um.
    fn emissivity<'py>(
        &self,
        py: Python<'py>,
        wavelengths_um: Vec<f64>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let of = |um| self.0.emissivity(um);
        let values: Result<Vec<f64>, _> = wavelengths_um.into_iter().map(of).collect();
        Ok(bytes(py, values.map_err(raised)?))
    }

    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    #[getter]
    fn range_um(&self) -> Option<(f64, f64)> {
        self.0.range_um().map(Into::into)
    }

    /// Its own wavelengths, if it is one of points.
    #[getter]
    fn wavelengths_um<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        match &self.0 {
            soilsig::Spectrum::Tabulated(points) => {
                Some(bytes(py, points.wavelength_um.iter().copied()))
            }
            _ => None,
        }
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings().iter().map(ToString::to_string).collect()
    }

    /// As JSON, which `of_json` reads.
    fn json(&self) -> String {
        serde_json::to_string(&self.0).expect("plain data")
    }

    #[staticmethod]
    fn of_json(text: &str) -> PyResult<Self> {
        let wrong =
            |error: serde_json::Error| pyo3::exceptions::PyValueError::new_err(error.to_string());
        serde_json::from_str(text).map(Self).map_err(wrong)
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }
}
