"""A grain of the user's own as two files: NAME.obj, its bare body, and NAME.json about it."""

import os

from ..common.errors import BedError
from ..common.files import whole
from ..model.own_grains import NAME, VERSION, describe
from . import json_files, obj_files


def save(folder, name, body, shape, made_from):
    """Writes a grain that stands for a shape into the library. Returns its entry.

    What had its name is replaced.
    """
    if not NAME.fullmatch(name):
        raise BedError(
            "scene", f"{name!r} cannot name a grain", "use up to 40 letters, digits, _ and -"
        )
    os.makedirs(folder, exist_ok=True)
    entry = {
        "soilsig_grain": VERSION,
        "shape": shape,
        **describe(body),
        "made_from": made_from,
    }
    with whole(folder, f"{name}.obj") as path:
        obj_files.write_bodies(path, {name: body})
    with whole(folder, f"{name}.json") as path:
        json_files.write(path, entry)
    return entry
