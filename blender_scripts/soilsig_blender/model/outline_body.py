"""A body that shows the outlines of images with their hollows, from one side or from several.

The body is star-shaped: along each direction from its middle it ends where an outline or a fracture
does. Seen from the first side it is inflated to an ellipsoid's roundness, and what lies outside of
an outline of another side is taken away. Only the part of an outline that is seen from its middle
can be followed. The overlap of every silhouette with its image is measured pixel by pixel.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..common.errors import BedError
from ..common.sphere import sphere
from .hollow_body import HollowBody
from .hollow_outline import pixels_within
from .shapes import fractures
from .silhouette import Silhouette

# Least overlap (intersection over union) of the body's silhouettes with the images, and that at
# which fractures are no longer made shallower.
LEAST_OVERLAP = 0.9
_ENOUGH = 0.97
# 8 x 4^halvings triangles.
_HALVINGS = 5
# Directions within an image in which the reach of the outline is found, to half a pixel.
_TURNS = 1440
# Fractures cut off up to this share of what the body reaches, and half of it as often.
_CUT = 0.2
_ROUNDS = 6
# Fractures that face the rim of the first outline more than this (z of the normal) are left out.
_STEEP = 0.35
_MORE = 6
# Steps along a direction in which a relief is looked for.
_PARTS = 200
# Two images of one grain have the same breadth along the axis of the tilt, to this share.
_FIT = 0.05
# Heights that are tried where a tilted image tells it, as shares of the breadth.
_HEIGHTS = np.arange(0.3, 1.61, 0.1)
_AS_GOOD = 0.02


@dataclass(frozen=True)
class View:
    """An image of the grain after the stage was tilted about the image's x axis."""

    silhouette: Silhouette
    um_per_pixel: float
    tilt: float  # radians


def model(views, thickness, shape, rng, shading=None, depth=0.0):
    """A body, micrometres, about the middle of the first outline, and its overlap with each image.

    The first view is not tilted. Without others `thickness` is the height as a share of the
    outline's breadth. With its `Shading` the upper side has a relief in place of fractures, so many
    times as deep as slopes tell; negative for a dish.
    """
    directions, triangles = sphere(_HALVINGS)
    seen = [_Seen(view, directions) for view in views]
    for other in seen[1:]:
        if abs(other.breadth / seen[0].breadth - 1) > _FIT:
            raise BedError(
                "scene",
                f"the images do not fit: along the axis of the tilt the grain is "
                f"{seen[0].breadth:.4g} um long in one and {other.breadth:.4g} um in the other",
                "give both the same scale, and tilt about the horizontal axis of the images",
            )
    within = np.min([one.reach for one in seen], axis=0)

    def body(reach):
        return HollowBody(directions * reach[:, None], triangles)

    def overlaps(reach):
        return [one.overlap(body(reach)) for one in seen]

    def inflated(share):
        upright = directions[:, 2] / (share * seen[0].least_breadth / 2)
        return np.minimum(within, 1 / np.hypot(1 / seen[0].reach, upright))

    if len(seen) > 1:
        # Outlines bound the height from above only: the least is taken that shows them well.
        tried = [(min(overlaps(inflated(share))), share) for share in _HEIGHTS]
        best = max(overlap for overlap, _ in tried)
        thickness = next(share for overlap, share in tried if overlap > best - _AS_GOOD)
    whole = inflated(thickness)
    fans, _ = fractures(replace(shape, fractures=shape.fractures + _MORE), rng)
    fans = fans[np.abs(fans[:, 2]) > _STEEP]
    if shading:
        half = thickness * seen[0].least_breadth / 2
        upper = directions[:, 2] > 0
        whole[upper] = seen[0].relief(shading, depth, half, directions[upper], within[upper])
        fans = fans[fans[:, 2] < 0]
    deeper = rng.random(len(fans))
    for fraction in _CUT / 2 ** np.arange(_ROUNDS):
        along = directions @ fans.T
        planes = (along * whole[:, None]).max(axis=0) * (1 - fraction * deeper)
        with np.errstate(divide="ignore"):
            cut = np.where(along > 0, planes / along, np.inf).min(axis=1)
        if shading:
            cut = np.where(directions[:, 2] < 0, cut, np.inf)
        reach = np.minimum(whole, cut)
        reached = overlaps(reach)
        if min(reached) >= _ENOUGH:
            break
    if min(reached) < LEAST_OVERLAP:
        raise BedError(
            "scene",
            f"no body's silhouette overlaps the outline by {LEAST_OVERLAP} (IoU), this one does by "
            f"{min(reached):.3f}: parts of the outline are not seen from its middle, or the images "
            "are not of one grain",
            "trace a grain without bays that bend, and state the tilt with its sign",
        )
    return body(reach).moved(np.eye(3), seen[0].shift), reached


