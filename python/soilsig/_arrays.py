"""Arrays from the bytes that the library hands over."""

from __future__ import annotations

import csv
import os
from typing import Any

import numpy as np
import xarray as xr

from . import _soilsig

#: What a wavelength is, by the CF conventions.
WAVELENGTH = {
    "standard_name": "radiation_wavelength",
    "long_name": "wavelength of the band",
    "units": "um",
}


def array(data: bytes) -> np.ndarray:
    """Numbers, which may be changed."""
    return np.frombuffer(data, dtype=np.float64).copy()


def coordinate(um: np.ndarray) -> xr.Variable:
    """Wavelengths, um, as a coordinate."""
    return xr.Variable("wavelength", um, WAVELENGTH)


def wavelengths(wavelength: Any) -> np.ndarray | None:
    """Wavelengths, um, from an array, or from (from, to, step)."""
    if wavelength is None:
        return None
    if isinstance(wavelength, tuple):
        from_um, to_um, *step = wavelength
        return array(_soilsig.wavelengths(from_um, to_um, step[0] if step else 0.01))
    return np.atleast_1d(np.asarray(wavelength, dtype=np.float64))


def columns(file: str | os.PathLike) -> dict[str, np.ndarray]:
    """The columns of a CSV file by their headings: numbers, NaN where a field is empty; texts where
    a field is no number."""
    with open(file, encoding="utf-8", newline="") as lines:
        heading, *rows = csv.reader(lines)
    return {name: _values([row[i] for row in rows]) for i, name in enumerate(heading)}


def _values(fields: list[str]) -> np.ndarray:
    try:
        return np.array([float(field) if field else np.nan for field in fields])
    except ValueError:
        return np.array(fields)


def by_wavelength(file: str | os.PathLike) -> xr.Dataset:
    """A CSV file as a Dataset by its column ``wavelength_um``. Names end in their units."""
    of = columns(file)
    um = coordinate(of.pop("wavelength_um"))
    data = {name: xr.Variable("wavelength", values, units(name)) for name, values in of.items()}
    return xr.Dataset(data, {"wavelength": um})


def units(name: str) -> dict[str, str]:
    """The unit that a name ends in, as an attribute."""
    for ending, unit in (("_w_m2_sr_um", "W m-2 sr-1 um-1"), ("_k", "K"), ("_um", "um")):
        if name.endswith(ending):
            return {"units": unit}
    return {"units": "1"}
