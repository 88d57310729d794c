"""A body whose silhouette from above is a given outline, bounded by fracture facets.

Every side of the outline's hull is a steep facet; above and below them the fractures of a shape
(`shapes.fractures`) are laid tangent to the hull inflated to an ellipsoid's roundness. The
tilt of the steep facets cuts the corners of the outline. The loss is measured as IoU, and the tilt
is halved until the loss is small.
"""

from dataclasses import replace

import numpy as np

from ..common.errors import BedError
from .descriptors import outline as convex_outline
from .polyhedron import intersect
from .shapes import fractures
from .silhouette import Silhouette, area, overlap

# Least overlap (intersection over union) of the body's silhouette with the outline.
LEAST_OVERLAP = 0.9
# Most of that overlap that the tilt may cost.
_TILT_COST = 0.03
# Largest tilt of a steep facet (its tangent), and half of the height of these facets as a share of
# half of the thickness.
_TILT = 0.35
_RIM = 0.3
# Fractures steeper than this (z of the normal) are left to the facets along the outline.
_STEEP = 0.35
# Fractures beyond those of the shape that make up for these, and the share by which each may go
# deeper than the inflated hull.
_MORE = 6
_DEEPER = 0.1


def model(silhouette: Silhouette, um_per_pixel, thickness, shape, rng):
    """A body, micrometres, about the middle of the outline, and its overlap with it.

    `thickness` is its height as a share of the outline's breadth.
    """
    corners = silhouette.hull
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    normals, offsets = _sides(corners - middle)
    half = 0.5 * thickness * _breadth(corners)
    fans, _ = fractures(replace(shape, fractures=shape.fractures + _MORE), rng)
    fans = fans[np.abs(fans[:, 2]) > _STEEP]
    sign = np.where(rng.random(len(normals)) < 0.5, -1.0, 1.0)
    tilt = sign * _TILT * (0.3 + 0.7 * rng.random(len(normals)))
    inflated = np.hypot((fans[:, :2] @ (corners - middle).T).max(axis=1), half * fans[:, 2])
    inflated *= 1 - _DEEPER * rng.random(len(fans))
    # Fractures on one side alone would leave the other side open.
    fans = np.vstack([fans, [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]])
    inflated = np.append(inflated, [half, half])
    best = 0.0
    for _ in range(6):
        steep = np.column_stack([normals, tilt])
        # The hinge is where the outward end of the facet lies on the outline.
        reach = offsets - _RIM * half * np.abs(tilt)
        length = np.linalg.norm(steep, axis=1)
        body = intersect(
            np.vstack([steep / length[:, None], fans]), np.concatenate([reach / length, inflated])
        )
        shown = convex_outline(body.vertices[:, :2])
        grown = np.sqrt(area(corners) / area(shown))
        body, shown = body.scaled((grown, grown, 1)), shown * grown + middle
        reached = overlap(silhouette.mask, shown)
        cost = overlap(silhouette.mask, corners) - reached
        best = max(best, reached)
        if reached >= LEAST_OVERLAP and cost <= _TILT_COST:
            return body.scaled(um_per_pixel), reached
        tilt = tilt / 2
    raise BedError(
        "scene",
        f"no body's silhouette overlaps the outline by {LEAST_OVERLAP} (IoU), the best does by "
        f"{best:.3f}: the outline fills {silhouette.solidity:.2f} of its convex hull, and bodies "
        "are convex",
        "trace a grain without deep hollows, or set the threshold so that shadows belong to it",
    )


def _sides(corners):
    ahead = np.roll(corners, -1, axis=0) - corners
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    normals = np.column_stack([ahead[:, 1], -ahead[:, 0]])
    return normals, np.einsum("ij,ij->i", normals, corners)


def _breadth(corners):
    """The least caliper diameter of a convex polygon."""
    normals, offsets = _sides(corners)
    return float((offsets - (normals @ corners.T).min(axis=1)).min())
