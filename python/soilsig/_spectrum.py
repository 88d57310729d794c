"""Spectra and sensors."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from . import _soilsig
from ._arrays import array, coordinate, wavelengths


class Spectrum:
    """The emissivity of a facet by wavelength.

    Parameters
    ----------
    given : Spectrum, float, str, path, xarray.DataArray or (wavelength, emissivity)
        A number is an emissivity at every wavelength. A text is a shipped spectrum's name, a file,
        or in the words of the command line ``fresnel:CONSTANTS``, ``inverted:SPECTRUM`` or
        ``mix:SHARE*SPECTRUM+SHARE*SPECTRUM``. Arrays are points with straight lines between them:
        wavelength in um, shape (n,), and emissivity from 0 to 1, shape (n,). A DataArray has the
        coordinate ``wavelength``, um.
    name : str, optional
        A name for points.
    """

    _of: _soilsig.Spectrum

    def __init__(self, given: Any, name: str | None = None) -> None:
        if isinstance(given, Spectrum):
            self._of = given._of
        elif isinstance(given, (str, os.PathLike)):
            self._of = _soilsig.Spectrum.find(os.fspath(given))
        elif isinstance(given, (float, int)):
            self._of = _soilsig.Spectrum.find(repr(float(given)))
        else:
            if isinstance(given, xr.DataArray):
                name = name or given.name
                given = given["wavelength"].values, given.values
            um, emissivity = (np.asarray(values, dtype=np.float64) for values in given)
            if um.ndim != 1 or um.shape != emissivity.shape:
                raise ValueError("give as many emissivities as wavelengths, in one dimension each")
            points = list(zip(um.tolist(), emissivity.tolist()))
            self._of = _soilsig.Spectrum.of_points(str(name or "points"), points)

    @property
    def name(self) -> str:
        """Its name, or that of its file."""
        return self._of.name

    @property
    def range_um(self) -> tuple[float, float] | None:
        """Least and greatest wavelength, um; None if every wavelength will do."""
        return self._of.range_um

    @property
    def warnings(self) -> list[str]:
        """Warnings about its values."""
        return self._of.warnings

    def emissivity(self, wavelength: Any = None) -> xr.DataArray:
        """The emissivity of its facets.

        Parameters
        ----------
        wavelength : array_like or (from, to, step), optional
            Wavelengths, um, shape (n,). Without them its own points, else every 0.01 um of its
            range.

        Returns
        -------
        xarray.DataArray
            Emissivity, 0 to 1, shape (n,), with the coordinate ``wavelength``, um. Where it depends
            on the angle it is the hemispherical emissivity.

        Raises
        ------
        Error
            A wavelength outside the range, or in a gap.
        """
        um = wavelengths(wavelength)
        if um is None:
            own = self._of.wavelengths_um
            um = wavelengths(self.range_um or (7.5, 14.0)) if own is None else array(own)
        values = array(self._of.emissivity(um.tolist()))
        attributes = {"long_name": "emissivity", "units": "1"}
        coordinates = {"wavelength": coordinate(um)}
        return xr.DataArray(values, coordinates, "wavelength", self.name, attributes)

    def __repr__(self) -> str:
        return f"<soilsig.Spectrum {self._of}>"

    def __reduce__(self) -> tuple:
        return _spectrum_of_json, (self._of.json(),)


def _spectrum_of_json(text: str) -> Spectrum:
    spectrum = Spectrum.__new__(Spectrum)
    spectrum._of = _soilsig.Spectrum.of_json(text)
    return spectrum


def read_spectrum(file: str | os.PathLike) -> Spectrum:
    """Read a spectrum from a file: the formats are those of ``soilsig spectra show``.

    Parameters
    ----------
    file : str or path
        ECOSTRESS, ASTER or USGS text, JCAMP-DX, ENVI .sli, DIRSIG .ems, or columns of text. A
        shipped spectrum's name will do, too.

    Returns
    -------
    Spectrum
    """
    return Spectrum(file)


class Band(NamedTuple):
    """A band of a sensor: its name, and centre and full width at half maximum, um."""

    name: str
    centre_um: float
    width_um: float


class Sensor:
    """A sensor.

    Attributes
    ----------
    name : str
    source : str
        Where its bands come from.
    bands : list of Band
    """

    _of: _soilsig.Sensor

    def __init__(self, name: str | os.PathLike) -> None:
        self._of = _soilsig.Sensor.find(os.fspath(name))

    @property
    def name(self) -> str:
        return self._of.name

    @property
    def source(self) -> str:
        return self._of.source

    @property
    def bands(self) -> list[Band]:
        return [Band(*band) for band in self._of.bands]

    def __repr__(self) -> str:
        return f"<soilsig.Sensor {self.name}: {len(self.bands)} bands, {self.source}>"


def sensor(name: str | os.PathLike) -> Sensor:
    """A sensor by its name, or by a CSV file of responses.

    Parameters
    ----------
    name : str or path
        aster, ecostress, landsat-tirs, modis, master, hytes, sebass (nominal bands), or a file.

    Returns
    -------
    Sensor
    """
    return Sensor(name)
