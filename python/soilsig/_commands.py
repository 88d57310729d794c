"""The commands whose results have a form of their own in Python."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from . import _soilsig
from ._arrays import array, by_wavelength, coordinate
from ._run import options, run
from ._scene import Scene
from ._spectrum import Spectrum
from ._table import Table

COVERAGES = ("full", "less", "sparse", "bare", "all")

AnyScene = Scene | Mapping[str, Any] | str | float | os.PathLike
Path_ = str | os.PathLike


class Run:
    """The result of a pipeline: a folder of files.

    Parameters
    ----------
    folder : str or path
        The folder of a run that has ended.

    Attributes
    ----------
    folder : pathlib.Path
        All its files; ``report.html`` is its page.
    record : dict
        ``run.json``: options, versions, seeds, hashes and the numbers that were reached.
    """

    def __init__(self, folder: Path_) -> None:
        self.folder = Path(folder)
        self.record: dict[str, Any] = json.loads((self.folder / "run.json").read_text("utf-8"))

    @property
    def report(self) -> Path:
        """The page of the run."""
        return self.folder / "report.html"

    @cached_property
    def table(self) -> Table:
        """The bounce table of its bed, or those of all its packings."""
        one = self.folder / "table.json"
        if one.exists():
            return Table(one)
        packings = (self.folder / "packings").glob("*/table.json")

        def place(path: Path) -> tuple[int, str]:
            # A drop may be there twice: N and N-touching.
            return int(path.parent.name.partition("-")[0]), path.parent.name

        return Table(*sorted(packings, key=place))

    @cached_property
    def signature(self) -> xr.Dataset:
        """Emissivity and radiance with their errors, as ``signature.nc`` has them:
        `Table.signature` at the wavelengths of the run."""
        return self.table.signature()

    @property
    def budget(self) -> xr.Dataset:
        """The parts of the uncertainty: half-widths in emissivity, shape (n,) each."""
        names = [name for name in self.signature if str(name).startswith("budget_")]
        return self.signature[["emissivity_total_half_width_95", *names]]

    @property
    def runs(self) -> dict[str, Run]:
        """The runs of a pipeline of all coverages, by coverage."""
        names = self.record["reached"]
        if len(names) == 1:
            return {next(iter(names)): self}
        return {name: _part(self, name) for name in names}

    def __repr__(self) -> str:
        return f"<soilsig.Run {self.folder}: {', '.join(self.record['reached'])}>"


def _part(of: Run, name: str) -> Run:
    part = Run.__new__(Run)
    part.folder = of.folder / name
    part.record = {**of.record, "reached": {name: of.record["reached"][name]}}
    return part


def pipeline(
    scene: AnyScene,
    *,
    out: Path_ | None = None,
    tolerance: float | None = None,
    packings: int | str | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    facets: str | None = None,
    grains: Path_ | None = None,
    field: float | None = None,
    max_paths: int | None = None,
    max_seconds: float | None = None,
    range: tuple[float, float] | None = None,
    step: float | None = None,
    patch_obj: bool = False,
    blender: Path_ | None = None,
    blender_timeout: int | None = None,
    no_cache: bool = False,
    threads: int | None = None,
) -> Run:
    """Drop the grains in Blender, trace the bed, and write its emissivity.

    Parameters
    ----------
    scene : str, float, path, mapping or Scene
        A shipped scene by its coverage (full, less, sparse, bare, all), the share of the grains'
        silhouettes to be covered with fines (0 to 1), a scene file, or its content.
    out : path, optional
        Folder for the result. Default: ``out/`` and the name of the scene.
    tolerance : float, optional
        Half-width at 95 % that the total of every band is to reach. As many beds are dropped as
        that takes. With `packings`, or of a placed scene, that of the rays and of the spread
        between beds. Default: one bed, with rays to 0.005.
    packings : int or "auto", optional
        Beds to drop, in place of as many as the tolerance takes.
    seed : int, optional
        Random seed of shapes, dust, drop and rays.
    set : mapping, optional
        Other values of the scene: ``{"view.zenith_deg": 35}``. None takes a key away.
    facets : {"library", "inverted"}, optional
        What the spectra of powders give to facets.
    grains : path, optional
        Folder of your own grains.
    field : float, optional
        Particles of the field that is traced.
    max_paths, max_seconds : optional
        The most paths, and the longest time, s, of a trace.
    range : (float, float), optional
        First and last wavelength, um. Default: 7.5 to 14.
    step : float, optional
        Distance between bands, um. Default: 0.01.
    patch_obj : bool
        Whether the settled patch is also exported as .obj.
    blender : path, optional
        The Blender to use. Default: that of this Python's own bpy, else one on PATH.
    blender_timeout : int, optional
        Longest that Blender may take, s.
    no_cache : bool
        Whether earlier results are left aside.
    threads : int, optional
        Threads to use; the result does not depend on it. Default: all cores.

    Returns
    -------
    Run

    Raises
    ------
    Error
        In the words of the command line.
    """
    known = _but(locals(), "scene", "set", "out")
    what = ["--coverage", str(scene)]
    if not _is_coverage(scene):
        file = _scene_file(scene, Path("out") if out is None else Path(out).parent)
        what = [f"--scene={os.fspath(file)}"]
        scene = file.stem
    out = Path("out") / str(scene) if out is None else Path(out)
    run(["pipeline", *what, *options(out=out, set=_changes(set), **known)])
    return Run(out)


def trace(
    scene: AnyScene,
    *,
    out: Path_ = "table.json",
    tolerance: float | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    max_paths: int | None = None,
    max_seconds: float | None = None,
    paths: int | None = None,
    shard: str | None = None,
    range: tuple[float, float] | None = None,
    step: float | None = None,
    threads: int | None = None,
) -> Table:
    """Trace a placed scene into a bounce table. No Blender is needed.

    Parameters
    ----------
    scene : str, path, mapping or Scene
        A scene file with placed geometry, or its content.
    out : path
        The file of the table.
    paths : int, optional
        Exactly this number of paths, whatever they reach.
    shard : str, optional
        One of n parts of those paths: ``"1/4"``.
    tolerance, seed, set, max_paths, max_seconds, range, step, threads
        As for `pipeline`.

    Returns
    -------
    Table
    """
    known = _but(locals(), "scene", "set")
    file = _scene_file(scene, Path(out).parent)
    run(["trace", os.fspath(file), *options(set=_changes(set), **known)])
    return Table(out)


class Match:
    """What a match found.

    Parameters
    ----------
    folder : str or path
        The folder of a match that has ended.

    Attributes
    ----------
    folder : pathlib.Path
    result : dict
        ``match.json``, whose keys are those of the reference.
    """

    def __init__(self, folder: Path_) -> None:
        self.folder = Path(folder)
        self.result: dict[str, Any] = json.loads((self.folder / "match.json").read_text("utf-8"))

    @property
    def parameters(self) -> xr.Dataset:
        """The parameters of the answer: best value, standard error and 95 % interval, by name."""
        found = self.result["answer"]["parameters"]
        of = {key: ("name", [one[key] for one in found]) for key in ("best", "standard_error")}
        interval = [one["interval_95"] for one in found]
        of["interval_95"] = (("name", "end"), interval)
        names = {"name": [one["name"] for one in found], "end": ["lower", "upper"]}
        return xr.Dataset(of, names)

    @property
    def fit(self) -> xr.Dataset:
        """Measured and fitted emissivity, their standard errors and the residual, by wavelength,
        um: the columns of ``match.csv``."""
        return by_wavelength(self.folder / "match.csv")

    @property
    def text(self) -> str:
        """The answer in words."""
        return (self.folder / "match.txt").read_text("utf-8")

    def __repr__(self) -> str:
        return f"<soilsig.Match {self.folder}>\n{self.text}"


def match(
    spectrum: Any,
    *,
    out: Path_ = "out/match",
    range: tuple[float, float] | None = None,
    error: float | None = None,
    facets: str | None = None,
    second: str | None = None,
    second_on: str | None = None,
    prior: Mapping[str, float | tuple[float, float]] | None = None,
    scene: AnyScene | None = None,
    beds: int | None = None,
    seed: int | None = None,
    sky: float | Path_ | None = None,
    atmosphere: Path_ | None = None,
    temperature: float | None = None,
    sky_error: float | None = None,
    blender: Path_ | None = None,
    blender_timeout: int | None = None,
    no_cache: bool = False,
    threads: int | None = None,
) -> Match:
    """Find the soil of a measured signature: its cover with fines, and a second component.

    Parameters
    ----------
    spectrum : path, Spectrum, xarray.DataArray or (wavelength, emissivity)
        Measured emissivity; with a sky, an atmosphere or a temperature, a CSV file of radiance.
        Arrays have the shape (n,), wavelengths are in um.
    out : path
        Folder for the result.
    range : (float, float), optional
        Wavelengths that are fitted, um. Default: 7.5 to 13.5.
    error : float, optional
        Standard error of the measured emissivity; of radiance, W m-2 sr-1 um-1.
    facets : {"library", "inverted", "fresnel"}, optional
        Facets of the answer. Default: inverted.
    second : str, optional
        The second component: ``flat``, a shipped spectrum or a file.
    second_on : {"fines", "grains", "all"}, optional
        Where it is.
    prior : mapping, optional
        Priors of parameters: a value, or mean and standard deviation.
    scene : path, mapping or Scene, optional
        Recipe of full cover. Default: the shipped one.
    beds : int, optional
        Beds of each cover.
    seed : int, optional
        Random seed.
    sky, atmosphere, temperature, sky_error
        As for `Table.signature`.
    blender, blender_timeout, no_cache, threads
        As for `pipeline`.

    Returns
    -------
    Match
    """
    known = _but(locals(), "spectrum", "scene", "prior")
    priors = [_prior(name, of) for name, of in (prior or {}).items()]
    Path(out).mkdir(parents=True, exist_ok=True)
    file = spectrum
    if not isinstance(spectrum, (str, os.PathLike)):
        file = Path(out) / "measured.csv"
        points = Spectrum(spectrum, "measured").emissivity()
        rows = zip(points["wavelength"].values.tolist(), points.values.tolist())
        lines = "".join(f"{um!r},{emissivity!r}\n" for um, emissivity in rows)
        file.write_text("wavelength_um,emissivity\n" + lines, encoding="utf-8")
    if scene is not None:
        known["scene"] = _scene_file(scene, Path(out))
    run(["match", os.fspath(file), *options(prior=priors, **known)])
    return Match(out)


def image(
    scene: AnyScene,
    *,
    out: Path_,
    set: Mapping[str, Any] | None = None,
    noise: float | None = None,
    max_paths: int | None = None,
    seed: int | None = None,
    pixels: tuple[int, int] | None = None,
    range: tuple[float, float] | None = None,
    step: float | None = None,
    false_colour: tuple[float, float, float] | None = None,
    show: tuple[float, ...] | None = None,
    threads: int | None = None,
) -> xr.Dataset:
    """Trace a placed scene into a radiance image with a spectrum in every pixel.

    Parameters
    ----------
    scene : str, path, mapping or Scene
        A scene file with placed geometry, or its content.
    out : path
        Folder for the result, with the image as ENVI, NetCDF and pictures.
    noise : float, optional
        Standard error in emissivity that every band of each pixel is to reach. Default: 0.01.
    max_paths : int, optional
        Most paths of a pixel.
    pixels : (int, int), optional
        Columns and lines.
    false_colour, show : tuple of float, optional
        Wavelengths of the pictures, um.
    set, seed, range, step, threads
        As for `pipeline`.

    Returns
    -------
    xarray.Dataset
        radiance and its standard error, W m-2 sr-1 um-1, and emissivity, all of shape (line,
        sample, wavelength).
    """
    known = _but(locals(), "scene", "set", "pixels", "false_colour", "show")
    commas = {"false_colour": false_colour, "show": show}
    words = {name: ",".join(map(str, of)) for name, of in commas.items() if of is not None}
    size = None if pixels is None else "x".join(map(str, pixels))
    file = _scene_file(scene, Path(out))
    run(["image", os.fspath(file), *options(set=_changes(set), pixels=size, **known, **words)])
    data = {}
    for name, units in (
        ("radiance", "W m-2 sr-1 um-1"),
        ("radiance_standard_error", "W m-2 sr-1 um-1"),
        ("emissivity", "1"),
    ):
        size, um, values = _soilsig.cube(os.fspath(Path(out) / f"{name}.img"))
        by_band = array(values).reshape(-1, *size)
        dimensions = ("line", "sample", "wavelength")
        data[name] = xr.Variable(dimensions, np.moveaxis(by_band, 0, -1), {"units": units})
    return xr.Dataset(data, {"wavelength": coordinate(array(um))})


def _is_coverage(scene: AnyScene) -> bool:
    if isinstance(scene, (int, float)):
        return True
    return isinstance(scene, str) and (scene in COVERAGES or not _is_path(scene))


def _is_path(text: str) -> bool:
    """Whether a text names a file rather than a coverage, which may be a share such as 0.3."""
    return "/" in text or text.endswith(".json")


def _scene_file(scene: AnyScene, folder: Path) -> Path:
    """The file of a scene; of a scene's content a new one in the folder."""
    if isinstance(scene, (str, os.PathLike)):
        return Path(scene)
    scene = Scene(scene)
    return scene.write(folder / f"{scene.name}.json")


def _but(given: dict[str, Any], *others: str) -> dict[str, Any]:
    """What a function was given, by name, but for what is no option of the command line."""
    return {name: value for name, value in given.items() if name not in others}


def _changes(set: Mapping[str, Any] | None) -> list[str]:
    return [f"{key}={json.dumps(value)}" for key, value in (set or {}).items()]


def _prior(name: str, of: float | tuple[float, float]) -> str:
    return f"{name}={of[0]}+-{of[1]}" if isinstance(of, tuple) else f"{name}={of}"
