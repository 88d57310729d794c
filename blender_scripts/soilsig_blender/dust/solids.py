"""A dusty grain as a union of convex solids: the grain itself and its fines."""

import numpy as np

from ..common.arrays import padded
from ..common.neighbours import near
from .hollow_core import HollowCore


def distances(points, centre):
    """From each point to the centre."""
    return np.linalg.norm(points - centre, axis=1)


class Solids:
    """Convex solids side by side, their arrays padded to one size by repetition."""

    def __init__(self, corners, normals, offsets, edges):
        self.corners = corners  # (N, V, 3)
        self.normals = normals  # (N, F, 3)
        self.offsets = offsets  # (N, F)
        self.edges = edges  # (N, E, 3) the numbers of the two facets that meet, and of a corner

    @classmethod
    def of(cls, bodies):
        return cls(
            padded([body.vertices for body in bodies]),
            padded([body.normals for body in bodies]),
            padded([body.offsets for body in bodies], ()),
            padded([body.edges for body in bodies]).astype(int),
        )

    def take(self, which):
        return Solids(
            self.corners[which], self.normals[which], self.offsets[which], self.edges[which]
        )

    def edges_of(self, i):
        """Normals (E, 3) of both facets at each edge of solid i, and a point (E, 3) of each edge.

        A single solid stands for every i.
        """
        i = min(i, len(self.corners) - 1)
        one, two, corner = self.edges[i].T
        return self.normals[i][one], self.normals[i][two], self.corners[i][corner]

    def moved(self, turn, shift):
        """Turned and shifted; one pose for all, or one for each."""
        back = np.swapaxes(turn, -1, -2)
        normals = self.normals @ back
        offsets = self.offsets + (normals @ shift[..., :, None])[..., 0]
        shift = shift[..., None, :]
        return Solids(
            self.corners @ back + shift,
            normals,
            offsets,
            self.edges,
        )


class DustySolids:
    """The solids of one dusty grain: the grain itself and its fines with their outer spheres."""

    def __init__(self, core, fines, centre, outer, radius, hollow=None):
        self.core = core  # of a hollow grain its envelope
        self.hollow = hollow  # a HollowCore, or None if the grain is convex
        self.fines = fines
        self.centre = centre  # (N, 3)
        self.outer = outer  # (N,)
        self.radius = radius  # of the dusty grain about its centre of mass

    @classmethod
    def of(cls, prototype):
        bodies = [body for fine in prototype.fines for body in fine.bodies]
        first = np.cumsum([0] + [len(fine.bodies) for fine in prototype.fines])
        dust = prototype.dust
        which = first[dust.kind] + dust.body
        centres = np.array([body.volume_and_centroid[1] for body in bodies]).reshape(-1, 3)
        radii = np.array([distances(b.vertices, c).max() for b, c in zip(bodies, centres)])
        grain = prototype.grain
        return cls(
            Solids.of([grain.envelope]),
            Solids.of(bodies).take(which).moved(dust.rotation, dust.position),
            (dust.rotation @ centres[which][..., None])[..., 0] + dust.position,
            radii[which],
            distances(prototype.outline, np.zeros(3)).max(),
            None if grain.is_convex else HollowCore(grain),
        )

    def facing(self, point, distance):
        """The grain with those of its fines that come within the distance of a point."""
        near = np.flatnonzero(distances(self.centre, point) < self.outer + distance)
        return DustySolids(
            self.core,
            self.fines.take(near),
            self.centre[near],
            self.outer[near],
            self.radius,
            self.hollow,
        )

    def contain(self, points):
        """Whether each point is inside the grain or one of its fines."""
        inside = (points @ self.core.normals[0].T <= self.core.offsets[0]).all(axis=1)
        if self.hollow:
            at = np.flatnonzero(inside)
            inside[at] = self.hollow.contains(points[at])
        outside = np.flatnonzero(~inside)
        point, fine = near(points[outside], self.centre, self.outer.max(initial=0))
        away = points[outside[point]] - self.centre[fine]
        kept = np.einsum("ij,ij->i", away, away) < self.outer[fine] ** 2
        point, fine = point[kept], fine[kept]
        heights = np.einsum("nfi,ni->nf", self.fines.normals[fine], points[outside[point]])
        within = (heights <= self.fines.offsets[fine]).all(axis=1)
        inside[outside[point[within]]] = True
        return inside

    def moved(self, turn, shift):
        return DustySolids(
            self.core.moved(turn, shift),
            self.fines.moved(turn, shift),
            self.centre @ turn.T + shift,
            self.outer,
            self.radius,
            self.hollow and self.hollow.moved(turn, shift),
        )
