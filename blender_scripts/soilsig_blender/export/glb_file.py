"""The bed as a binary glTF 2.0 file: every mesh once, and a node for every grain and its fines.

Blender's own exporter is not used: it takes as long as a drop, and its bytes depend on its version.
"""

import json
import struct

import numpy as np

from .colours import colours

_METRES = 1e-6
# Numbers of the specification: how numbers are written, and what for.
_FLOAT, _SHORT, _INT = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963
# glTF has y up: a turn by -90 degrees about x, as x, y, z and w of a quaternion.
_UPRIGHT = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]


def write_glb(path, materials, prototypes, drop):
    """Grains and fines in metres, y up."""
    worn = {surface.material for p in prototypes for surface in p.surfaces}
    looks = {name: rgb for name, rgb in zip(materials, colours(materials)) if name in worn}
    buffer, materials, meshes = _Buffer(), list(looks), []
    mesh_of = [
        [_mesh(meshes, buffer, p.name, (p.core,), materials)]
        + ([_mesh(meshes, buffer, f"{p.name}.fines", p.coats, materials)] if p.coats else [])
        for p in prototypes
    ]
    nodes = [{"name": "bed", "rotation": _UPRIGHT, "children": []}]
    for i, (p, pose) in enumerate(zip(drop.prototype_of, drop.poses)):
        matrix = pose.copy()
        matrix[:3, 3] *= _METRES
        name = f"{prototypes[p].name}.{i:04d}"
        nodes[0]["children"].append(len(nodes))
        nodes.append({"name": name, "mesh": mesh_of[p][0], "matrix": matrix.T.ravel().tolist()})
        for fines in mesh_of[p][1:]:
            nodes[-1]["children"] = [len(nodes)]
            nodes.append({"name": f"{name}.fines", "mesh": fines})
    content = {
        "asset": {"version": "2.0", "generator": "soilsig"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "materials": [_material(name, rgb) for name, rgb in looks.items()],
        "meshes": meshes,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": buffer.length}],
    }
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    chunks = [(b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", b"".join(buffer.parts))]
    with open(path, "wb") as out:
        out.write(struct.pack("<4sII", b"glTF", 2, 12 + sum(8 + len(c) for _, c in chunks)))
        for kind, chunk in chunks:
            out.write(struct.pack("<I4s", len(chunk), kind) + chunk)


def _mesh(meshes, buffer, name, surfaces, materials):
    """Adds a mesh, a part for each surface; returns its number."""
    primitives = []
    for surface in surfaces:
        vertices = (surface.vertices * _METRES).astype("<f4")
        limits = {"min": vertices.min(axis=0).tolist(), "max": vertices.max(axis=0).tolist()}
        # The greatest short is reserved.
        number, kind = ("<u2", _SHORT) if len(vertices) < 2**16 else ("<u4", _INT)
        indices = surface.triangles.astype(number).ravel()
        primitives.append(
            {
                "attributes": {
                    "POSITION": buffer.add(vertices, _FLOAT, "VEC3", _VERTICES, **limits)
                },
                "indices": buffer.add(indices, kind, "SCALAR", _INDICES),
                "material": materials.index(surface.material),
            }
        )
    meshes.append({"name": name, "primitives": primitives})
    return len(meshes) - 1


def _material(name, rgb):
    look = {"baseColorFactor": [*rgb, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8}
    return {"name": name, "doubleSided": True, "pbrMetallicRoughness": look}


class _Buffer:
    """Arrays one after another, and how the file tells of them."""

    def __init__(self):
        self.parts, self.views, self.accessors, self.length = [], [], [], 0

    def add(self, array, component, kind, target, **limits):
        """Adds an array; returns the number of its accessor."""
        part = np.ascontiguousarray(array).tobytes()
        part += bytes(-len(part) % 4)
        self.views.append(
            {
                "buffer": 0,
                "byteOffset": self.length,
                "byteLength": len(part),
                "target": target,
            }
        )
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": component,
                "count": len(array),
                "type": kind,
                **limits,
            }
        )
        self.parts.append(part)
        self.length += len(part)
        return len(self.accessors) - 1
