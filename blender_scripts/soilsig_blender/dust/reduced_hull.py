"""The convex hull of a dusty grain for Bullet: few points, to a stated tolerance.

Bullet's time grows with the number of points, and most corners of the full hull are a micrometre
away from another corner of the same fine.
"""

import numpy as np

from ..common.directions import fibonacci
from ..common.neighbours import clumps, ranges

# The reach of the hull is compared in this many directions.
_DIRECTIONS = 1000
# Side of a clump of points as a share of the whole.
_CLUMP = 0.06
# Rounding of a reach, as a share of the whole.
_ROUNDING = 1e-9


def reduced_hull(points, tolerance):
    """Points whose hull reaches as far as that of all points in every direction, to the tolerance.

    The point whose lack would cost the most reach is taken first.
    """
    directions = fibonacci(_DIRECTIONS)
    extreme = _extreme(points, directions)
    candidates, extreme = np.unique(extreme, return_inverse=True)
    reach = points[candidates] @ directions.T
    full = reach.max(axis=0)
    missing = np.full(_DIRECTIONS, np.inf)
    kept = []
    while missing.max() > tolerance:
        kept.append(extreme[np.argmax(missing)])
        missing = np.minimum(missing, full - reach[kept[-1]])
    return points[candidates[sorted(kept)]]


def _extreme(points, directions):
    """The point furthest out in each direction.

    Only clumps of points that may hold it are searched.
    """
    size = np.ptp(points, axis=0).max()
    order, start = clumps(points, size * _CLUMP)
    points, end = points[order], np.append(start[1:], len(points))
    low, high = np.minimum.reduceat(points, start), np.maximum.reduceat(points, start)
    middle, radius = (low + high) / 2, np.linalg.norm(high - low, axis=1) / 2
    # The outermost point of each clump shows how far is reached at least.
    outward = np.lexsort((np.einsum("ij,ij->i", points, points), np.repeat(start, end - start)))
    least = (directions @ points[outward[end - 1]].T).max(axis=1) - _ROUNDING * size
    direction, clump = np.nonzero(directions @ middle.T + radius >= least[:, None])
    point = ranges(start[clump], end[clump])
    direction = np.repeat(direction, (end - start)[clump])
    heights = np.einsum("ij,ij->i", points[point], directions[direction])
    first = np.searchsorted(direction, np.arange(len(directions)))
    most = np.maximum.reduceat(heights, first)
    found = np.flatnonzero(heights == most[direction])[::-1]
    extreme = np.empty(len(directions), int)
    extreme[direction[found]] = order[point[found]]
    return extreme
