"""Runs, scenes and images."""

import inspect
import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import soilsig
from conftest import NEEDS_BLENDER, PATCH, ROOT


def test_the_same_bytes_as_by_the_command_line(program, tmp_path):
    options = {"tolerance": 0.05, "seed": 3, "range": (8, 12), "step": 0.5}
    soilsig.trace(PATCH, out=tmp_path / "a.json", set={"view.zenith_deg": 35}, **options)
    words = ["--tolerance", "0.05", "--seed", "3", "--range", "8-12", "--step", "0.5"]
    program("trace", PATCH, "--out", tmp_path / "b.json", "--set", "view.zenith_deg=35", *words)
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_a_scene_by_its_content_is_that_of_its_file(tmp_path, monkeypatch):
    by_file = soilsig.trace(PATCH, out=tmp_path / "a.json", tolerance=0.05)
    scene = soilsig.Scene(PATCH)
    assert scene.name == "settled_patch"
    monkeypatch.chdir(tmp_path)
    for given in (scene, scene.content):
        found = soilsig.trace(given, out="b/table.json", tolerance=0.05)
        xr.testing.assert_equal(found.emissivity(), by_file.emissivity())
    assert (tmp_path / "b" / "settled_patch.json").exists()
    content = json.loads(PATCH.read_text())
    monkeypatch.chdir(PATCH.parent)
    assert soilsig.Scene(content).content == scene.content


def test_an_image_is_a_dataset(tmp_path):
    image = soilsig.image(
        PATCH, out=tmp_path / "image", noise=0.1, pixels=(6, 4), range=(8, 12), step=1
    )
    assert image.radiance.dims == ("line", "sample", "wavelength")
    assert image.radiance.shape == (4, 6, 5)
    assert image.wavelength.values.tolist() == [8, 9, 10, 11, 12]
    assert float(image.radiance.min()) > 0 and float(image.emissivity.max()) <= 1
    raw = np.fromfile(tmp_path / "image" / "radiance.img", dtype="<f4").reshape(5, 4, 6)
    assert np.array_equal(image.radiance.values, raw.transpose(1, 2, 0))


def test_a_placed_scene_runs_through_the_pipeline(tmp_path, program):
    run = soilsig.pipeline(
        PATCH, out=tmp_path / "a", tolerance=0.05, range=(8, 12), step=0.5, no_cache=True
    )
    assert run.report.exists() and run.record["options"]["tolerance"] == 0.05
    assert run.record["command"][:2] == ["soilsig", "pipeline"]
    grid = ["--range", "8-12", "--step", "0.5"]
    words = ["--tolerance", "0.05", "--no-cache", *grid]
    program("pipeline", "--scene", PATCH, "--out", tmp_path / "b", *words)
    for name in ["signature.csv", "signature.nc", "table.json", "budget.csv", "signature.svg"]:
        ours, theirs = ((tmp_path / folder / name).read_bytes() for folder in "ab")
        assert ours == theirs, name
    lines = (tmp_path / "a" / "budget.csv").read_text().splitlines()
    assert len(lines) == 1 + run.budget.wavelength.size
    assert soilsig.Run(tmp_path / "a").record == run.record


