"""The convex hull of a dusty grain as Bullet gets it: few points, a stated tolerance.

Bullet's time goes with the number of points, and most corners of the full hull stand a micrometre
beside another corner of the same fine.
"""

import numpy as np

# The hull is measured by how far it reaches in this many directions.
_DIRECTIONS = 1000
_CHUNK = 250


def reduced_hull(points, tolerance):
    """Points whose hull reaches as far as that of all, to the tolerance, in every direction.

    The point that is missed most is taken first.
    """
    directions = _fibonacci(_DIRECTIONS)
    extreme = np.empty(_DIRECTIONS, int)
    for at in range(0, _DIRECTIONS, _CHUNK):
        extreme[at : at + _CHUNK] = np.argmax(directions[at : at + _CHUNK] @ points.T, axis=1)
    candidates, extreme = np.unique(extreme, return_inverse=True)
    reach = points[candidates] @ directions.T
    full = reach.max(axis=0)
    missing = np.full(_DIRECTIONS, np.inf)
    kept = []
    while missing.max() > tolerance:
        kept.append(extreme[np.argmax(missing)])
        missing = np.minimum(missing, full - reach[kept[-1]])
    return points[candidates[sorted(kept)]]


class Reach:
    """How far a convex hull reaches in many directions."""

    def __init__(self, points):
        self._directions = _fibonacci(_DIRECTIONS)
        self._reach = (points @ self._directions.T).max(axis=0)

    def away(self, points):
        """At least so far the points are outside the hull (negative inside)."""
        return (points @ self._directions.T - self._reach).max(axis=1, initial=-np.inf)


def _fibonacci(count):
    height = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    ring = np.sqrt(1 - height**2)
    return np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
