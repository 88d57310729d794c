"""Commands that compare results, and that retrieve emissivity from radiance."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

import xarray as xr

from ._arrays import by_wavelength
from ._run import options, run

Path_ = str | os.PathLike


def diff(a: Path_, b: Path_) -> xr.Dataset:
    """Compare two results by their errors.

    Parameters
    ----------
    a, b : path
        Folders of runs, bounce tables, files of signatures or spectra.

    Returns
    -------
    xarray.Dataset
        By ``wavelength``, um: both emissivities, b less a, its half-width at 95 % and z. The
        attribute ``text`` has it in words, and ``differ`` is 1 where they differ by more than the
        errors of both.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "diff.csv"
        answer = run(["diff", a, b, *options(out=file)], quiet=5)
        found = by_wavelength(file)
    text = "".join(line for line in answer.text.splitlines(True) if "result in" not in line)
    return found.assign_attrs(text=text, differ=int(answer.status == 5))


def retrieve(
    radiance: Path_,
    *,
    temperature: float | None = None,
    method: str | None = None,
    pure_quartz: bool = False,
    sky: float | Path_ | None = None,
    atmosphere: Path_ | None = None,
    radiance_error: float | Path_ | None = None,
    temperature_error: float | None = None,
    sky_error: float | None = None,
    amplification_limit: float | None = None,
) -> xr.Dataset:
    """Retrieve emissivity and brightness temperature from measured radiance, by Eq. 2.

    Parameters
    ----------
    radiance : path
        A CSV file of radiance, or a signature.csv. Of an ENVI image call
        ``soilsig.run(["retrieve", ...])``, which writes images.
    temperature : float, optional
        Temperature of the target, K.
    method : {"nem", "smoothness", "christiansen"}, optional
        How to find the temperature from the radiance.
    pure_quartz : bool
        Whether the target is a powder of quartz alone.
    sky : float or path, optional
        The sky: its temperature, K, or a file of its radiance.
    atmosphere : path, optional
        Atmosphere between target and sensor.
    radiance_error : float, optional
        Standard error of the radiance, W m-2 sr-1 um-1.
    temperature_error, sky_error, amplification_limit : float, optional
        As for `Table.signature`.

    Returns
    -------
    xarray.Dataset
        By ``wavelength``, um: emissivity, brightness temperature, and their standard errors. The
        attribute ``text`` says the temperature and which bands are masked.
    """
    known: dict[str, Any] = {name: of for name, of in locals().items() if name != "radiance"}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "emissivity.csv"
        answer = run(["retrieve", radiance, *options(out=file, **known)])
        found = by_wavelength(file)
    text = "".join(line for line in answer.text.splitlines(True) if "result in" not in line)
    return found.assign_attrs(text=text)


def report(*runs: Any, out: Path_ = "report.html") -> Path:
    """Write the page of a run anew, or one that compares several.

    Parameters
    ----------
    *runs : Run or path
        Runs, or their folders.
    out : path
        The page.

    Returns
    -------
    pathlib.Path
        The page.
    """
    folders = [getattr(one, "folder", one) for one in runs]
    run(["report", *folders, *options(out=out)])
    return Path(out)
