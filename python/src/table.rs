//! Bounce tables.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use soilsig::radiometry::{Assumed, Atmosphere, SkyTable, Temperature};
use soilsig::signature::budget::Budget;
use soilsig::signature::in_bands::{self, Seen};
use soilsig::signature::{self, netcdf};

use crate::bytes;
use crate::failure::raised;
use crate::sensor::Sensor;
use crate::spectrum::Spectrum;

/// The bounce tables of a recipe's packings; one, mostly.
#[pyclass(frozen, module = "soilsig._soilsig")]
#[derive(Clone)]
pub struct Table(Arc<Vec<soilsig::Table>>);

/// What is changed in the sky.
#[derive(FromPyObject)]
enum Sky {
    Grey(f64),
    File(PathBuf),
}

/// A variable: name, long name, unit, names of its errors, values.
type Variable<'py> = (String, &'static str, &'static str, String, Bound<'py, PyBytes>);
/// Texts and numbers for the whole, wavelengths, variables.
type Signature<'py> = (
    Vec<(&'static str, String)>,
    Vec<(&'static str, f64)>,
    Bound<'py, PyBytes>,
    Vec<Variable<'py>>,
);
/// Of each band: its name and centre; emissivity, radiance and brightness temperature, each with
/// its half-width; whether the models of facets hold.
type InBand = (String, f64, [f64; 6], bool);

#[pymethods]
impl Table {
    /// Reads the files of one table, or of those of several packings.
    #[staticmethod]
    fn read(py: Python<'_>, paths: Vec<PathBuf>) -> PyResult<Self> {
        if paths.is_empty() {
            return Err(PyValueError::new_err("give at least one table"));
        }
        let tables = py.detach(|| soilsig::Table::read_packings(&paths)).map_err(raised)?;
        Ok(Self(Arc::new(tables)))
    }

    /// Tables from the texts of their files.
    #[staticmethod]
    fn of_texts(texts: Vec<String>) -> PyResult<Self> {
        let parse = |text: &String| soilsig::Table::parse(text, Path::new("table.json"));
        let tables: Result<_, _> = texts.iter().map(parse).collect();
        Ok(Self(Arc::new(tables.map_err(raised)?)))
    }

    /// The texts of their files.
    fn texts(&self) -> Vec<String> {
        self.0.iter().map(soilsig::Table::text).collect()
    }

    #[getter]
    fn scene(&self) -> &str {
        &self.0[0].scene
    }

    #[getter]
    fn paths(&self) -> u64 {
        self.0.iter().map(|table| table.paths).sum()
    }

    #[getter]
    fn temperature_k(&self) -> f64 {
        self.0[0].temperature_k
    }

    /// The materials, in their order.
    #[getter]
    fn materials(&self) -> Vec<(String, Spectrum)> {
        let of = |material: &soilsig::table::TableMaterial| {
            (material.name.clone(), Spectrum(material.spectrum.clone()))
        };
        self.0[0].materials.iter().map(of).collect()
    }

    /// The wavelengths that were asked of the trace, um.
    #[getter]
    fn wavelengths_um<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        bytes(py, self.0[0].stop.asked.grid.wavelengths_um())
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0[0].warnings.iter().map(ToString::to_string).collect()
    }

    /// The tables with other spectra, another temperature, sky and atmosphere.
    #[pyo3(signature = (spectra, temperature_k=None, sky=None, atmosphere=None))]
    fn changed(
        &self,
        spectra: Vec<(String, PyRef<'_, Spectrum>)>,
        temperature_k: Option<f64>,
        sky: Option<Sky>,
        atmosphere: Option<PathBuf>,
    ) -> PyResult<Self> {
        let mut tables = Vec::clone(&self.0);
        let first = &mut tables[0];
        for (name, spectrum) in spectra {
            first.set_spectrum(&name, spectrum.0.clone()).map_err(raised)?;
        }
        if let Some(k) = temperature_k {
            first.set_temperature(k).map_err(raised)?;
        }
        match sky {
            None => {}
            Some(Sky::Grey(k)) => first.set_sky_temperature(k).map_err(raised)?,
            Some(Sky::File(path)) => {
                first.set_sky(SkyTable::read(&path).map_err(raised)?).map_err(raised)?;
            }
        }
        if let Some(path) = atmosphere {
            first.atmosphere = Some(Atmosphere::read(&path).map_err(raised)?);
        }
        Ok(Self(Arc::new(tables)))
    }

    /// The emissivity in each band.
    fn emissivity<'py>(
        &self,
        py: Python<'py>,
        wavelengths_um: Vec<f64>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let of = || match &self.0[..] {
            // Quicker, since no radiance is asked for.
            [_] => signature::curves(&self.0, &wavelengths_um).map(|mut curves| curves.remove(0)),
            several => signature::evaluate(several, &wavelengths_um)
                .map(|bands| bands.iter().map(|band| band.emissivity.mean).collect()),
        };
        Ok(bytes(py, py.detach(of).map_err(raised)?))
    }

    /// The derivative of the bed's emissivity by that of the facets, by material and band.
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        wavelengths_um: Vec<f64>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let of = || signature::jacobian::jacobian(&self.0, &wavelengths_um);
        Ok(bytes(py, py.detach(of).map_err(raised)?.into_iter().flatten()))
    }

    /// The signature, as `signature.nc` has it.
    #[pyo3(signature = (
        wavelengths_um, temperature_error_k=0.0, sky_error=0.0, amplification_limit=10.0
    ))]
    fn signature<'py>(
        &self,
        py: Python<'py>,
        wavelengths_um: Vec<f64>,
        temperature_error_k: f64,
        sky_error: f64,
        amplification_limit: f64,
    ) -> PyResult<Signature<'py>> {
        let table = &self.0[0];
        let temperature = Temperature { error_k: temperature_error_k, ..table.temperature() };
        let assumed =
            Assumed { downwelling_error: sky_error, amplification_limit, ..Assumed::EXACT };
        let variables = py.detach(|| {
            let bands = signature::evaluate(&self.0, &wavelengths_um)?;
            let budget = Budget::new(&self.0, &bands)?;
            Ok(netcdf::variables(&bands, &budget, temperature, assumed))
        });
        let variables = variables.map_err(|error: soilsig::Error| raised(error))?;
        let (texts, numbers) = netcdf::attributes(table);
        let variable = |of: netcdf::Variable| {
            let values = of.values.into_iter().map(|value| value.unwrap_or(f64::NAN));
            (of.name, of.long_name, of.units, of.ancillary_variables, bytes(py, values))
        };
        let variables = variables.into_iter().map(variable).collect();
        Ok((texts, numbers, bytes(py, wavelengths_um), variables))
    }

    /// What a sensor sees, in its bands. Where spectra miss a band there are no numbers.
    fn in_bands(&self, py: Python<'_>, sensor: &Sensor) -> PyResult<Vec<InBand>> {
        let seen = py.detach(|| in_bands::in_bands(&self.0, &sensor.0)).map_err(raised)?;
        let of = |band: in_bands::InBand| {
            let numbers = |seen: Seen| {
                let [e, of_e] = seen.emissivity;
                let [l, of_l] = seen.l_sensor;
                let [k, of_k] = seen.brightness_temperature_k.unwrap_or([f64::NAN; 2]);
                [e, of_e, l, of_l, k, of_k]
            };
            let valid = band.seen.is_some_and(|seen| seen.valid);
            (band.band, band.centre_um, band.seen.map_or([f64::NAN; 6], numbers), valid)
        };
        Ok(seen.into_iter().map(of).collect())
    }
}
