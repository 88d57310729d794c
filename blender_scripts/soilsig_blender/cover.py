"""How much of a grain its fines cover, measured by lines that meet the true solids.

The fines of a smaller count are the first of those of a larger one. So of every line it is enough
to know the earliest fine that it meets, and the shares are known for every count at once.
"""

from dataclasses import dataclass

import numpy as np

from .solids import Shapes

# Lines through the dusty grain (some three in five meet it), and points on the grain.
_LINES = 4000
_POINTS = 2000
# The lines that meet no fine meet it after all others.
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


def measure(grain, fines, dust) -> Cover:
    """The cover of a grain about its centroid by its fines."""
    shapes = Shapes([body for fine in fines for body in fine.bodies])
    first = np.cumsum([0] + [len(fine.bodies) for fine in fines])
    placed = shapes.placed(first[dust.kind] + dust.body, dust.rotation, dust.position)
    reach = np.linalg.norm(grain.vertices, axis=1).max()
    outer = np.linalg.norm(placed.centre, axis=1) + shapes.outer[placed.shape]
    origins, directions = _lines(_LINES, max(reach, outer.max(initial=0)))
    core = Shapes([grain])
    line, _, enter, _ = core.met(
        origins, directions, core.placed(np.zeros(1, int), np.eye(3)[None], np.zeros((1, 3)))
    )
    grain_at = np.full(_LINES, np.inf)
    grain_at[line] = enter
    line, fine, enter, _ = shapes.met(origins, directions, placed)
    front = enter < grain_at[line]
    on_line = _earliest(_LINES, line[front], fine[front])

    points, normals = _points(grain, _POINTS)
    point, fine, _, leave = shapes.met(points, normals, placed)
    above = leave > 0
    return Cover(on_line, np.isfinite(grain_at), _earliest(_POINTS, point[above], fine[above]))


def _earliest(count, line, fine):
    earliest = np.full(count, _NEVER)
    np.minimum.at(earliest, line, fine)
    return earliest


def _lines(count, radius):
    """Lines that meet a sphere about the origin, even in direction and place."""
    height, turn, away, angle = _even(count, 4)
    height, turn = 2 * height - 1, 2 * np.pi * turn
    ring = np.sqrt(1 - height**2)
    cosine, sine = np.cos(turn), np.sin(turn)
    directions = np.column_stack([ring * cosine, ring * sine, height])
    side = np.column_stack([-sine, cosine, np.zeros(count)])
    up = np.cross(directions, side)
    away, angle = radius * np.sqrt(away), 2 * np.pi * angle
    return side * (away * np.cos(angle))[:, None] + up * (away * np.sin(angle))[:, None], directions


def _points(body, count):
    """Points even over the surface of a body, with its normals there."""
    choice, u, v = _even(count, 3)
    a, b, c = body.vertices[body.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    at = np.searchsorted(np.cumsum(areas), choice * areas.sum(), side="right")
    at = np.minimum(at, len(areas) - 1)
    u, v = np.where(u + v > 1, 1 - u, u)[:, None], np.where(u + v > 1, 1 - v, v)[:, None]
    points = a[at] + u * (b - a)[at] + v * (c - a)[at]
    return points, normals[at] / areas[at, None]


def _even(count, dimensions):
    """A sequence that fills the unit cube evenly: multiples of powers of an irrational number."""
    ratio = 2.0
    for _ in range(60):
        ratio = (1 + ratio) ** (1 / (dimensions + 1))
    steps = ratio ** -np.arange(1.0, dimensions + 1)
    return (0.5 + np.arange(1, count + 1) * steps[:, None]) % 1
