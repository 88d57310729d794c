"""Bounce tables: emissivity and radiance for any spectra, without tracing again."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from . import _soilsig
from ._arrays import WAVELENGTH, array, coordinate, wavelengths
from ._spectrum import Sensor, Spectrum

Spectra = Mapping[str, Any]
AnySensor = Sensor | str | os.PathLike


class Table:
    """The bounce table of a bed, or those of several beds (packings) of one recipe.

    A table counts what paths did. It gives emissivity and radiance for any spectra, temperatures
    and skies, and can be pickled.

    Parameters
    ----------
    *files : str or path
        The table.json of a run, or those of all its packings.
    """

    _of: _soilsig.Table

    def __init__(self, *files: str | os.PathLike) -> None:
        self._of = _soilsig.Table.read([os.fspath(file) for file in files])

    @property
    def scene(self) -> str:
        """The name of its scene."""
        return self._of.scene

    @property
    def paths(self) -> int:
        """Paths traced."""
        return self._of.paths

    @property
    def temperature_k(self) -> float:
        """Temperature of the scene, K."""
        return self._of.temperature_k

    @property
    def materials(self) -> dict[str, Spectrum]:
        """The spectrum of each material."""
        spectra = {}
        for name, of in self._of.materials:
            spectra[name] = Spectrum.__new__(Spectrum)
            spectra[name]._of = of
        return spectra

    @property
    def wavelength_um(self) -> np.ndarray:
        """The wavelengths that it was traced for, um, shape (n,)."""
        return array(self._of.wavelengths_um)

    @property
    def warnings(self) -> list[str]:
        """Warnings about the bed."""
        return self._of.warnings

    def emissivity(
        self,
        spectra: Spectra | None = None,
        *,
        temperature: float | None = None,
        sky: Any = None,
        wavelength: Any = None,
    ) -> xr.DataArray:
        """The emissivity of the bed towards the sensor.

        Parameters
        ----------
        spectra : mapping, optional
            Another spectrum for a material, by its name: all that `Spectrum` takes.
        temperature : float, optional
            Another temperature of the scene, K. The emissivity does not depend on it.
        sky : float or path, optional
            Another sky: see `signature`. The emissivity does not depend on it.
        wavelength : array_like or (from, to, step), optional
            Wavelengths, um, shape (n,). Without them those of the trace.

        Returns
        -------
        xarray.DataArray
            Emissivity, 0 to 1, shape (n,), with the coordinate ``wavelength``, um. `signature`
            gives its errors.
        """
        um = self._wavelengths(wavelength)
        table = self._changed(spectra, temperature, sky, None)
        values = array(table.emissivity(um.tolist()))
        return self._by_wavelength(um, values, "emissivity", "emissivity towards the sensor")

    def jacobian(self, spectra: Spectra | None = None, *, wavelength: Any = None) -> xr.DataArray:
        """How the emissivity of the bed changes with that of the facets.

        Parameters
        ----------
        spectra, wavelength
            As for `emissivity`.

        Returns
        -------
        xarray.DataArray
            The derivative of the bed's emissivity in a band with respect to the emissivity of the
            facets of a material in that band; shape (materials, n), without a unit. It is exact.
            Other bands do not matter: their derivatives are 0.
        """
        um = self._wavelengths(wavelength)
        table = self._changed(spectra, None, None, None)
        names = [name for name, _ in self._of.materials]
        values = array(table.jacobian(um.tolist())).reshape(len(names), um.size)
        return xr.DataArray(
            values,
            {"material": names, "wavelength": coordinate(um)},
            ("material", "wavelength"),
            "jacobian",
            {"long_name": "derivative of the emissivity by that of facets", "units": "1"},
        )

    def signature(
        self,
        spectra: Spectra | None = None,
        *,
        temperature: float | None = None,
        sky: Any = None,
        atmosphere: str | os.PathLike | None = None,
        wavelength: Any = None,
        sensor: AnySensor | Sequence[AnySensor] | None = None,
        temperature_error: float = 0.0,
        sky_error: float = 0.0,
        amplification_limit: float = 10.0,
    ) -> xr.Dataset:
        """Emissivity and radiance with their errors.

        Parameters
        ----------
        spectra, wavelength
            As for `emissivity`.
        temperature : float, optional
            Another temperature of the scene, K.
        sky : float or path, optional
            Another sky: its temperature, K, or a file of its radiance.
        atmosphere : path, optional
            Another atmosphere between target and sensor: a file.
        sensor : Sensor, str or path, or a list of them, optional
            Give the bands of sensors in place of wavelengths: ``"aster"``, ``"aster,ecostress"``,
            or a file of responses.
        temperature_error : float
            Standard error of the target's temperature for Eq. 2, K.
        sky_error : float
            Standard error of the sky's radiance for Eq. 2, as a share of it.
        amplification_limit : float
            Mask bands in which Eq. 2 amplifies errors more than this.

        Returns
        -------
        xarray.Dataset
            By ``wavelength``, um, the variables of ``signature.nc``: emissivity without a unit,
            radiance in W m-2 sr-1 um-1, temperatures in K; errors are named by the attribute
            ``ancillary_variables``. With sensors by ``band``, in the order of the sensors and of
            their bands: emissivity, radiance and brightness temperature with their total errors;
            ``sensor`` and ``centre_um`` are coordinates.
        """
        table = self._changed(spectra, temperature, sky, atmosphere)
        if sensor is not None:
            return _in_bands(table, _sensors(sensor))
        um = self._wavelengths(wavelength)
        errors = temperature_error, sky_error, amplification_limit
        return _dataset(*table.signature(um.tolist(), *errors))

    def write(self, *files: str | os.PathLike) -> None:
        """Write the table, or those of all packings, as JSON."""
        texts = self._of.texts()
        if len(files) != len(texts):
            raise ValueError(f"give {len(texts)} files, one for each packing")
        for file, text in zip(files, texts):
            with open(file, "w", encoding="utf-8") as out:
                out.write(text)

    def __repr__(self) -> str:
        names = ", ".join(name for name, _ in self._of.materials)
        return f"<soilsig.Table {self.scene}: {self.paths} paths; materials {names}>"

    def __reduce__(self) -> tuple:
        return _table_of_texts, (self._of.texts(),)

    def _wavelengths(self, wavelength: Any) -> np.ndarray:
        um = wavelengths(wavelength)
        return self.wavelength_um if um is None else um

    def _changed(
        self, spectra: Spectra | None, temperature: float | None, sky: Any, atmosphere: Any
    ) -> _soilsig.Table:
        if not spectra and temperature is None and sky is None and atmosphere is None:
            return self._of
        new = [(name, Spectrum(given, name)._of) for name, given in (spectra or {}).items()]
        if isinstance(sky, int):
            sky = float(sky)
        return self._of.changed(new, temperature, sky, atmosphere)

    @staticmethod
    def _by_wavelength(um: np.ndarray, values: np.ndarray, name: str, meaning: str) -> xr.DataArray:
        attributes = {"long_name": meaning, "units": "1"}
        return xr.DataArray(values, {"wavelength": coordinate(um)}, "wavelength", name, attributes)


def _table_of_texts(texts: list[str]) -> Table:
    table = Table.__new__(Table)
    table._of = _soilsig.Table.of_texts(texts)
    return table


def _dataset(texts: list, numbers: list, um: bytes, variables: list) -> xr.Dataset:
    data = {}
    for name, meaning, units, errors, values in variables:
        attributes = {"long_name": meaning, "units": units}
        if errors:
            attributes["ancillary_variables"] = errors
        data[name] = xr.Variable("wavelength", array(values), attributes)
    coordinates = {"wavelength": xr.Variable("wavelength", array(um), WAVELENGTH)}
    return xr.Dataset(data, coordinates, {**dict(texts), **dict(numbers)})


#: Of a sensor's bands: name, meaning, unit.
_OF_BANDS = (
    ("emissivity", "emissivity, weighted by the response", "1"),
    ("l_sensor_w_m2_sr_um", "radiance at the sensor", "W m-2 sr-1 um-1"),
    ("brightness_temperature_k", "temperature of a black body with this radiance", "K"),
)


def _sensors(given: AnySensor | Sequence[AnySensor]) -> list[Sensor]:
    if isinstance(given, str):
        given = given.split(",")
    elif isinstance(given, (Sensor, os.PathLike)):
        given = [given]
    return [one if isinstance(one, Sensor) else Sensor(one) for one in given]


def _in_bands(table: _soilsig.Table, sensors: list[Sensor]) -> xr.Dataset:
    bands = [(sensor.name, *band) for sensor in sensors for band in table.in_bands(sensor._of)]
    numbers = np.array([band[3] for band in bands]).reshape(len(bands), 2 * len(_OF_BANDS))
    data = {}
    for i, (name, meaning, units) in enumerate(_OF_BANDS):
        for unit in ("_w_m2_sr_um", "_k", ""):
            if name.endswith(unit):
                error = f"{name.removesuffix(unit)}_half_width_95{unit}"
                break
        attributes = {"long_name": meaning, "units": units, "ancillary_variables": error}
        data[name] = xr.Variable("band", numbers[:, 2 * i], attributes)
        attributes = {"long_name": f"total half-width of {name}", "units": units}
        data[error] = xr.Variable("band", numbers[:, 2 * i + 1], attributes)
    data["valid"] = xr.Variable("band", [band[4] for band in bands])
    coordinates = {
        "band": [band[1] for band in bands],
        "sensor": xr.Variable("band", [band[0] for band in bands]),
        "centre_um": xr.Variable("band", [band[2] for band in bands], WAVELENGTH),
    }
    sources = dict.fromkeys(f"{sensor.name}: {sensor.source}" for sensor in sensors)
    return xr.Dataset(
        data, coordinates, {"Conventions": "CF-1.11", "bands_from": "; ".join(sources)}
    )
