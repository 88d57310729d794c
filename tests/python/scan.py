"""Bodies with hollows for the tests: one like a scan, and one that is simple to compute."""

import numpy as np
from soilsig_blender.common.sphere import sphere
from soilsig_blender.model.mesh_faults import TriangleMesh

# A prism over an L: a bar of 100 x 40 x 40 um with an arm of 40 x 60 x 40 um. 256000 um3.
_L = [(0, 0), (100, 0), (100, 40), (40, 40), (40, 100), (0, 100)]
_L_CUT = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]


def scan(halvings, seed=1):
    """A pebble of 8 x 4^halvings triangles with bites out of it and the noise of a scan, um."""
    vertices, faces = sphere(halvings)
    rng = np.random.default_rng(seed)
    shape = vertices * (300, 240, 200)
    for _ in range(4):
        at = rng.standard_normal(3)
        angle = np.arccos(np.clip(vertices @ at / np.linalg.norm(at), -1, 1))
        shape = shape * (1 - 0.4 * np.exp(-0.5 * (angle / 0.3) ** 2))[:, None]
    noise = 1 + 0.1 / 2**halvings * (2 * rng.random(len(vertices)) - 1)
    return TriangleMesh(shape * noise[:, None], faces, np.arange(len(faces)))


def bracket():
    low, high = ([(*p, z) for p in _L] for z in (0, 40))
    caps = [t[::-1] for t in _L_CUT] + [tuple(i + 6 for i in t) for t in _L_CUT]
    around = [(i, (i + 1) % 6) for i in range(6)]
    sides = [t for i, j in around for t in ((i, j, j + 6), (i, j + 6, i + 6))]
    return TriangleMesh.of_faces(np.array(low + high, float), caps + sides)
