"""The user's grains: a folder with NAME.obj, one bare body, and NAME.json about it. Micrometres."""

import json
import os
import re

import numpy as np

from ..common.errors import BedError
from .body_check import check
from .convex_hull import FLATNESS, hull_of
from .descriptors import feret_axes, roundness_class
from .hollow_body import HollowBody
from .mesh_faults import TriangleMesh, faults, is_hollow
from .shapes import equivalent_diameter, known, measure

VERSION = 1
# Files and objects in a .obj are called by these names.
# Corners of a body that is kept as planes.
_MANY = 500
NAME = re.compile(r"[A-Za-z0-9_-]{1,40}")


def body_of(mesh: TriangleMesh):
    """A sound mesh as the body that it is: a `Polyhedron` if it is convex, else a `HollowBody`.

    Of many corners it is a `HollowBody` in any case: planes would be slower than a tree.
    """
    corners = mesh.vertices[np.unique(mesh.triangles)]
    if len(corners) <= _MANY:
        try:
            hull = hull_of(corners)
        except ValueError as error:
            raise BedError("scene", f"the mesh is no body: {error}", "give it a volume") from error
        if not is_hollow(mesh, hull):
            check(hull, "the hull of a grain", 2 * FLATNESS)
            return hull
    return HollowBody.of(mesh.vertices, mesh.triangles)


def normalised(body, diameter):
    """About its centroid, its volume that of a sphere of `diameter`."""
    volume, centre = body.volume_and_centroid
    return body.moved(np.eye(3), -centre).scaled(diameter / equivalent_diameter(volume))


def describe(body):
    """What a body measures, as the table of shapes has it."""
    reached = measure(body)
    return {
        "diameter_um": round(equivalent_diameter(body.volume_and_centroid[0]), 4),
        "descriptors": reached | {"convexity": round(body.convexity, 6)},
        "roundness_class": roundness_class(reached["roundness"]),
        "feret_um": [round(x, 4) for x in feret_axes(body.outermost)[0].tolist()],
    }


def entries(folder):
    """The grains of a library by name, what their files say of them."""
    found = {}
    for file in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        stem, ending = os.path.splitext(file)
        if ending != ".json" or file.startswith("."):
            continue
        path = os.path.join(folder, file)
        try:
            with open(path, encoding="utf-8") as text:
                entry = json.load(text)
        except ValueError as error:
            raise BedError("scene", f"{path} is not JSON: {error}", "correct the file") from error
        if not isinstance(entry, dict) or entry.get("soilsig_grain") != VERSION:
            continue
        shape = known(entry.get("shape", entry.get("size_class")))
        if shape:
            found[stem] = {**entry, "shape": shape}
    return found


def load(folder, name):
    """A grain's body, or an error that names it."""
    path = os.path.join(folder, f"{name}.obj")
    try:
        mesh = _read_obj(path)
    except (OSError, ValueError, IndexError) as error:
        raise BedError("scene", f"{path}: {error}", "see `soilsig grains check FOLDER`") from error
    found = faults(mesh)
    if found:
        raise BedError("scene", f"{path}: {found[0].what}", "see `soilsig grains check FOLDER`")
    return body_of(mesh)


def _read_obj(path):
    vertices, faces = [], []
    with open(path, encoding="utf-8") as text:
        for line in text:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(word) for word in words[1:4]])
            elif words[:1] == ["f"]:
                corners = [int(word.split("/")[0]) for word in words[1:]]
                faces.append([c - 1 if c > 0 else len(vertices) + c for c in corners])
    return TriangleMesh.of_faces(np.array(vertices).reshape(-1, 3), faces)
