"""A closed body of triangles that need not be convex: hollows, notches and overhangs included.

It has the properties of a `Polyhedron` that modelling and export ask for. Where a polyhedron
answers by its planes, it answers by Blender's tree of boxes around its triangles.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..common.directions import fibonacci
from .blender_meshes import box_tree, hull_volume
from .convex_hull import depth_below, hull_of
from .polyhedron import Polyhedron, heights, intersect, volume_and_centroid

# Rays that tell inside from outside, in directions along which meshes have no edges. The majority
# counts: a ray through an edge may miss both of its triangles.
_RAYS = ((0.3126, 0.2157, 0.9251), (-0.8214, 0.4637, 0.3321), (0.1893, -0.9402, 0.2834))
# The envelope has its facets across so many directions; the outermost corners are taken in more.
_FACETS = 96
_DIRECTIONS = 600
# Facets of an envelope stand off the body by up to twice this share of its extent.
_APART = 1e-4
# A ray starts again so far behind a triangle that it met, as a share of the body's extent.
_STEP = 1e-6
# A line from the nearest place on the surface is upright on its triangle to this cosine.
_UPRIGHT = 0.99


@dataclass(frozen=True)
class HollowBody:
    """Triangles that close a body and face outward."""

    vertices: np.ndarray  # (V, 3)
    triangles: np.ndarray  # (T, 3) vertex indices, counter-clockwise seen from outside

    is_convex = False  # it need not be

    @classmethod
    def of(cls, vertices, triangles):
        used, triangles = np.unique(triangles, return_inverse=True)
        return cls(np.asarray(vertices, float)[used], triangles.reshape(-1, 3))

    @property
    def facets(self):
        return self.triangles.tolist()

    @cached_property
    def outermost(self):
        """The corners furthest out in some hundred directions: those of the hull, nearly."""
        furthest = [np.argmax(heights(self.vertices, d)) for d in fibonacci(_DIRECTIONS)]
        return self.vertices[np.unique(furthest)]

    @cached_property
    def convexity(self):
        """Its volume over that of its hull."""
        return float(self.volume_and_centroid[0] / hull_volume(self.vertices))

    @cached_property
    def envelope(self) -> Polyhedron:
        """A convex body of few facets that holds the whole body, each nearly touching it."""
        return self._around(fibonacci(_FACETS))

    @cached_property
    def tight_envelope(self) -> Polyhedron:
        """The same with the facets of the hull, where the body has few corners on it."""
        furthest = [np.argmax(heights(self.vertices, d)) for d in fibonacci(_FACETS)]
        return self._around(hull_of(self.vertices[furthest]).normals)

    def _around(self, normals):
        middle = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2
        reach = np.array([heights(self.vertices - middle, normal).max() for normal in normals])
        # No more than three of the planes may meet in a point.
        reach *= 1 + _APART * (1 + (np.arange(len(reach)) * 0.618034) % 1)
        return intersect(normals, reach).moved(np.eye(3), middle)

    @cached_property
    def volume_and_centroid(self):
        return volume_and_centroid(self.vertices, self.triangles)

    @cached_property
    def normals(self):
        """Of the triangles, unit."""
        crosses = self._crosses
        return crosses / np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)[:, None]

    @cached_property
    def facet_areas_and_centroids(self):
        areas = np.linalg.norm(self._crosses, axis=1) / 2
        return areas, self.vertices[self.triangles].mean(axis=1)

    @cached_property
    def _crosses(self):
        a, b, c = self.vertices[self.triangles].transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    @cached_property
    def tree(self):
        return box_tree(self.vertices, self.triangles)

    def scaled(self, factors):
        """Scaled along the axes by `factors` (one number, or three)."""
        factors = np.broadcast_to(np.asarray(factors, float), 3)
        return HollowBody(self.vertices * factors, self.triangles)

    def moved(self, rotation, translation):
        """Turned by `rotation` (3x3), then shifted."""
        return HollowBody(self.vertices @ rotation.T + translation, self.triangles)

    def distances(self, points, most=np.inf):
        """From points to the surface; infinite beyond `most`."""
        limit = min(most, 4 * float(np.ptp(self.vertices, axis=0).sum()) + 1e6)
        found = (self.tree.find_nearest(point, limit)[3] for point in points.tolist())
        return np.array([np.inf if away is None else away for away in found])

    def gaps(self, points, reach):
        """From points to the surface, negative inside; outside infinite beyond `reach`."""
        around = self.envelope
        within = (points @ around.normals.T - around.offsets).max(axis=1, initial=-np.inf) < 0
        gaps = np.empty(len(points))
        gaps[~within] = self.distances(points[~within], reach)
        at = np.flatnonzero(within)
        if not len(at):
            return gaps
        # Where the nearest place is within a triangle, its normal tells the side.
        nearest = [self.tree.find_nearest(point) for point in points[at].tolist()]
        place, _, triangle, gaps[at] = zip(*nearest)
        away = points[at] - np.array(place)
        along = np.einsum("ij,ij->i", away, self.normals[list(triangle)])
        inside = along < 0
        unsure = np.flatnonzero(np.abs(along) < _UPRIGHT * gaps[at])
        inside[unsure] = self._encloses(points[at[unsure]])
        gaps[at[inside]] *= -1
        return gaps

    def first_hits(self, origins, directions):
        """How far along each line it first meets the surface; infinite if it does not."""
        found = (
            self.tree.ray_cast(origin, along)[3]
            for origin, along in zip(origins.tolist(), directions.tolist())
        )
        return np.array([np.inf if away is None else away for away in found])

    def contains(self, points):
        """Whether points are inside."""
        inside = np.zeros(len(points), bool)
        within = depth_below(self.envelope, points) > 0
        inside[within] = self._encloses(points[within])
        return inside

    def _encloses(self, points):
        """The same for points within the envelope."""
        inside = []
        for point in points.tolist():
            one, two = (self._odd(point, ray) for ray in _RAYS[:2])
            inside.append(one if one == two else self._odd(point, _RAYS[2]))
        return np.array(inside, bool)

    def _odd(self, point, along):
        """Whether a ray from a point meets an odd number of triangles."""
        count, (x, y, z), (u, v, w) = 0, point, along
        while (away := self.tree.ray_cast((x, y, z), along)[3]) is not None:
            count, away = count + 1, away + self._step
            x, y, z = x + away * u, y + away * v, z + away * w
        return count % 2 == 1

    @cached_property
    def _step(self):
        return _STEP * float(np.ptp(self.vertices, axis=0).max())

    def points_on_edges(self, spacing):
        """The corners, and points on the edges no further apart than `spacing`."""
        sides = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        tail, head = self.vertices[np.unique(sides, axis=0)].transpose(1, 0, 2)
        parts = np.ceil(np.linalg.norm(head - tail, axis=1) / spacing).astype(int)
        edge = np.repeat(np.arange(len(parts)), np.maximum(parts - 1, 0))
        number = np.arange(len(edge)) - np.searchsorted(edge, edge) + 1
        share = (number / parts[edge])[:, None]
        return np.vstack([self.vertices, tail[edge] + share * (head - tail)[edge]])
