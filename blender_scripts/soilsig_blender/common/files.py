"""Files and folders appear whole or not at all: they are written beside, then renamed."""

import os
import shutil
from contextlib import contextmanager

# Files of a bed that are written on request, of the first of several beds.
EXTRA = ("scene.glb", "scene.blend", "frames.json", "patch.obj")


@contextmanager
def whole(folder, name):
    """A path to write to; on success the file takes its name, on failure it is removed."""
    stem, _, ending = name.rpartition(".")
    beside = os.path.join(folder, f".{stem}.part.{ending}")
    with _renamed(beside, os.path.join(folder, name), os.remove):
        yield beside


@contextmanager
def whole_folder(folder, name):
    """A new folder to fill; on success it takes its name, on failure it is removed."""
    beside = os.path.join(folder, f".{name}.part")
    # A process that was killed may have left it.
    shutil.rmtree(beside, ignore_errors=True)
    os.makedirs(beside)
    with _renamed(beside, os.path.join(folder, name), shutil.rmtree):
        yield beside


@contextmanager
def _renamed(beside, place, remove):
    try:
        yield
        os.replace(beside, place)
    finally:
        if os.path.exists(beside):
            remove(beside)
