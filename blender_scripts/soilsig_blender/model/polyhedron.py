"""Convex polyhedra as intersections of half-spaces.

Being convex they are closed, face outward and cannot intersect themselves, and whether two of
them touch is decided by their facet planes alone.
"""

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np


@dataclass(frozen=True)
class Polyhedron:
    """Facet i lies on the plane normals[i] . x = offsets[i], its inside where that is less."""

    normals: np.ndarray  # (F, 3), unit, outward
    offsets: np.ndarray  # (F,)
    vertices: np.ndarray  # (V, 3)
    facets: tuple  # F index loops, counter-clockwise seen from outside
    edges: np.ndarray  # (E, 3): the two facets that meet and one vertex of the edge

    is_convex = True

    @property
    def convexity(self):
        """Its volume over that of its hull."""
        return 1.0

    @property
    def outermost(self):
        """The corners of the hull."""
        return self.vertices

    @property
    def envelope(self):
        """A convex body that holds the whole body."""
        return self

    @cached_property
    def triangles(self):
        """Every facet as a fan: (T, 3) vertex indices."""
        return np.array([(loop[0], b, c) for loop in self.facets for b, c in pairwise(loop[1:])])

    @cached_property
    def facet_areas_and_centroids(self):
        a, b, c = self.vertices[self.triangles].transpose(1, 0, 2)
        facet = np.repeat(np.arange(len(self.facets)), [len(loop) - 2 for loop in self.facets])
        fan = 0.5 * np.einsum("ij,ij->i", np.cross(b - a, c - a), self.normals[facet])
        areas = np.bincount(facet, fan)
        thirds = fan[:, None] * (a + b + c) / 3
        moments = np.column_stack([np.bincount(facet, thirds[:, axis]) for axis in range(3)])
        first = self.vertices[[loop[0] for loop in self.facets]]
        flat = areas <= 0
        return areas, np.where(flat[:, None], first, moments / np.where(flat, 1, areas)[:, None])

    @cached_property
    def volume_and_centroid(self):
        return volume_and_centroid(self.vertices, self.triangles)

    def scaled(self, factors):
        """Scaled along the axes by `factors` (one number, or three)."""
        factors = np.broadcast_to(np.asarray(factors, float), 3)
        normals = self.normals / factors
        lengths = np.linalg.norm(normals, axis=1)
        return Polyhedron(
            normals / lengths[:, None],
            self.offsets / lengths,
            self.vertices * factors,
            self.facets,
            self.edges,
        )

    def moved(self, rotation, translation):
        """Turned by `rotation` (3x3), then shifted."""
        normals = self.normals @ rotation.T
        return Polyhedron(
            normals,
            self.offsets + heights(normals, translation),
            self.vertices @ rotation.T + translation,
            self.facets,
            self.edges,
        )


def heights(points, direction):
    """Scalar products with one direction.

    The rounding of `points @ direction` depends on the place of its arrays in memory in some builds
    of numpy.
    """
    return np.einsum("ij,j->i", points, direction)


def volume_and_centroid(vertices, triangles):
    """Of any closed surface of triangles; the volume is positive if it faces outward."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    sixths = np.einsum("ij,ij->i", a, np.cross(b, c))
    return sixths.sum() / 6, np.einsum("i,ij->j", sixths, a + b + c) / (4 * sixths.sum())


def intersect(normals, offsets):
    """The polyhedron of all x with normals . x <= offsets (all offsets positive, bounded).

    Planes are cut off one by one. A vertex is known by the three planes that meet in it, so the
    topology is exact whatever the rounding of its coordinates. Planes that cut nothing off, and
    those whose facet later cuts remove, are left out.
    """
    box = 8 * offsets.max()
    normals = np.vstack([np.eye(3), -np.eye(3), normals])
    offsets = np.concatenate([np.full(6, box), offsets])
    keys = [(x, y, z) for x in (0, 3) for y in (1, 4) for z in (2, 5)]
    corners = dict(zip(keys, _meeting(normals, offsets, keys)))
    ends = _edge_ends(keys)
    for plane in range(6, len(normals)):
        outside = np.array(list(corners.values())) @ normals[plane] > offsets[plane]
        if not outside.any():
            continue
        removed = sorted(key for key, out in zip(corners, outside) if out)
        for key in removed:
            del corners[key]
            for pair in _pairs(key):
                ends[pair].remove(key)
        # An edge that has lost one of its ends is cut by the plane.
        cut = [pair for key in removed for pair in _pairs(key) if len(ends[pair]) == 1]
        keys = [(*pair, plane) for pair in cut]
        for key, corner in zip(keys, _meeting(normals, offsets, keys)):
            corners[key] = corner
            for pair in _pairs(key):
                ends[pair].append(key)
    return _assemble(normals, offsets, corners)


def _meeting(normals, offsets, keys):
    """Where three planes each meet."""
    which = np.array(keys).reshape(-1, 3)
    return np.linalg.solve(normals[which], offsets[which][..., None])[..., 0]


def _pairs(key):
    p, q, r = key
    return (p, q), (p, r), (q, r)


def _edge_ends(keys):
    ends = defaultdict(list)
    for key in keys:
        for pair in _pairs(key):
            ends[pair].append(key)
    return ends


def _assemble(normals, offsets, corners):
    keys = sorted(corners)
    if min(keys)[0] < 6:
        raise ValueError("the planes do not bound a body")
    index = {key: i for i, key in enumerate(keys)}
    vertices = np.array([corners[key] for key in keys])
    pairs, ends = zip(*sorted(_edge_ends(keys).items()))
    left, right = np.array(pairs).T
    tail, head = np.array([[index[key] for key in both] for both in ends]).T
    along = np.cross(normals[left], normals[right])
    back = np.einsum("ij,ij->i", along, vertices[head] - vertices[tail]) < 0
    tail, head = np.where(back, head, tail), np.where(back, tail, head)
    following = defaultdict(dict)  # facet -> vertex -> next vertex
    for p, q, a, b in np.column_stack([left, right, tail, head]).tolist():
        following[p][a] = b
        following[q][b] = a
    used = sorted(following)
    facets = []
    for p in used:
        loop = [min(following[p])]
        while (after := following[p][loop[-1]]) != loop[0]:
            loop.append(after)
        facets.append(tuple(loop))
    edges = np.column_stack([*np.searchsorted(used, [left, right]), tail])
    return Polyhedron(normals[used], offsets[used], vertices, tuple(facets), edges)
