"""Is any mesh a grain: closed, turned outward, in one piece, free of self-intersection?

Each fault names the faces where it is, so that they can be selected in the window.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .blender_meshes import box_tree
from .convex_hull import depth_below
from .polyhedron import volume_and_centroid

# A face deeper below the hull than this share of the extent is a hollow. Less is levelled.
HOLLOW = 2e-3


@dataclass(frozen=True)
class TriangleMesh:
    """Triangles and the faces that they are of."""

    vertices: np.ndarray  # (V, 3)
    triangles: np.ndarray  # (T, 3)
    face: np.ndarray  # (T,)

    @classmethod
    def of_faces(cls, vertices, faces):
        """Of polygons, each as a fan."""
        fans = [(loop[0], b, c) for loop in faces for b, c in pairwise(loop[1:])]
        face = np.repeat(np.arange(len(faces)), [max(len(loop) - 2, 0) for loop in faces])
        return cls(np.asarray(vertices, float), np.array(fans, int).reshape(-1, 3), face)


@dataclass(frozen=True)
class Fault:
    """What is wrong, and at which faces."""

    what: str
    faces: tuple


def faults(mesh: TriangleMesh):
    """Everything that is wrong with a grain's mesh; nothing if it is sound."""
    if not len(mesh.triangles):
        return [Fault("it has no faces", ())]
    if not np.isfinite(mesh.vertices).all():
        bad = ~np.isfinite(mesh.vertices).all(axis=1)
        return [_at(mesh, bad[mesh.triangles].any(axis=1), "{} have a corner that is no number")]
    found = [_flat(mesh), *_edges(mesh)]
    found = [fault for fault in found if fault]
    if not found:
        # Only a closed surface has an outside.
        found += [_pieces(mesh), _inside_out(mesh), _through_itself(mesh)]
    return [fault for fault in found if fault]


def _at(mesh, triangles, words):
    """The fault of these triangles, if there are any."""
    faces = np.unique(mesh.face[triangles])
    if not len(faces):
        return None
    count = "1 face" if len(faces) == 1 else f"{len(faces)} faces"
    middle = mesh.vertices[mesh.triangles[mesh.face == faces[0]]].reshape(-1, 3).mean(axis=0)
    place = ", ".join(f"{x:.4g}" for x in middle)
    return Fault(f"{words.format(count)}, near ({place}) um", tuple(faces.tolist()))


def _flat(mesh):
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    of_face = np.zeros(mesh.face.max() + 1)
    np.add.at(of_face, mesh.face, area)
    flat = of_face <= 1e-12 * np.ptp(mesh.vertices, axis=0).max() ** 2
    return _at(mesh, flat[mesh.face], "{} without area")


def _edges(mesh):
    """Every edge must be run along once in each direction."""
    sides = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    owner = np.repeat(np.arange(len(mesh.triangles)), 3)
    low, high = sides.min(axis=1), sides.max(axis=1)
    _, edge, count = np.unique(
        low * len(mesh.vertices) + high, return_inverse=True, return_counts=True
    )
    balance = np.bincount(edge, np.where(sides[:, 0] < sides[:, 1], 1, -1))
    many = (count > 2)[edge]
    lone = (count == 1)[edge]
    turned = ((count == 2) & (balance != 0))[edge]

    def of(which):
        hit = np.zeros(len(mesh.triangles), bool)
        hit[owner[which]] = True
        return hit

    return [
        _at(mesh, of(lone), "it is open: {} have an edge without a neighbour"),
        _at(mesh, of(many), "{} meet at edges of more than two faces"),
        _at(mesh, of(turned), "{} do not face the same way as a neighbour"),
    ]


def _pieces(mesh):
    part = np.arange(len(mesh.vertices))
    one, two = mesh.triangles[:, [0, 1, 0, 2]].reshape(-1, 2).T
    while True:
        # Each part is called by its least corner. Parts that share a triangle are joined.
        low, high = np.minimum(part[one], part[two]), np.maximum(part[one], part[two])
        apart = low < high
        if not apart.any():
            break
        one, two = one[apart], two[apart]
        np.minimum.at(part, high[apart], low[apart])
        while (part[part] < part).any():
            part = part[part]
    of = part[mesh.triangles[:, 0]]
    names, count = np.unique(of, return_counts=True)
    if len(names) == 1:
        return None
    return _at(
        mesh,
        of != names[np.argmax(count)],
        f"it is in {len(names)} pieces: {{}} are not of the first",
    )


def _inside_out(mesh):
    volume = volume_and_centroid(mesh.vertices, mesh.triangles)[0]
    return _at(mesh, np.full(len(mesh.triangles), volume <= 0), "it is turned inside out: {}")


def _through_itself(mesh):
    """Triangles that cross others, and neighbours that lie folded on one another."""
    tree = box_tree(mesh.vertices, mesh.triangles)
    one, two = np.array(tree.overlap(tree), int).reshape(-1, 2).T
    one, two = one[one < two], two[one < two]
    first, second = mesh.triangles[one], mesh.triangles[two]
    hit = np.zeros(len(mesh.triangles), bool)
    for a, b in ((first, second), (second, first)):
        for i in range(3):
            tail, head = a[:, i], a[:, (i + 1) % 3]
            # An edge that ends at a corner of the other triangle may meet it there.
            apart = ~((b == tail[:, None]) | (b == head[:, None])).any(axis=1)
            at = np.flatnonzero(apart)
            at = at[_pierces(mesh.vertices, tail[at], head[at], b[at])]
            hit[one[at]] = hit[two[at]] = True
    normals = np.cross(
        *(mesh.vertices[mesh.triangles[:, i]] - mesh.vertices[mesh.triangles[:, 0]] for i in (1, 2))
    )
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    one, two = _neighbours(mesh)
    folded = np.einsum("ij,ij->i", normals[one], normals[two]) < -1 + 1e-9
    hit[one[folded]] = hit[two[folded]] = True
    return _at(mesh, hit, "it passes through itself: {}")


def _neighbours(mesh):
    """The two triangles at each edge of a closed surface."""
    sides = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    sides.sort(axis=1)
    order = np.lexsort(sides.T)
    return order[::2] // 3, order[1::2] // 3


def _pierces(vertices, tail, head, triangle):
    """Whether each segment crosses the inside of its triangle."""
    origin, along = vertices[tail], vertices[head] - vertices[tail]
    a, b, c = (vertices[triangle[:, i]] for i in range(3))
    u, v = b - a, c - a
    p = np.cross(along, v)
    det = np.einsum("ij,ij->i", u, p)
    scale = np.linalg.norm(along, axis=1) * np.linalg.norm(np.cross(u, v), axis=1)
    steep = np.abs(det) > 1e-9 * scale
    det = np.where(steep, det, 1)
    s = origin - a
    q = np.cross(s, u)
    x = np.einsum("ij,ij->i", s, p) / det
    y = np.einsum("ij,ij->i", along, q) / det
    t = np.einsum("ij,ij->i", v, q) / det
    return steep & (np.minimum.reduce([x, y, 1 - x - y, t, 1 - t]) > 1e-9)


def is_hollow(mesh, hull):
    """Whether a triangle's middle lies below the hull of the whole by more than a hair."""
    depth = depth_below(hull, mesh.vertices[mesh.triangles].mean(axis=1))
    return bool(depth.max() > HOLLOW * np.ptp(mesh.vertices, axis=0).max())
