"""A hollow grain in its place, and how near other solids come to its true surface."""

import numpy as np

from ..common.neighbours import clumps, near, ranges

# Edges are looked at in points that are no further apart than this share of the extent.
_SPACING = 0.01
# So many of the envelope's planes are asked first.
_FIRST = 8
# Points are taken together in clumps: the side of one, as a share of the extent.
_CLUMP = 0.05
# Distances are those of single precision: what they may be wrong by, as a share of the extent.
_ROUNDING = 1e-5
# The clumps that may be nearest are measured so many at a time.
_LOT = 16


class _EdgePoints:
    """Points on the corners and the edges of a body, in clumps with a sphere around each."""

    def __init__(self, body):
        extent = np.ptp(body.vertices, axis=0).max()
        points = body.points_on_edges(_SPACING * extent)
        order, self.start = clumps(points, _CLUMP * extent)
        self.points = points[order]
        self.end = np.append(self.start[1:], len(points))
        low = np.minimum.reduceat(self.points, self.start)
        high = np.maximum.reduceat(self.points, self.start)
        self.middle = (low + high) / 2
        away = self.points - np.repeat(self.middle, self.end - self.start, axis=0)
        squares = np.maximum.reduceat(np.einsum("ij,ij->i", away, away), self.start)
        self.radius = np.sqrt(squares) + _ROUNDING * extent

    def of(self, some):
        """The points of some of the clumps."""
        return self.points[ranges(self.start[some], self.end[some])]


class HollowCore:
    """The body in its own frame, with the pose that it has been given."""

    def __init__(self, body, turn=None, shift=None, on_edges=None):
        self.body = body
        self.turn = np.eye(3) if turn is None else turn
        self.shift = np.zeros(3) if shift is None else shift
        self._on_edges = on_edges or _EdgePoints(body)

    def moved(self, turn, shift):
        return HollowCore(self.body, turn @ self.turn, turn @ self.shift + shift, self._on_edges)

    def contains(self, points):
        return self.body.gaps((points - self.shift) @ self.turn, 0.0) < 0

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

    def gap_to_edges(self, other, reach):
        """The least gap to points on the edges of another core; infinite beyond `reach`.

        A clump is left out if its middle is so far from the surface that no point of it is nearer
        than the nearest found.
        """
        around, mine = self.body.envelope, other._on_edges
        middle = (mine.middle @ other.turn.T + (other.shift - self.shift)) @ self.turn
        # The plane that faces the other body most keeps nearly all of it away.
        facing = np.argmax(around.normals @ middle.mean(axis=0))
        height = middle @ around.normals[facing] - around.offsets[facing]
        some = np.flatnonzero(height - mine.radius < reach)
        beyond = middle[some] @ around.normals.T - around.offsets
        some = some[beyond.max(axis=1, initial=-np.inf) - mine.radius[some] < reach]
        if not len(some):
            return np.inf
        least = self.body.gaps(middle[some], reach + mine.radius[some].max()) - mine.radius[some]
        order = np.argsort(least, kind="stable")
        nearest = reach
        for at in range(0, len(order), _LOT):
            lot = order[at : at + _LOT]
            lot = lot[least[lot] < nearest]
            if not len(lot):
                break
            points = mine.of(some[lot]) @ other.turn.T + (other.shift - self.shift)
            nearest = min(nearest, float(self.body.gaps(points @ self.turn, nearest).min()))
        return nearest if nearest < reach else np.inf

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
        edges, wide = self._on_edges, self._on_edges.radius[:, None]
        inside = (edges.middle > low - wide) & (edges.middle < high + wide)
        points = edges.of(np.flatnonzero(inside.all(axis=1)))
        points = points[((points > low) & (points < high)).all(axis=1)]
        points = points @ self.turn.T + self.shift
        at, solid = near(points, centre, widest)
        away = points[at] - centre[solid]
        kept = np.einsum("ij,ij->i", away, away) < (outer[solid] + reach) ** 2
        at, solid = at[kept], solid[kept]
        heights = np.einsum("nfi,ni->nf", solids.normals[close][solid], points[at])
        heights -= solids.offsets[close][solid]
        return min(gap, float(heights.max(axis=1).min(initial=np.inf)))
