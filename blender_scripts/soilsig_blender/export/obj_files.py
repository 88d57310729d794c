"""Wavefront .obj in micrometres, one object a prototype, faces grouped by material.

Blender's exporter is not used: it prints six decimals of a unit, and the order of faces depends on
its version.
"""

import numpy as np


def write_prototypes(path, prototypes):
    with open(path, "w", encoding="utf-8", newline="\n") as out:
        out.write("# micrometres, z up\nmtllib prototypes.mtl\n")
        first = 1
        for prototype in prototypes:
            out.write(f"o {prototype.name}\n")
            first = _write_object(out, prototype, None, first)


def write_bodies(path, bodies):
    """Bare convex bodies by name, facet by facet."""
    with open(path, "w", encoding="utf-8", newline="\n") as out:
        out.write("# micrometres\n")
        first = 1
        for name, body in bodies.items():
            out.write(f"o {name}\n")
            out.write(
                "".join([f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in body.vertices.tolist()])
            )
            for loop in body.facets:
                out.write(f"f {' '.join(str(corner + first) for corner in loop)}\n")
            first += len(body.vertices)


def write_materials(path, names):
    with open(path, "w", encoding="utf-8", newline="\n") as out:
        out.writelines(f"newmtl {name}\n" for name in names)


def _write_object(out, prototype, pose, first):
    for surface in prototype.surfaces:
        vertices = surface.vertices
        if pose is not None:
            vertices = vertices @ pose[:3, :3].T + pose[:3, 3]
        # One format for all lines takes half as long as one for each.
        out.write("v %.9g %.9g %.9g\n" * len(vertices) % tuple(vertices.ravel().tolist()))
        out.write(f"usemtl {surface.material}\n")
        faces = (surface.triangles + first).ravel().tolist()
        out.write("f %d %d %d\n" * len(surface.triangles) % tuple(faces))
        first += len(vertices)
    return first


def write_patch(path, prototypes, prototype_of, poses):
    """The settled bed flat, every grain where it lies."""
    with open(path, "w", encoding="utf-8", newline="\n") as out:
        out.write("# micrometres, z up\nmtllib prototypes.mtl\n")
        first = 1
        for i, (p, pose) in enumerate(zip(prototype_of, np.asarray(poses))):
            out.write(f"o {prototypes[p].name}.{i:04d}\n")
            first = _write_object(out, prototypes[p], pose, first)
