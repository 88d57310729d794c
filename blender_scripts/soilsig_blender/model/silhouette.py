"""The silhouette of a grain in an image: threshold, the largest patch, its outline and hull.

Lengths are pixels, x to the right and y up, the corner of the first pixel at the origin: an array
of grey values is held row by row from below, as Blender gives it.
"""

from dataclasses import dataclass

import numpy as np

from ..common.errors import BedError
from .descriptors import outline as convex_outline

# Standard deviation of the blur before the threshold, as a share of the image's height.
_BLUR = 0.004
# A patch of less than this share of the image is no grain.
_LEAST_SHARE = 0.005
# Corners of the hull are left out while that costs no more than this share of its area.
_COARSEST = 2e-3


@dataclass(frozen=True)
class Silhouette:
    """One grain in an image."""

    mask: np.ndarray  # (H, W) bool
    outline: np.ndarray  # (N, 2) corners, counter-clockwise
    hull: np.ndarray  # (M, 2) a convex polygon of few corners
    threshold: float
    cut_off: bool  # whether it reaches the image's edge

    @property
    def solidity(self):
        """Area of the outline over that of its hull."""
        return float(self.mask.sum() / area(self.hull))


def trace(grey, threshold=None, leave_out_below=0) -> Silhouette:
    """The largest bright patch of an image, without holes.

    `leave_out_below` rows at the lower edge, the microscope's legend, are ignored. Without a
    threshold Otsu's is taken (IEEE Trans. Syst. Man Cybern. 9, 62, 1979).
    """
    seen = grey[leave_out_below:]
    if seen.shape[0] < 16 or seen.shape[1] < 16:
        raise BedError("scene", "less than 16 pixels of the image are left", "lower the legend")
    smooth = blurred(seen, _BLUR * grey.shape[0])
    level = otsu(smooth) if threshold is None else threshold
    patch = _largest(smooth > level)
    if patch.mean() < _LEAST_SHARE:
        raise BedError(
            "scene",
            f"no patch of the image is brighter than {level:.3f} and larger than "
            f"{_LEAST_SHARE:.1%} of it",
            "lower the threshold, or crop the image to the grain",
        )
    mask = np.zeros(grey.shape, bool)
    mask[leave_out_below:] = _without_holes(patch)
    edge = mask[leave_out_below]
    cut_off = bool(edge.any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())
    corners = edge_of(mask)
    return Silhouette(mask, corners, _coarse(convex_outline(corners)), float(level), cut_off)


def otsu(grey):
    """The level that parts the grey values into the two most compact classes."""
    counts, edges = np.histogram(grey, 256)
    middle = (edges[:-1] + edges[1:]) / 2
    below = np.cumsum(counts)
    above = below[-1] - below
    sums = np.cumsum(counts * middle)
    with np.errstate(divide="ignore", invalid="ignore"):
        between = below * above * (sums / below - (sums[-1] - sums) / above) ** 2
    return float(edges[1:][np.nanargmax(np.where((below > 0) & (above > 0), between, np.nan))])


def area(corners):
    x, y = corners.T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)


def overlap(mask, corners):
    """Area shared by a mask and a convex polygon (counter-clockwise) over that of either: IoU."""
    filled = _filled(mask.shape, corners)
    return float((filled & mask).sum() / (filled | mask).sum())


def _filled(shape, corners):
    """The pixels whose middles are within a convex polygon."""
    y, x = np.mgrid[: shape[0], : shape[1]] + 0.5
    inside = np.ones(shape, bool)
    for (ax, ay), (bx, by) in zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist()):
        inside &= (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0
    return inside


def blurred(grey, deviation):
    reach = max(1, round(3 * deviation))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(deviation, 1e-9)) ** 2)
    weights /= weights.sum()
    for axis in (0, 1):
        padding = [(reach, reach) if a == axis else (0, 0) for a in (0, 1)]
        padded = np.pad(grey, padding, mode="edge")
        length = grey.shape[axis]
        grey = sum(
            w * np.take(padded, np.arange(i, i + length), axis=axis) for i, w in enumerate(weights)
        )
    return grey


