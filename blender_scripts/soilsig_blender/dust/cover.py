"""How much of a grain its fines cover, measured by lines that meet the true solids.

The fines of a smaller count are the first of those of a larger count. So the earliest fine that
each line meets gives the shares for every count at once.
"""

from dataclasses import dataclass

import numpy as np

from ..common.directions import GOLDEN_ANGLE, cosine_and_sine, fibonacci
from ..common.neighbours import near
from .bodies import Bodies
from .seats import frames

# Directions from which the dusty grain is seen, and points on the grain itself. These points give
# the share of its surface to a standard error of .016.
_DIRECTIONS = 64
_POINTS = 1000
# The number of the fine that a line meets which meets none: after all others.
_NEVER = np.iinfo(int).max


@dataclass(frozen=True)
class Cover:
    """Which fine comes first, for lines and points spread evenly over a grain."""

    on_line: np.ndarray  # (N,) of a line: the earliest fine that it meets in front of the grain
    meets_grain: np.ndarray  # (N,) whether the line meets the grain
    on_point: np.ndarray  # (M,) of a point of the grain: the earliest fine above it

    def silhouette(self, count):
        """Share of the silhouette seen from afar, over all directions, that is the first fines."""
        fine = self.on_line < count
        return float(fine.sum() / (fine | self.meets_grain).sum())

    def silhouette_by(self, kinds, number):
        """The share of each of so many kinds in the silhouette, by the kind of every fine.

        A line that meets several fines counts for the first of them.
        """
        fine = self.on_line[self.on_line < len(kinds)]
        met = (self.on_line < len(kinds)) | self.meets_grain
        return np.bincount(kinds[fine], minlength=number) / met.sum()

    def surface(self, count):
        """Share of the grain's surface whose outward normals meet the first fines."""
        return float((self.on_point < count).mean())

    def count_for(self, silhouette):
        """The fewest fines whose share of the silhouette is at least this, or None."""
        if silhouette <= 0:
            return 0
        order = np.argsort(self.on_line, kind="stable")
        earliest = self.on_line[order]
        fine = np.arange(1, len(order) + 1)
        seen = self.meets_grain.sum() + np.cumsum(~self.meets_grain[order])
        enough = np.flatnonzero((earliest < _NEVER) & (fine >= silhouette * seen))
        return int(earliest[enough[0]]) + 1 if len(enough) else None


def measure(grain, fines, dust, lines=32) -> Cover:
    """The cover of a grain about its centroid by its fines.

    There are `lines` parallel lines from each side. About three in five meet the dusty grain. 32
    lines give the share of the silhouette to a standard error of .011, 128 lines to half of that.
    """
    if not len(dust):
        return Cover(np.array([_NEVER]), np.array([True]), np.array([_NEVER]))
    shapes = Bodies([body for fine in fines for body in fine.bodies])
    first = np.cumsum([0] + [len(fine.bodies) for fine in fines])
    placed = shapes.placed(first[dust.kind] + dust.body, dust.rotation, dust.position)
    return Cover(*_from_afar(grain, shapes, placed, lines), _above_surface(grain, shapes, placed))


def _from_afar(grain, shapes, placed, lines):
    """Of each line the earliest fine in front of the grain, and whether it meets the grain."""
    turn = frames(fibonacci(_DIRECTIONS), np.zeros(_DIRECTIONS))
    outer = shapes.outer[placed.shape]
    reach = max(
        np.linalg.norm(grain.outermost, axis=1).max(),
        (np.linalg.norm(placed.centre, axis=1) + outer).max(),
    )
    # Parallel lines on a spiral that fills the disc evenly. Each direction has it turned.
    side, number = np.divmod(np.arange(_DIRECTIONS * lines), lines)
    away = reach * np.sqrt((number + 0.5) / lines)
    angle = GOLDEN_ANGLE * (number + lines * side)
    flat = np.column_stack([away * part for part in cosine_and_sine(angle)])
    origins, directions = (turn[side, :, :2] @ flat[:, :, None])[..., 0], -turn[side, :, 2]

    grain_at = _grain_at(grain, origins, directions)

    # Only fines near a line, seen along its direction, can meet it: they are neighbours on a plane.
    # The planes of all directions are stacked.
    level = 4 * shapes.outer.max() * np.arange(_DIRECTIONS)
    seen = np.empty((_DIRECTIONS, len(placed), 3))
    seen[..., :2], seen[..., 2] = placed.centre @ turn[:, :, :2], level[:, None]
    line, fine = near(np.column_stack([flat, level[side]]), seen.reshape(-1, 3), shapes.outer.max())
    away = flat[line] - seen.reshape(-1, 3)[fine, :2]
    fine %= len(placed)
    depth = (placed.centre[fine] * directions[line]).sum(axis=1) - outer[fine]
    kept = ((away**2).sum(axis=1) < outer[fine] ** 2) & (depth < grain_at[line])
    line, fine = line[kept], fine[kept]
    enter, leave = shapes.crossings(origins[line], directions[line], placed[fine])
    front = (enter < leave) & (enter < grain_at[line])
    return _earliest(len(origins), line[front], fine[front]), np.isfinite(grain_at)


def _grain_at(grain, origins, directions):
    """How far along each line it first meets the grain; infinite if it does not."""
    if not grain.is_convex:
        return grain.first_hits(origins, directions)
    core = Bodies([grain])
    enter, leave = core.crossings(origins, directions, core.at_origin(len(origins)))
    return np.where(enter < leave, enter, np.inf)


def _above_surface(grain, shapes, placed):
    """Of each point on the grain the earliest fine that its outward normal meets."""
    points, normals = _points(grain, _POINTS)
    outer = shapes.outer[placed.shape]
    if grain.is_convex:
        heights = (placed.centre @ grain.normals.T - grain.offsets).max(axis=1)
        again = np.full(len(points), np.inf)
    else:
        heights = grain.distances(placed.centre)
        # Over a hollow the normal may meet the grain once more: what lies behind is not above.
        start = points + 1e-3 * outer.min() * normals
        again = grain.first_hits(start, normals)
    point, fine = near(points, placed.centre, (heights + outer).max())
    between = placed.centre[fine] - points[point]
    along = np.einsum("ij,ij->i", between, normals[point])
    squared = np.einsum("ij,ij->i", between, between) - along**2
    kept = (squared < outer[fine] ** 2) & (along > -outer[fine])
    point, fine = point[kept], fine[kept]
    enter, leave = shapes.crossings(points[point], normals[point], placed[fine])
    above = (enter < leave) & (leave > 0) & (enter < again[point])
    return _earliest(_POINTS, point[above], fine[above])


def _earliest(count, line, fine):
    earliest = np.full(count, _NEVER)
    np.minimum.at(earliest, line, fine)
    return earliest


def _points(body, count):
    """Points even over the surface of a body, with its normals there."""
    a, b, c = body.vertices[body.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    at = np.searchsorted(np.cumsum(areas), (np.arange(count) + 0.5) / count * areas.sum())
    at = np.minimum(at, len(areas) - 1)
    # Multiples of powers of an irrational number fill the square evenly.
    u, v = (np.arange(count) * np.array([[0.7548776662466927], [0.5698402909980532]])) % 1
    u, v = np.where(u + v > 1, 1 - u, u)[:, None], np.where(u + v > 1, 1 - v, v)[:, None]
    points = a[at] + u * (b - a)[at] + v * (c - a)[at]
    return points, normals[at] / areas[at, None]
