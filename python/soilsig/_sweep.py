"""Studies: one scene at many points."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from ._arrays import columns
from ._run import options, run
from ._table import Table

#: Columns of results.csv that every study has; those between the first two are its axes.
_FIRST, _BEHIND_AXES = "point", "beds"


class Sweep:
    """The results of a study: a folder of files.

    Parameters
    ----------
    folder : str or path
        The folder of a sweep that has ended.

    Attributes
    ----------
    folder : pathlib.Path
        All its files. ``results.nc`` has the emissivity by band over the axes.
    record : dict
        ``sweep.json``: the study, versions, hashes and times.
    """

    def __init__(self, folder: str | os.PathLike) -> None:
        self.folder = Path(folder)
        self.record: dict[str, Any] = json.loads((self.folder / "sweep.json").read_text("utf-8"))

    @property
    def report(self) -> Path:
        """The page of the study."""
        return self.folder / "report.html"

    @property
    def results(self) -> xr.Dataset:
        """``results.csv``: a value for each point, shape (points,). The axes are coordinates."""
        of = columns(self.folder / "results.csv")
        names = list(of)
        axes = names[1 : names.index(_BEHIND_AXES)]
        points = of.pop(_FIRST).astype(int)
        data = {name: ("point", values) for name, values in of.items() if name not in axes}
        places = {name: ("point", of[name]) for name in axes}
        return xr.Dataset(data, {_FIRST: points, **places})

    @property
    def failures(self) -> list[dict[str, Any]]:
        """The beds that failed: point, seed, status, reason and hint of each."""
        file = self.folder / "failures.csv"
        if not file.exists():
            return []
        of = columns(file)
        return [dict(zip(of, row)) for row in zip(*(column.tolist() for column in of.values()))]

    def table(self, point: int, seed: int | None = None) -> Table:
        """The bounce tables of a point's beds as one, or that of one seed: for other spectra and
        temperatures. The beds of a placed scene are one bed: name a seed."""
        of = columns(self.folder / "beds.csv")
        own = (of[_FIRST] == point) & ((seed is None) | (of["seed"] == seed))
        folders = [folder for folder in of["folder"][own].tolist() if folder]
        if not folders:
            raise KeyError(f"no bed of point {point}" + (f", seed {seed}" if seed else ""))
        return Table(*(self.folder / folder / "table.json" for folder in folders))

    def __repr__(self) -> str:
        return f"<soilsig.Sweep {self.folder}>"


def sweep(
    study: Mapping[str, Any] | str | os.PathLike,
    *,
    out: str | os.PathLike | None = None,
    part: str | None = None,
    blender: str | os.PathLike | None = None,
    blender_timeout: int | None = None,
    no_cache: bool = False,
    threads: int | None = None,
) -> Sweep | None:
    """Drop and trace the beds of a study: a scene at many points.

    A sweep that was stopped goes on where it was.

    Parameters
    ----------
    study : path or mapping
        A study file, or its content, which is written beside the folder of the results: files that
        it names are relative to that place.
    out : path, optional
        Folder for the results. Default: ``out/`` and the name of the study.
    part : str, optional
        Only one part of the beds, as on a cluster: ``"1/8"``.
    blender, blender_timeout, no_cache, threads
        As for `pipeline`.

    Returns
    -------
    Sweep
        None for a part: a last sweep without it makes the results.
    """
    if isinstance(study, Mapping):
        name = str(study.get("name", "study"))
        folder = Path("out") / name if out is None else Path(out)
        file = folder.parent / f"{folder.name}.study.json"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(study, indent=2) + "\n", encoding="utf-8")
    else:
        file = Path(study)
        folder = Path("out") / file.stem if out is None else Path(out)
    known = {"part": part, "blender": blender, "blender_timeout": blender_timeout}
    known["threads"] = threads
    run(["sweep", file, *options(out=folder, no_cache=no_cache, **known)])
    return Sweep(folder) if part is None else None