def test_a_study_is_a_dataset(tmp_path, program):
    study = json.loads((ROOT / ".test" / "study.json").read_text())
    study["source"] = {"scene": str(PATCH)}
    study["axes"].append({"name": "kelvin", "key": "temperature_k", "values": [300, 310]})
    found = soilsig.sweep(study, out=tmp_path / "a" / "view")
    program("sweep", tmp_path / "a" / "view.study.json", "--out", tmp_path / "b")
    for name in ["results.csv", "beds.csv", "results.nc"]:
        assert (found.folder / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    results = found.results
    assert results.point.values.tolist() == [1, 2, 3, 4, 5, 6]
    assert results.zenith_deg.values.tolist() == [0, 0, 20, 20, 40, 40]
    assert results.beds.values.tolist() == [2] * 6 and found.failures == []
    table = found.table(3, seed=2)
    beds = (found.folder / "beds.csv").read_text().splitlines()
    row = dict(zip(beds[0].split(","), beds[6].split(",")))
    assert (row["point"], row["seed"]) == ("3", "2")
    assert table.paths == int(row["paths"])
    with pytest.raises(KeyError):
        found.table(7)
    assert soilsig.sweep(tmp_path / "a" / "view.study.json", out=tmp_path / "c", part="1/6") is None


def test_results_are_compared_and_retrieved(tmp_path, program):
    grid = {"range": (8, 12), "step": 0.5, "no_cache": True, "tolerance": 0.05}
    runs = [
        soilsig.pipeline(PATCH, out=tmp_path / name, set={"materials.fine.spectrum": of}, **grid)
        for name, of in [("a", {"builtin": "quartz_fine"}), ("b", {"constant": 0.5})]
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        apart = soilsig.diff(runs[0].folder, runs[1].folder)
    said, _ = program("diff", runs[0].folder, runs[1].folder, status=5)
    assert apart.attrs == {"text": said, "differ": 1}
    off = runs[1].signature.emissivity - runs[0].signature.emissivity
    np.testing.assert_allclose(apart.difference, off, atol=2e-7)
    assert soilsig.diff(runs[0].folder, runs[0].folder).attrs["differ"] == 0
    signature = runs[0].folder / "signature.csv"
    found = soilsig.retrieve(signature, temperature=300)
    np.testing.assert_allclose(found.emissivity, runs[0].signature.emissivity, atol=1e-5)
    assert found.brightness_temperature_k.attrs["units"] == "K"
    page = soilsig.report(*runs, out=tmp_path / "both.html")
    program("report", *(run.folder for run in runs), "--out", tmp_path / "again.html")
    assert page.read_bytes() == (tmp_path / "again.html").read_bytes()


def test_every_command_can_be_called(tmp_path, program):
    words = soilsig.run(["--help"]).text.split("Commands:")[1].split("Options:")[0]
    commands = re.findall(r"^  ([a-z]+)", words, re.MULTILINE)
    assert {"pipeline", "trace", "match", "retrieve", "schema"} <= set(commands)
    for command in set(commands) - {"help"}:
        assert "Usage: soilsig" in soilsig.run([command, "--help"]).text
    listed = soilsig.run(["spectra", "list"])
    assert listed.text == program("spectra", "list")[0] == str(listed)


def test_a_call_takes_every_option_of_its_command():
    # What Python has in another way: what was made is returned, not printed; charts are drawn by
    # other packages; a comparison has two curves.
    other = {"json", "verbose", "help", "plot", "bare-figure", "beside", "budget"}
    named = {
        "coverage": "scene",
        "spectrum": "spectra",
        "range": "wavelength",
        "step": "wavelength",
    }
    for command, call in {
        "pipeline": soilsig.pipeline,
        "trace": soilsig.trace,
        "signature": soilsig.Table.signature,
        "image": soilsig.image,
        "match": soilsig.match,
        "sweep": soilsig.sweep,
        "retrieve": soilsig.retrieve,
        "diff": soilsig.diff,
        "report": soilsig.report,
    }.items():
        text = soilsig.run([command, "--help"]).text
        options = set(re.findall(r"^ +(?:-\w, )?--([a-z-]+)", text, re.MULTILINE)) - other
        assert len(options) > 1, command
        has = set(inspect.signature(call).parameters)
        if command in {"signature", "diff", "retrieve", "report"}:
            # These give a Dataset or a page in a moment.
            options -= {"out", "threads"}
        for option in options:
            name = option.replace("-", "_")
            assert {name, named.get(name)} & has, f"{command} --{option}"


def test_the_program_takes_part_in_pipes():
    command = [sys.executable, "-m", "soilsig", "schema", "scene"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["title"]
    assert soilsig.run(["schema", "scene"]).text == done.stdout


@NEEDS_BLENDER
def test_a_recipe_becomes_a_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = json.loads((ROOT / "scenes" / "small.json").read_text())
    options = {"tolerance": 0.05, "range": (8, 12), "step": 0.5, "packings": 2}
    run = soilsig.pipeline(scene, **options)
    assert run.folder.as_posix() == f"out/{scene['name']}"
    assert run.table.paths == sum(
        soilsig.Table(f"{run.folder}/packings/{i}/table.json").paths for i in (1, 2)
    )
    assert "emissivity_sd_packings" in run.signature
    again = soilsig.run(["replay", run.folder / "run.json"])
    assert "the same result" in again.text


@pytest.mark.skipif("SOILSIG_TEST_BPY" not in os.environ, reason="no Python with bpy")
def test_the_bpy_beside_the_module_is_found(tmp_path):
    command = [os.environ["SOILSIG_TEST_BPY"], "-m", "soilsig", "doctor", "--json"]
    environment = {name: of for name, of in os.environ.items() if name != "SOILSIG_BLENDER"}
    # The module alone of this environment, in the other one.
    (tmp_path / "soilsig").symlink_to(Path(soilsig.__file__).parent)
    environment["PYTHONPATH"] = str(tmp_path)
    environment["PATH"] = ""
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd="/")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Python of soilsig" in done.stdout
