"""Points by the cell of a grid that they lie in."""

import numpy as np

# A table of all cells is faster than a search up to so many cells for each that is looked up.
_TABLED = 8


def near(points, others, reach):
    """Index pairs of points and others: all that are within reach of each other, and some more."""
    if not len(points) or not len(others):
        return np.empty((2, 0), int)
    low = np.minimum(points.min(axis=0), others.min(axis=0))
    mine, theirs = (((p - low) / reach).astype(int) + 1 for p in (points, others))
    size = np.maximum(mine.max(axis=0), theirs.max(axis=0)) + 2
    key = theirs @ _strides(size)
    order = np.argsort(key, kind="stable")
    # Three neighbouring cells along z have consecutive keys.
    columns = np.array([(x, y, 0) for x in (-1, 0, 1) for y in (-1, 0, 1)])
    middle = ((mine[:, None] + columns) @ _strides(size)).ravel()
    start, end = _between(key[order], middle - 1, middle + 1, int(size.prod()))
    return np.repeat(np.arange(len(points)), 9).repeat(end - start), order[ranges(start, end)]


def _between(keys, low, high, cells):
    """Where sorted keys, all below `cells`, begin to be at least `low` and to be above `high`."""
    if cells > _TABLED * len(low):
        return np.searchsorted(keys, low, side="left"), np.searchsorted(keys, high, side="right")
    below = np.concatenate([[0], np.cumsum(np.bincount(keys, minlength=cells))])
    return below[low], below[high + 1]


def clumps(points, side):
    """The order that groups points by cells of this side, and where each cell starts."""
    cell = ((points - points.min(axis=0)) / side).astype(int)
    key = cell @ _strides(cell.max(axis=0) + 1)
    order = np.argsort(key, kind="stable")
    return order, np.flatnonzero(np.diff(key[order], prepend=-1))


def ranges(start, end):
    """The integers from each start up to its end, one after another."""
    count = end - start
    first = np.repeat(start - (np.cumsum(count) - count), count)
    return first + np.arange(count.sum())


def _strides(size):
    return np.array([size[1] * size[2], size[2], 1])
