"""Where fines sit on a grain that need not be convex: on its hollows and in its notches too.

A seat is a point of the surface with a normal: that of its triangle where the triangle is large
enough to carry the fine, else the mean of the surface around. On rough ground the fine is lifted
along the normal until it only touches. A seat that lies too deep in a pit, or beside a wall without
room, is none.
"""

import numpy as np

from ..common.neighbours import near
from ..common.randomness import shuffled
from .bodies import turned

# Places are drawn so densely, in places for each cell, and thinned to this least distance: they
# are then as many as the lattice of a flat facet has.
_DENSITY = 6
_THINNED = 0.777
# So many of the places are thinned first, then twice as many at a time.
_FIRST = 256
# Radius around a seat whose mean normal is taken, as a share of the fine's diameter.
_AROUND = 0.3
# Most that a fine is lifted, as a share of its diameter.
_LIFT = 0.2
# Triangles smaller than the fines are looked up by a grid. The others are compared with every fine,
# so many pairs at a time.
_PAIRS = 2_000_000


class Ground:
    """The surface of a grain, asked by many fines at once."""

    def __init__(self, grain):
        self.corners = grain.vertices[grain.triangles]
        self.normals = grain.normals
        self.offsets = np.einsum("ij,ij->i", self.normals, self.corners[:, 0])
        self.centres = self.corners.mean(axis=1)
        self.radii = np.linalg.norm(self.corners - self.centres[:, None], axis=2).max(axis=1)
        self.areas = grain.facet_areas_and_centroids[0]

    def cells(self, side, diameter, least_area, rng):
        """Points even over the surface about `side` apart, and the normals of the seats there."""
        whole = self.areas.sum()
        count = int(np.ceil(_DENSITY * whole / (side**2 * np.sqrt(3) / 2)))
        at = np.cumsum(self.areas) / whole
        of = np.searchsorted(at, (np.arange(count) + rng.random(count)) / count)
        of = np.minimum(of, len(at) - 1)[shuffled(rng, count)]
        u, v = rng.random((2, count, 1))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        a, b, c = self.corners[of].transpose(1, 0, 2)
        points = a + u * (b - a) + v * (c - a)
        kept = _thinned(points, self.normals[of], _THINNED * side)
        points, of = points[kept], of[kept]
        normals = self.normals[of]
        rough = np.flatnonzero(self.areas[of] < least_area)
        if len(rough):
            normals[rough] = self._mean_normals(points[rough], of[rough], _AROUND * diameter)
        return points, normals

    def _mean_normals(self, points, of, radius):
        point, triangle = near(points, self.centres, radius)
        away = points[point] - self.centres[triangle]
        same_side = np.einsum("ij,ij->i", self.normals[of[point]], self.normals[triangle]) > 0
        kept = same_side & (np.einsum("ij,ij->i", away, away) < radius**2)
        mean = self.normals[of] * self.areas[of, None]
        weighted = self.normals * self.areas[:, None]
        for axis in range(3):
            mean[:, axis] += np.bincount(
                point[kept], weighted[triangle[kept], axis], minlength=len(points)
            )
        return mean / np.linalg.norm(mean, axis=1)[:, None]

    def lifted(self, seats, shape, shapes, diameter, touch):
        """Positions at which the fines only touch the grain, and whether each has room there."""
        most = _LIFT * diameter
        lift = np.zeros(len(seats))
        placed = shapes.placed(shape, seats.rotation, seats.position)
        for fine, _, _, needed in self._crossed(placed, shapes, seats.rotation[:, :, 2], touch):
            np.maximum.at(lift, fine, needed)
        room = lift <= most
        up = (np.where(room, lift, 0) + touch / 2)[:, None] * seats.rotation[:, :, 2]
        position = seats.position + up
        raised = np.flatnonzero(room)
        sunk = self.sunk(shapes.placed(shape, seats.rotation, position)[raised], shapes, touch)
        room[raised[sunk]] = False
        return position, room

    def sunk(self, placed, shapes, touch):
        """Whether each fine passes through the surface by more than `touch`.

        Fines that lie whole within the grain are not told: seats are on its surface.
        """
        found = np.zeros(len(placed), bool)
        for fine, *_ in self._crossed(placed, shapes, placed.rotation[:, :, 2], touch):
            found[fine] = True
        return found

    def _crossed(self, placed, shapes, up, touch):
        """Batches of fines with triangles that no plane of either keeps apart.

        Of each pair also the shift along `up` that would part them. Planes along an edge of each
        are not tried: a fine that only they would clear counts as crossed.
        """
        below = (placed.rotation[:, :, 2] * placed.position).sum(axis=1) + touch
        for fine, triangle in self._close(placed, shapes.outer[placed.shape]):
            # Most triangles lie below the base that the fine sits on.
            base = placed.rotation[:, :, 2][fine]
            middle = np.einsum("ij,ij->i", base, self.centres[triangle])
            kept = np.flatnonzero(middle + self.radii[triangle] > below[fine])
            fine, triangle = fine[kept], triangle[kept]
            highest = (self.corners[triangle] @ base[kept, :, None]).max(axis=(1, 2))
            kept = highest > below[fine]
            fine, triangle = fine[kept], triangle[kept]
            height = np.einsum("ij,ij->i", self.normals[triangle], placed.centre[fine])
            height -= self.offsets[triangle]
            near_plane = np.abs(height) < shapes.outer[placed.shape[fine]]
            fine, triangle = fine[near_plane], triangle[near_plane]
            for at in range(0, len(fine), 20_000):
                yield self._crossed_pairs(
                    placed, shapes, up, touch, fine[at : at + 20_000], triangle[at : at + 20_000]
                )

    def _crossed_pairs(self, placed, shapes, up, touch, fine, triangle):
        shape = placed.shape[fine]
        back = placed.rotation[fine].transpose(0, 2, 1)
        corners = (self.corners[triangle] - placed.position[fine][:, None]) @ (
            back.transpose(0, 2, 1)
        )
        # How far all of the triangle lies before each plane of the fine.
        before = (corners @ shapes.normals[shape].transpose(0, 2, 1)).min(axis=1)
        before -= shapes.offsets[shape]
        normal = turned(back, self.normals[triangle])
        level = np.einsum("ij,ij->i", normal, corners[:, 0])
        heights = turned(shapes.vertices[shape], normal)
        above, below = heights.min(axis=1) - level, level - heights.max(axis=1)
        apart = np.maximum(before.max(axis=1), np.maximum(above, below))
        kept = np.flatnonzero(apart < -touch)
        fine, triangle, before, above = fine[kept], triangle[kept], before[kept], above[kept]
        towards = turned(back[kept], up[fine])
        fall = -turned(shapes.normals[shape[kept]], towards)
        with np.errstate(divide="ignore", invalid="ignore"):
            by_fine = np.where(fall > 1e-6, -before / fall, np.inf).min(axis=1, initial=np.inf)
            rise = np.einsum("ij,ij->i", normal[kept], towards)
            by_triangle = np.where(rise > 1e-6, -above / rise, np.inf)
        return fine, triangle, apart[kept], np.minimum(by_fine, by_triangle)

    def _close(self, placed, outer):
        """Pairs of fines and triangles whose spheres meet, in batches."""
        if not len(placed):
            return
        wide = self.radii > 2 * outer.max()
        small, large = np.flatnonzero(~wide), np.flatnonzero(wide)
        if len(small):
            reach = outer.max() + self.radii[small].max()
            fine, triangle = near(placed.centre, self.centres[small], reach)
            yield self._meeting(placed, outer, fine, small[triangle])
        rows = max(1, _PAIRS // max(len(large), 1))
        for at in range(0, len(placed) if len(large) else 0, rows):
            count = min(rows, len(placed) - at)
            fine = np.repeat(np.arange(at, at + count), len(large))
            yield self._meeting(placed, outer, fine, np.tile(large, count))

    def _meeting(self, placed, outer, fine, triangle):
        away = placed.centre[fine] - self.centres[triangle]
        meet = np.einsum("ij,ij->i", away, away) < (outer[fine] + self.radii[triangle]) ** 2
        return fine[meet], triangle[meet]


def _thinned(points, normals, least):
    """The numbers of points that are `least` apart on one side of the body: the first come stay."""

    def close(some, others):
        i, j = near(points[some], points[others], least)
        away = points[some[i]] - points[others[j]]
        meet = np.einsum("ij,ij->i", away, away) < least**2
        i, j = i[meet], j[meet]
        meet = np.einsum("ij,ij->i", normals[some[i]], normals[others[j]]) > 0
        return i[meet], j[meet]

    kept, at = np.empty(0, int), 0
    # Few stay, and the first of them keep out most of those that come after.
    while at < len(points):
        some = np.arange(at, min(len(points), 2 * at + _FIRST))
        at += len(some)
        some = np.delete(some, close(some, kept)[0])
        kept = np.concatenate([kept, some[_first_come(*close(some, some), len(some))]])
    return kept


def _first_come(i, j, count):
    """Which of so many stay, given pairs that cannot both: the earlier of a pair comes first."""
    i, j = i[j < i], j[j < i]
    undecided, stay = np.ones((2, count), bool)
    # Each round decides those before which none that is undecided comes.
    while len(i):
        waits = np.zeros(count, bool)
        waits[i] = True
        falls = i[(undecided & ~waits)[j]]
        undecided &= waits
        undecided[falls] = stay[falls] = False
        left = undecided[i] & undecided[j]
        i, j = i[left], j[left]
    return stay
