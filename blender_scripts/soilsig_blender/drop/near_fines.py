"""Which fines of two grains are near the other grain and may come to touch it."""

import numpy as np

from ..dust.solids import distances


def near_fines(one, two, turn, shift, reach):
    """The fines of either grain that come within `reach` of a solid of the other, and a few more.

    The second grain is turned and shifted. Few planes are tried to separate fines: the facets of
    the other grain, and the plane across the line between the centres of two fines.
    """
    a = np.flatnonzero(distances(one.centre, shift) < one.outer + two.radius + reach)
    b = np.flatnonzero(distances(two.centre, -turn.T @ shift) < two.outer + one.radius + reach)
    near_one = _near_core(one, a, two.core, turn.T, -turn.T @ shift, reach)
    near_two = _near_core(two, b, one.core, turn, shift, reach)
    away = two.centre[b] @ turn.T + shift - one.centre[a][:, None]
    squared = np.einsum("ijk,ijk->ij", away, away)
    i, j = np.nonzero(squared < (one.outer[a][:, None] + two.outer[b] + reach) ** 2)
    across = (away[i, j] / np.sqrt(squared[i, j])[:, None])[:, :, None]
    theirs = (two.fines.corners[b[j]] @ (turn.T @ across)).min(axis=1)[:, 0]
    mine = (one.fines.corners[a[i]] @ across).max(axis=1)[:, 0]
    close = theirs + across[:, :, 0] @ shift - mine < reach
    near_one[i[close]] = near_two[j[close]] = True
    return a[near_one], b[near_two]


def _near_core(grain, which, core, turn, shift, reach):
    """Whether each of these fines of a grain comes near the other grain, by its facets."""
    normals, offsets = core.normals[0] @ turn, core.offsets[0] - core.normals[0] @ shift
    near = (grain.centre[which] @ normals.T - offsets).max(axis=1) < grain.outer[which] + reach
    heights = (grain.fines.corners[which[near]] @ normals.T).min(axis=1) - offsets
    near[near] = heights.max(axis=1) < reach
    return near
