//! Sensors by name or file.

use pyo3::prelude::*;
use soilsig::spectrum::sensors;

use crate::failure::raised;

/// A sensor: its bands in their order.
#[pyclass(frozen, module = "soilsig._soilsig")]
#[derive(Clone)]
pub struct Sensor(pub sensors::Sensor);

#[pymethods]
impl Sensor {
    /// A known sensor, or one whose responses are in a file.
    #[staticmethod]
    fn find(text: &str) -> PyResult<Self> {
        sensors::Sensor::find(text).map(Self).map_err(raised)
    }

    /// The names of the sensors that are known.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        sensors::names().to_vec()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    #[getter]
    fn source(&self) -> &str {
        &self.0.source
    }

    /// Name, centroid and full width of each band, um.
    #[getter]
    fn bands(&self) -> Vec<(String, f64, f64)> {
        let of = |band: &sensors::SensorBand| {
            (band.name.clone(), band.response.centre_um(), band.response.width_um())
        };
        self.0.bands.iter().map(of).collect()
    }
}
