"""Relief of the side that an image shows, by its shading.

Slopes emit more secondary electrons, as 1 / cos of their tilt to the beam (Seiler, J. Appl. Phys.
54, R1, 1983). So brightness over that of level ground tells how steep a place is, but not to which
side it falls. Here it falls as the inflated outline does, outward, and then as the surface does
that was found (slopes integrated by least squares, as in Frankot and Chellappa, IEEE Trans. Pattern
Anal. Mach. Intell. 10, 439, 1988). Far from what slopes tell, the inflated outline is kept.
"""

from dataclasses import dataclass

import numpy as np

from .silhouette import blurred

# Blocks of pixels across the grain at least: the body has about as many corners across.
_BLOCKS = 80
# Standard deviation of the blur, in blocks.
_BLUR = 1.0
# So large a share of the grain is taken to be level or darker.
_LEVEL = 0.02
# Steeper than this (1 / cos of the tilt) the law fails and detectors saturate.
_STEEPEST = 3.0
# A grain whose brightness varies by less than this factor shows no relief. A ball's varies by 2.
_LEAST_CONTRAST = 1.1
# The pull towards the inflated outline, per block: it acts over 18 blocks.
_PULL = 0.003
_ROUNDS = 4
# The surface departs from the inflated outline by up to this share of its height.
_MOST = 0.5
# The equations are solved to this share, in so many steps at most.
_SOLVED = 1e-6
_STEPS = 300


@dataclass(frozen=True)
class Shading:
    """How steep the blocks of pixels within an outline are."""

    slope: np.ndarray  # (H, W) tangent of the tilt, zero outside
    within: np.ndarray  # (H, W) bool
    side: int  # pixels

    @classmethod
    def of(cls, grey, mask):
        """Of brightness in proportion to the signal; None if the grain is evenly bright."""
        across = max(np.ptp(axis) + 1 for axis in np.nonzero(mask))
        side = max(1, int(across) // _BLOCKS)
        share = _blocks(mask, side)
        within = share > 0.5
        # The ground around the grain does not darken its rim.
        light = blurred(_blocks(grey * mask, side), _BLUR) / np.maximum(blurred(share, _BLUR), 1e-9)
        dark, bright = np.quantile(light[within], (0.05, 0.95))
        if bright <= _LEAST_CONTRAST * dark:
            return None
        level = max(np.quantile(light[within], _LEVEL), 1e-9)
        steep = np.where(within, np.clip(light / level, 1.0, _STEEPEST), 1.0)
        return cls(np.sqrt(steep**2 - 1), within, side)

    def heights(self, dome, depth):
        """The surface as a function from places to heights, all in pixels.

        `dome` has the heights of the inflated outline, pixel by pixel. Slopes fall outward as its
        do. With a negative depth they fall inward from a level rim, as in a dish: both look the
        same. The size of `depth` is how many times as deep the relief is as slopes tell.
        """
        dome = _blocks(dome, self.side) / self.side
        rest = dome if depth >= 0 else np.full_like(dome, dome[self.within].mean())
        found = dome if depth >= 0 else -dome
        for _ in range(_ROUNDS):
            down, right = np.gradient(self._smooth(found))
            scale = self.slope / np.maximum(np.hypot(down, right), 1e-9)
            found = self._integrated(right * scale, down * scale, rest)
        most = _MOST * dome.max()
        found = np.maximum(rest + np.clip(abs(depth) * (found - rest), -most, most), 0)
        # Beyond the rim as at it, so that heights between blocks can be asked there.
        found = self.side * np.where(self.within, found, self._smooth(found))
        return lambda x, y: _between(found, x / self.side - 0.5, y / self.side - 0.5)

    def _smooth(self, values):
        """Blurred, without what is outside."""
        share = blurred(self.within.astype(float), _BLUR)
        return blurred(values * self.within, _BLUR) / np.maximum(share, 1e-9)

    def _integrated(self, right, down, rest):
        """Heights whose steps from block to block are nearest to those wanted: least squares."""
        beside = self.within[:, :-1] & self.within[:, 1:]
        below = self.within[:-1] & self.within[1:]

        def gathered(across, along):
            total = np.zeros_like(rest)
            total[:, 1:] += across
            total[:, :-1] -= across
            total[1:] += along
            total[:-1] -= along
            return total

        def pulled(z):
            steps = (z[:, 1:] - z[:, :-1]) * beside, (z[1:] - z[:-1]) * below
            return gathered(*steps) + _PULL * z * self.within

        wanted = gathered(
            (right[:, 1:] + right[:, :-1]) / 2 * beside, (down[1:] + down[:-1]) / 2 * below
        )
        # Conjugate gradients.
        z = rest * self.within
        left = wanted + _PULL * z - pulled(z)
        along, square = left, (left**2).sum()
        enough = _SOLVED * square
        for _ in range(_STEPS):
            if square <= enough:
                break
            ahead = pulled(along)
            step = square / (along * ahead).sum()
            z, left = z + step * along, left - step * ahead
            square, before = (left**2).sum(), square
            along = left + square / before * along
        return z


def _between(values, x, y):
    """Linear between values whose places are whole numbers."""
    rows, columns = values.shape
    x, y = np.clip(x, 0, columns - 1), np.clip(y, 0, rows - 1)
    i, j = np.minimum(x.astype(int), columns - 2), np.minimum(y.astype(int), rows - 2)
    u, v = x - i, y - j
    lower = (1 - u) * values[j, i] + u * values[j, i + 1]
    return (1 - v) * lower + v * ((1 - u) * values[j + 1, i] + u * values[j + 1, i + 1])


def _blocks(values, side):
    """Means of square blocks; what is left over at the far edges is padded with zeros."""
    values = np.pad(values.astype(float), [(0, -length % side) for length in values.shape])
    rows, columns = (length // side for length in values.shape)
    return values.reshape(rows, side, columns, side).mean(axis=(1, 3))
