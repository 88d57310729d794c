"""Silhouettes of bodies that need not be convex.

The triangles tell which pixels have a middle that the body covers. Between a pixel that it covers
and one beside it that it does not, rays find the outline itself.
"""

import numpy as np

from ..common.neighbours import ranges
from .descriptors import outline as convex_outline
from .silhouette import area, edge_of

# Pixels along the longer side of a view. The resolution of `descriptors` is two of them.
_PIXELS = 100
# The outline is found to this power of a half of a pixel.
_HALVINGS = 7
# So many triangles at a time are compared with the pixels around them.
_BATCH = 2048


class Outline:
    """The outline of a body seen along an axis; `view` has the two directions across it as rows."""

    def __init__(self, body, view):
        flat = body.outermost @ view.T
        low, extent = flat.min(axis=0), np.ptp(flat, axis=0)
        side = extent.max() / _PIXELS
        along = np.cross(*view)
        back = 2 * np.linalg.norm(body.outermost, axis=1).max()

        def covers(pixels):
            origins = (low + side * pixels) @ view - back * along
            return np.isfinite(body.first_hits(origins, np.broadcast_to(along, origins.shape)))

        shape = np.ceil(extent / side).astype(int)[::-1]
        facing = body.normals @ along < 0
        mask = pixels_within((body.vertices @ view.T - low)[body.triangles[facing]] / side, shape)
        tail = _unit_steps(edge_of(mask))
        head = np.roll(tail, -1, axis=0)
        left = np.column_stack([tail[:, 1] - head[:, 1], head[:, 0] - tail[:, 0]])
        within, beyond = (tail + head + left) / 2, (tail + head - left) / 2
        for _ in range(_HALVINGS):
            middle = (within + beyond) / 2
            covered = covers(middle)[:, None]
            within, beyond = np.where(covered, middle, within), np.where(covered, beyond, middle)
        self.corners = side * (within + np.roll(within, -1, axis=0)) / 2
        self._inside = side * (np.argwhere(mask)[:, ::-1] + 0.5)
        self._side = side

    @property
    def convexity(self):
        """Area over that of the convex hull."""
        return float(area(self.corners) / area(convex_outline(self.corners)))

    @property
    def inscribed_radius(self):
        """Of the largest circle within it: about a third of the pixels, then closer and closer."""
        centre, radius = self._widest(self._inside[::3])
        for reach in (2, 0.7, 0.25, 0.1):
            around = np.linspace(-reach, reach, 7) * self._side
            x, y = np.meshgrid(around, around)
            near, wider = self._widest(centre + np.column_stack([x.ravel(), y.ravel()]))
            if wider > radius:
                centre, radius = near, wider
        return float(radius)

    def _widest(self, places):
        # Some of the corners show which places may be the best.
        most = _least_squares(places, self.corners[::8])
        least = _least_squares(places[[np.argmax(most)]], self.corners)
        places = places[most >= least]
        away = _least_squares(places, self.corners)
        best = int(np.argmax(away))
        return places[best], np.sqrt(away[best])


def _least_squares(places, corners):
    """The squared distance from each place to the nearest corner."""
    across, up = (places[:, None, axis] - corners[:, axis] for axis in (0, 1))
    return (across * across + up * up).min(axis=1)


def pixels_within(triangles, shape):
    """Which pixels have their middle within one of some triangles, given in pixels."""
    mask = np.zeros(shape, bool)
    # The middles of pixels within the box around each triangle.
    first = np.ceil(triangles.min(axis=1) - 0.5).astype(int)
    last = np.floor(triangles.max(axis=1) - 0.5).astype(int)
    size = np.maximum(last - first + 1, 0)
    count = size.prod(axis=1)
    for at in range(0, len(count), _BATCH):
        some = slice(at, at + _BATCH)
        of = np.repeat(np.arange(len(count))[some], count[some])
        number = ranges(np.zeros_like(count[some]), count[some])
        x = first[of, 0] + number % size[of, 0]
        y = first[of, 1] + number // size[of, 0]
        corners = triangles[of].transpose(1, 0, 2) - np.column_stack([x, y])[None] - 0.5
        sides = [
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] for a, b in zip(corners, np.roll(corners, -1, 0))
        ]
        within = np.min(sides, axis=0) * np.max(sides, axis=0) >= 0
        mask[y[within], x[within]] = True
    return mask


def _unit_steps(corners):
    """The outline from one corner of a pixel to the next."""
    ahead = np.roll(corners, -1, axis=0) - corners
    count = np.abs(ahead).sum(axis=1).astype(int)
    number = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    step = np.repeat(ahead / count[:, None], count, axis=0)
    return np.repeat(corners, count, axis=0) + number[:, None] * step
