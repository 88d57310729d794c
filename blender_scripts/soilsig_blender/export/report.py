"""drop.json: what was modelled, how it came to rest, what the checks found and how long it took."""

import platform

import bpy
import numpy as np

from ..common.recipe import is_own
from ..dust.prototype import own_grain
from ..model.shapes import measure, shape_of


def versions():
    """The programs that a result depends on."""
    return {
        "blender": bpy.app.version_string,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }


def report(prototypes, drop, attempts, checks, bed):
    """The report without the times of the stages."""
    return {
        "versions": versions(),
        "prototypes": [_prototype(prototype) for prototype in prototypes],
        "settle": {
            "settled": drop.settled,
            "frames": drop.frames,
            "mean_energy_mgd": drop.mean_energy,
            "top_speed_sqrt_gd": drop.top_speed,
        },
        "attempts": attempts,
        "checks": checks,
        "bed": bed,
    }


def _prototype(prototype):
    grain_class = prototype.grain_class
    reached = measure(prototype.grain)
    # The user's own grains have no targets.
    shape = None if is_own(grain_class["shape"]) else shape_of(grain_class["shape"])
    asked = shape.asked if shape else dict.fromkeys(reached)
    variant = int(prototype.name.rpartition("_")[2])
    dust, fines = prototype.dust, prototype.fines
    kinds = np.bincount(dust.kind, minlength=len(fines))
    by_class = prototype.cover.silhouette_by(dust.kind, len(fines))
    return {
        "name": prototype.name,
        "class": grain_class["name"],
        "shape": grain_class["shape"] if shape else own_grain(grain_class, variant),
        "diameter_um": grain_class["diameter_um"],
        "volume_um3": prototype.volume_um3,
        "triangles": prototype.triangle_count,
        "fines_asked": grain_class["fines"],
        "fines": {fine.name: int(n) for fine, n in zip(fines, kinds)},
        "cover": {
            "surface": prototype.cover.surface(len(dust)),
            "silhouette": prototype.cover.silhouette(len(dust)),
            "by_class": {fine.name: float(share) for fine, share in zip(fines, by_class)},
        },
        "layers": np.bincount(dust.layer)[1:].tolist(),
        "facets": len(prototype.grain.facets),
        "convexity": round(prototype.grain.convexity, 6),
        "edge_radius_um": shape.edge_radius * grain_class["diameter_um"] if shape else None,
        **{name: {"asked": asked.get(name), "reached": value} for name, value in reached.items()},
    }