class _Seen:
    """A view of the body in directions from its middle."""

    def __init__(self, view, directions):
        self.view, self.mask = view, view.silhouette.mask
        y, x = np.nonzero(self.mask)
        low, high = x.min(), x.max() + 1
        # Along the tilt's axis the middles of all images are one place of the body.
        self.middle = np.array([(low + high) / 2, y.mean() + 0.5])
        self.breadth = (high - low) * view.um_per_pixel
        self.least_breadth = min(high - low, np.ptp(y) + 1) * view.um_per_pixel
        hull = view.silhouette.hull
        off = self.middle - (hull.min(axis=0) + hull.max(axis=0)) / 2
        self.shift = np.array([*(off * view.um_per_pixel), 0.0])
        c, s = np.cos(view.tilt), np.sin(view.tilt)
        self.turn = np.array([(1, 0, 0), (0, c, -s), (0, s, c)])
        turned = directions @ self.turn.T
        flat = np.hypot(turned[:, 0], turned[:, 1])
        across = self._rim(turned[:, 0], turned[:, 1])
        # How far along each direction the outline is reached.
        self.reach = across * view.um_per_pixel / np.maximum(flat, 1e-9)

    def _reaches(self, angles):
        """Pixels from the middle to where the outline is first left."""
        away = np.arange(0, np.hypot(*self.mask.shape), 0.5)
        x = self.middle[0] + np.cos(angles)[:, None] * away
        y = self.middle[1] + np.sin(angles)[:, None] * away
        rows, columns = self.mask.shape
        there = (x >= 0) & (y >= 0) & (x < columns) & (y < rows)
        x, y = np.where(there, x, 0).astype(int), np.where(there, y, 0).astype(int)
        left = ~(there & self.mask[y, x])
        left[:, -1] = True
        return away[np.argmax(left, axis=1)]

    def relief(self, shading, depth, half, directions, most):
        """How far the body reaches along upward directions to the shading's relief, um."""
        y, x = (axis + 0.5 for axis in np.mgrid[: self.mask.shape[0], : self.mask.shape[1]])
        x, y = x - self.middle[0], y - self.middle[1]
        scale = self.view.um_per_pixel
        share = np.hypot(x, y) / self._rim(x, y)
        heights = shading.heights(half / scale * np.sqrt(np.maximum(1 - share**2, 0)), depth)
        # Along each direction the surface is where the way first comes out of it.
        most = np.minimum(most, 2 * half / np.maximum(directions[:, 2], 1e-9))
        way = np.linspace(0, 1, _PARTS) * most[:, None] / scale
        x, y, z = (way * directions[:, axis, None] for axis in range(3))
        above = z - heights(x + self.middle[0], y + self.middle[1])
        above[:, 0] = np.minimum(above[:, 0], -1e-6)
        above[:, -1] = np.maximum(above[:, -1], 1e-6)
        at, first = np.arange(len(way)), np.argmax(above > 0, axis=1)
        low, high = above[at, first - 1], above[at, first]
        share = low / (low - high)
        found = way[at, first - 1] + share * (way[at, first] - way[at, first - 1])
        return np.maximum(found, 0.5) * scale

    def _rim(self, x, y):
        """Pixels from the middle to the outline towards places."""
        turns = np.linspace(-np.pi, np.pi, _TURNS + 1)
        return np.maximum(np.interp(np.arctan2(y, x), turns, self._reaches(turns)), 0.5)

    def overlap(self, body):
        corners = body.vertices @ self.turn.T
        facing = body.normals @ self.turn[2] > 0
        pixels = corners[:, :2] / self.view.um_per_pixel + self.middle
        shown = pixels_within(pixels[body.triangles[facing]], self.mask.shape)
        return float((shown & self.mask).sum() / (shown | self.mask).sum())
