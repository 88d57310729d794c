"""Arrays from the bytes that the library hands over."""

from __future__ import annotations

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
