"""The scene file of a bed of the user's own grains: a recipe for `soilsig pipeline --scene`."""

import math
import os

from ..common.errors import BedError
from ..model.own_grains import entries
from . import json_files

# As in the shipped scenes: the tray's area for each grain as a share of its squared diameter, and
# the rim that is left out, in mean diameters.
_AREA = 0.56
_RIM = 0.9
# The fines of the shipped scenes: a fifth by number are the larger ones. They lie in one layer, and
# neighbours may overlap.
FINES = (("fine_35", "flake", 35.0, 0.8), ("fine_60", "chip", 60.0, 0.2))
DUST = {"layers": 1, "overlap": 1.0}
_DROP = {
    "collision": "hull",
    "substeps": 6,
    "iterations": 30,
    "max_frames": 400,
    "scale": 6.5,
    "gravity": 98.1,
    "margin": 0.04,
}


def fine_classes(grains=None):
    """The classes of fines: own grains where some stand for their shape."""
    of = _by_shape(grains or {})
    return [
        {
            "name": name,
            "shape": {"library": of[shape]} if shape in of else shape,
            "diameter_um": diameter,
            "material": "fine",
            "share": share,
        }
        for name, shape, diameter, share in FINES
    ]


def scene(name, grains, library, count, fines, seed, rim=_RIM):
    """The scene of `count` grains, an equal share for each shape of `grains` (name: entry).

    `fines` is a number for each grain, or `{"silhouette": share}`; `library` the folder, relative
    to the scene file.
    """
    of_fines = [shape for _, shape, _, _ in FINES]
    of = {shape: names for shape, names in _by_shape(grains).items() if shape not in of_fines}
    if not of:
        raise BedError(
            "scene",
            "no grain of the library stands for angular, subangular or worn",
            "assign one of these shapes to a grain and save it",
        )
    classes = []
    for number, (shape, names) in enumerate(sorted(of.items())):
        share = count // len(of) + (number < count % len(of))
        diameter = sum(grains[n]["diameter_um"] for n in names) / len(names)
        classes.append(
            {
                "name": shape,
                "shape": {"library": names},
                "diameter_um": round(diameter, 3),
                "material": "coarse",
                "count": share,
                "fines": fines,
            }
        )
    squares = sum(c["count"] * c["diameter_um"] ** 2 for c in classes)
    mean = sum(c["count"] * c["diameter_um"] for c in classes) / count
    widest = max(c["diameter_um"] for c in classes)
    side = max(math.sqrt(_AREA * squares), 2.6 * widest, (2 * rim + 1) * mean)
    none = fines in (0, {"silhouette": 0})
    return {
        "soilsig_scene": 1,
        "name": name,
        "seed": seed,
        "temperature_k": 300,
        "view": {"zenith_deg": 0, "azimuth_deg": 0},
        "materials": [
            {"name": "fine", "spectrum": {"builtin": "quartz_fine"}},
            {"name": "coarse", "spectrum": {"builtin": "quartz_coarse"}},
            {"name": "floor", "spectrum": {"builtin": "quartz_fine"}},
        ],
        "geometry": {
            "packing": {
                "seed": seed,
                "library": library,
                "grains": classes,
                "fines": [] if none else fine_classes(grains),
                "dust": DUST,
                "variants": 2,
                "tray_um": [math.ceil(side / 100) * 100] * 2,
                "crop_um": round(rim * mean),
                "floor_material": "floor",
                "drop": _DROP,
            }
        },
    }


def export(path, library, count, fines, seed):
    """Writes the scene of all grains of a library beside it or elsewhere; returns it."""
    folder = os.path.dirname(os.path.abspath(path))
    name = os.path.splitext(os.path.basename(path))[0]
    relative = os.path.relpath(library, folder)
    made = scene(name, entries(library), relative, count, fines, seed)
    json_files.write(path, made)
    return made


def _by_shape(grains):
    of = {}
    for name, entry in sorted(grains.items()):
        of.setdefault(entry["shape"], []).append(name)
    return of
