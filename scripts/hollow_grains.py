"""Writes grains of the three shapes with hollows and without: two libraries for `--grains`.

PYTHON_WITH_BPY scripts/hollow_grains.py FOLDER    makes FOLDER/convex and FOLDER/hollow

A grain is a modelled convex body, looked at from its middle in some thousand directions. The hollow
one has scoops in it, parts of spheres as conchoidal fractures are. Both have the same
volume, so they differ in the hollows alone.
"""

import os
import sys

import bpy  # noqa: F401 gives mathutils
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../blender_scripts"))

from soilsig_blender.common.randomness import stream
from soilsig_blender.common.sphere import sphere
from soilsig_blender.export import grain_files
from soilsig_blender.model import own_grains, shapes
from soilsig_blender.model.hollow_body import HollowBody

HALVINGS = 4
VARIANTS = 3
# Scoops of a grain; radius of their spheres and depth of each, as shares of the grain's diameter.
SCOOPS = 7
RADIUS = (0.25, 0.5)
DEPTH = (0.08, 0.16)


def seen_from_within(body, directions, scoops=()):
    """The star-shaped body of the least way out of a convex body or into one of the spheres."""
    along = directions @ body.normals.T
    away = np.where(along > 1e-9, body.offsets / np.maximum(along, 1e-9), np.inf).min(axis=1)
    for centre, radius in scoops:
        towards = directions @ centre
        under = towards**2 - centre @ centre + radius**2
        entry = towards - np.sqrt(np.maximum(under, 0))
        away = np.where((under > 0) & (towards > 0), np.minimum(away, entry), away)
    return directions * away[:, None]


def scoops(body, diameter, rng):
    directions = rng.standard_normal((SCOOPS, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    surface = seen_from_within(body, directions)
    radius = diameter * rng.uniform(*RADIUS, SCOOPS)
    depth = diameter * rng.uniform(*DEPTH, SCOOPS)
    return [
        (point + direction * (r - d), r)
        for point, direction, r, d in zip(surface, directions, radius, depth)
    ]


def main(folder):
    directions, triangles = sphere(HALVINGS)
    for shape_name in ("angular", "subangular", "worn"):
        shape = shapes.SHAPES[shape_name]
        for variant in range(VARIANTS):
            rng = stream(1, "hollow", shape.scene_class, variant)
            body = shapes.model(shape, shape.diameter_um, rng)
            for kind, bites in (("convex", ()), ("hollow", scoops(body, shape.diameter_um, rng))):
                vertices = seen_from_within(body, directions, bites)
                grain = own_grains.normalised(HollowBody.of(vertices, triangles), shape.diameter_um)
                name = f"{shape_name}_{variant}"
                entry = grain_files.save(
                    os.path.join(folder, kind), name, grain, shape_name, {"scoops": len(bites)}
                )
                print(kind, name, entry["descriptors"])


if __name__ == "__main__":
    main(sys.argv[1])