def _largest(bright):
    """The largest patch of pixels that touch by their sides."""
    label = _patches(bright)
    counts = np.bincount(label.ravel())
    counts[0] = 0
    return label == np.argmax(counts) if counts.any() else np.zeros_like(bright)


def _without_holes(patch):
    """The patch and what it encloses."""
    around = _patches(np.pad(~patch, 1, constant_values=True))
    return (around != around[0, 0])[1:-1, 1:-1]


def _patches(bright):
    """A number from 1 for each patch, 0 elsewhere: runs of rows that touch are one patch."""
    steps = np.diff(np.pad(bright, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, start = np.nonzero(steps == 1)
    end = np.nonzero(steps == -1)[1]
    root = list(range(len(row)))

    def find(i):
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        return i

    first = np.searchsorted(row, np.arange(bright.shape[0] + 1)).tolist()
    start, end = start.tolist(), end.tolist()
    for y in range(1, bright.shape[0]):
        i, j = first[y - 1], first[y]
        while i < first[y] and j < first[y + 1]:
            if start[i] < end[j] and start[j] < end[i]:
                a, b = find(i), find(j)
                root[max(a, b)] = min(a, b)
            if end[i] < end[j]:
                i += 1
            else:
                j += 1
    label = np.zeros(bright.shape, int)
    for run, y in enumerate(row.tolist()):
        label[y, start[run] : end[run]] = find(run) + 1
    return label


def edge_of(mask):
    """The outer edge of a patch, from corner to corner of its pixels, counter-clockwise."""
    padded = np.pad(mask, 1)
    here = padded[1:-1, 1:-1]
    following = {}
    # Each side of a pixel on the edge, with the patch on its left.
    for beside, tail, head in (
        (padded[:-2, 1:-1], (0, 0), (1, 0)),
        (padded[1:-1, 2:], (1, 0), (1, 1)),
        (padded[2:, 1:-1], (1, 1), (0, 1)),
        (padded[1:-1, :-2], (0, 1), (0, 0)),
    ):
        for y, x in np.argwhere(here & ~beside).tolist():
            at = (x + tail[0], y + tail[1])
            following.setdefault(at, []).append((x + head[0], y + head[1]))
    start = min(following)
    corners, at, before = [start], start, None
    while True:
        choices = following[at]
        if before is not None and len(choices) > 1:
            # Two pixels touch by a corner: turn left, so as to stay on this one.
            along = (at[0] - before[0], at[1] - before[1])
            choices = sorted(
                choices, key=lambda c: along[1] * (c[0] - at[0]) - along[0] * (c[1] - at[1])
            )
        before, at = at, choices[0]
        following[before] = [c for c in following[before] if c != at]
        if at == start:
            break
        corners.append(at)
    corners = np.array(corners, float)
    ahead, behind = np.roll(corners, -1, axis=0) - corners, corners - np.roll(corners, 1, axis=0)
    return corners[ahead[:, 0] * behind[:, 1] != ahead[:, 1] * behind[:, 0]]


def _coarse(corners):
    """A convex polygon with its least corners left out, one by one."""
    limit = _COARSEST * area(corners)
    while len(corners) > 5:
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        u, v = corners - before, after - before
        lost = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2
        least = int(np.argmin(lost))
        if lost[least] > limit:
            break
        corners = np.delete(corners, least, axis=0)
    return corners


def bar_length(grey, legend_rows):
    """Length of the scale bar: the longest bright run in a row of the legend, pixels."""
    if legend_rows < 1:
        raise BedError(
            "scene", "the legend has no height", "say how many pixels at the lower edge it takes"
        )
    legend = grey[:legend_rows]
    bright = np.pad(legend > (legend.min() + legend.max()) / 2, ((0, 0), (1, 1)))
    steps = np.diff(bright.astype(np.int8), axis=1)
    runs = np.nonzero(steps == -1)[1] - np.nonzero(steps == 1)[1]
    if not len(runs) or np.ptp(legend) < 0.1:
        raise BedError("scene", "there is no bar in the legend", "measure it, and type it in")
    return float(runs.max())
