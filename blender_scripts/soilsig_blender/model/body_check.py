"""Is a modelled body closed, turned outward and free of self-intersection?"""

import numpy as np

from ..common.errors import BedError

# Rounding: a corner may stand this far before a facet's plane, as a share of the body's extent.
_ROUNDING = 1e-9


def check(body, name, rounding=_ROUNDING):
    """Raises `BedError` where the body is not a convex polyhedron that faces outward."""
    fault = (
        _not_finite(body)
        or _open(body)
        or _not_outward(body)
        or _not_convex(body, rounding)
        or _torn(body)
    )
    if fault:
        raise BedError(
            "internal", f"{name} is no sound body: {fault}", "model it with another seed"
        )


def _not_finite(body):
    for what, array in (("vertices", body.vertices), ("planes", body.normals)):
        if not np.isfinite(array).all():
            return f"its {what} are not all finite"
    return None


def _open(body):
    """Every edge must be run along once in each direction, by two facets."""
    sides = [(loop[i - 1], corner) for loop in body.facets for i, corner in enumerate(loop)]
    run = dict.fromkeys(sides)
    if len(run) < len(sides):
        return "two facets run along an edge in the same direction"
    for a, b in sides:
        if (b, a) not in run:
            return f"it is open at the edge from vertex {a} to {b}"
    return None


def _not_outward(body):
    volume = body.volume_and_centroid[0]
    if volume <= 0:
        return f"it is turned inside out, its volume is {volume:g} um3"
    areas = body.facet_areas_and_centroids[0]
    if areas.min() <= 0:
        return f"facet {int(np.argmin(areas))} faces inward or has no area"
    return None


def _not_convex(body, rounding):
    """With every corner behind every plane no facet can pass through another."""
    allowed = rounding * np.ptp(body.vertices, axis=0).max()
    before = (body.vertices @ body.normals.T - body.offsets).max(axis=0)
    worst = int(np.argmax(before))
    if before[worst] > allowed:
        return f"a corner stands {before[worst]:.3g} um before the plane of facet {worst}"
    for facet, loop in enumerate(body.facets):
        off = np.abs(body.vertices[list(loop)] @ body.normals[facet] - body.offsets[facet]).max()
        if off > allowed:
            return f"facet {facet} leaves its plane by {off:.3g} um"
    return None


def _torn(body):
    """Euler: V - E + F = 2 for one body without holes."""
    used = {corner for loop in body.facets for corner in loop}
    edges = sum(map(len, body.facets)) // 2
    if len(used) != len(body.vertices):
        return f"{len(body.vertices) - len(used)} vertices belong to no facet"
    euler = len(used) - edges + len(body.facets)
    return None if euler == 2 else f"V - E + F is {euler}, not 2: it is not one whole body"
