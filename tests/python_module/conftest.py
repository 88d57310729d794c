"""What the tests of the Python module share."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import soilsig

ROOT = Path(__file__).parents[2]
PATCH = ROOT / "scenes" / "settled_patch.json"
NEEDS_BLENDER = pytest.mark.skipif(
    "SOILSIG_BLENDER" not in os.environ, reason="no Blender: SOILSIG_BLENDER names none"
)


@pytest.fixture(scope="session")
def table(tmp_path_factory):
    """A traced patch, and the bounce table's file."""
    file = tmp_path_factory.mktemp("patch") / "table.json"
    table = soilsig.trace(PATCH, out=file, tolerance=0.05, range=(8, 12), step=0.5)
    table.file = file
    return table


@pytest.fixture
def program():
    """The command line, as a program: its arguments give what it printed."""

    def run(*args, status=0):
        command = [sys.executable, "-m", "soilsig", *map(str, args)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stderr
        return done.stdout, done.stderr

    return run
