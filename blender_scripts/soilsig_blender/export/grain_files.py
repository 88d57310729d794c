"""A grain of the user's own as two files: NAME.obj, its bare body, and NAME.json about it."""

import os

from ..common.errors import BedError
from ..common.files import whole
from ..model.own_grains import NAME, VERSION, describe
from . import json_files, obj_files


def save(folder, name, body, size_class, made_from):
    """Writes a grain into the library; what had its name is replaced. Returns its entry."""
    if not NAME.fullmatch(name):
        raise BedError(
            "scene", f"{name!r} cannot name a grain", "use up to 40 letters, digits, _ and -"
        )
    os.makedirs(folder, exist_ok=True)
    entry = {
        "soilsig_grain": VERSION,
        "size_class": size_class,
        **describe(body),
        "made_from": made_from,
    }
    with whole(folder, f"{name}.obj") as path:
        obj_files.write_bodies(path, {name: body})
    with whole(folder, f"{name}.json") as path:
        json_files.write(path, entry)
    return entry
