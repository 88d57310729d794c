"""A hollow grain in its place, and how near other solids come to its true surface."""

from functools import cached_property

import numpy as np

from ..common.neighbours import near

# Edges are looked at in points that are no further apart than this share of the extent.
_SPACING = 0.01
# So many of the envelope's planes are asked first.
_FIRST = 8


class HollowCore:
    """The body in its own frame, with the pose that it has been given."""

    def __init__(self, body, turn=None, shift=None, points=None):
        self.body = body
        self.turn = np.eye(3) if turn is None else turn
        self.shift = np.zeros(3) if shift is None else shift
        if points is None:
            points = body.points_on_edges(_SPACING * np.ptp(body.vertices, axis=0).max())
        self._points = points

    def moved(self, turn, shift):
        return HollowCore(self.body, turn @ self.turn, turn @ self.shift + shift, self._points)

    @cached_property
    def points(self):
        """Points on the corners and the edges, in place."""
        return self._points @ self.turn.T + self.shift

    def contains(self, points):
        return self.body.contains((points - self.shift) @ self.turn)

    def gap_to_points(self, points, reach):
        """The least distance of points to the surface, negative inside; infinite beyond `reach`."""
        around = self.body.envelope
        # One plane towards the middle of the points keeps most of them away.
        along = self.turn.T @ (points.mean(axis=0) - self.shift)
        along /= max(np.linalg.norm(along), 1e-300)
        height = points @ (self.turn @ along)
        most = (around.vertices @ along).max() + self.shift @ self.turn @ along
        points = (points[height < most + reach] - self.shift) @ self.turn
        # The planes that face the points first: few are left for the others.
        order = np.argsort(-(around.normals @ along), kind="stable")
        for some in (order[:_FIRST], order[_FIRST:]):
            beyond = points @ around.normals[some].T - around.offsets[some]
            points = points[beyond.max(axis=1, initial=-np.inf) < reach]
        return float(self.body.gaps(np.unique(points, axis=0), reach).min(initial=np.inf))

    def gap_to_convex(self, solids, centre, outer, reach):
        """The least gap to some convex solids, each in a sphere about its centre."""
        if not len(centre):
            return np.inf
        around = self.body.envelope
        middle = (centre - self.shift) @ self.turn
        beyond = (middle @ around.normals.T - around.offsets).max(axis=1) - outer
        close = np.flatnonzero(beyond < reach)
        if not len(close):
            return np.inf
        gap = self.gap_to_points(solids.corners[close].reshape(-1, 3), reach)
        centre, outer, middle = centre[close], outer[close], middle[close]
        widest = outer.max() + reach
        low, high = middle.min(axis=0) - widest, middle.max(axis=0) + widest
        points = self._points[((self._points > low) & (self._points < high)).all(axis=1)]
        points = points @ self.turn.T + self.shift
        at, solid = near(points, centre, widest)
        away = points[at] - centre[solid]
        kept = np.einsum("ij,ij->i", away, away) < (outer[solid] + reach) ** 2
        at, solid = at[kept], solid[kept]
        heights = np.einsum("nfi,ni->nf", solids.normals[close][solid], points[at])
        heights -= solids.offsets[close][solid]
        return min(gap, float(heights.max(axis=1).min(initial=np.inf)))
