"""The notebooks of the guide run. With SOILSIG_WRITE_NOTEBOOKS they keep what they show."""

import os
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from conftest import NEEDS_BLENDER, ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "guide" / "notebooks").glob("*.ipynb"))


def figures(notebook):
    """The number of pictures of each cell."""
    return [
        sum("image/png" in output.get("data", {}) for output in cell.outputs)
        for cell in notebook.cells
        if cell.cell_type == "code"
    ]


@NEEDS_BLENDER
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_keeps_its_figures(path, tmp_path, monkeypatch):
    # The kernel is this Python, wherever others are installed.
    monkeypatch.setenv("PATH", os.path.dirname(sys.executable) + os.pathsep + os.environ["PATH"])
    monkeypatch.setenv("TQDM_DISABLE", "1")
    kept = nbformat.read(path, as_version=4)
    done = nbformat.from_dict(kept)
    resources = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(done, timeout=600, kernel_name="python3", resources=resources).execute()
    for cell in done.cells:
        for output in cell.get("outputs", []):
            assert output.get("name") != "stderr", output["text"]
    if "SOILSIG_WRITE_NOTEBOOKS" in os.environ:
        for cell in done.cells:
            cell.metadata.pop("execution", None)
        nbformat.write(done, path)
        kept = done
    assert sum(figures(done)) > 0
    assert figures(done) == figures(kept), "run this test with SOILSIG_WRITE_NOTEBOOKS=1"


def test_there_are_three_notebooks_below_a_megabyte():
    assert [path.stem for path in NOTEBOOKS] == ["first_run", "match_a_soil", "minerals_and_sensor"]
    assert all(Path(path).stat().st_size < 1_000_000 for path in NOTEBOOKS)
