"""Thermal-infrared emissivity of soil from the geometry of its grains.

>>> import soilsig
>>> run = soilsig.pipeline("sparse", tolerance=0.01)
>>> run.signature.emissivity.sel(wavelength=9.0, method="nearest")
>>> run.table.emissivity({"fine": 0.9})

Lengths and wavelengths are micrometres, temperatures kelvin, radiances W m-2 sr-1 um-1.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._commands import Match, Run, image, match, pipeline, trace
    from ._compare import diff, report, retrieve
    from ._error import Error
    from ._run import Answer, run
    from ._scene import Scene
    from ._spectrum import Band, Sensor, Spectrum, read_spectrum, sensor
    from ._sweep import Sweep, sweep
    from ._table import Table

__all__ = [
    "Answer",
    "Band",
    "Error",
    "Match",
    "Run",
    "Scene",
    "Sensor",
    "Spectrum",
    "Sweep",
    "Table",
    "diff",
    "image",
    "match",
    "pipeline",
    "read_spectrum",
    "report",
    "retrieve",
    "run",
    "sensor",
    "sweep",
    "trace",
]

_HOMES = {
    "_commands": ("Match", "Run", "image", "match", "pipeline", "trace"),
    "_compare": ("diff", "report", "retrieve"),
    "_error": ("Error",),
    "_run": ("Answer", "run"),
    "_scene": ("Scene",),
    "_spectrum": ("Band", "Sensor", "Spectrum", "read_spectrum", "sensor"),
    "_sweep": ("Sweep", "sweep"),
    "_table": ("Table",),
}


def __getattr__(name: str) -> Any:
    """Import when asked: the command line needs neither numpy nor xarray."""
    from importlib import import_module

    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f".{home}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
