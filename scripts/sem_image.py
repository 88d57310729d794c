"""Draws an image like one of a scanning electron microscope: a broken grain, scale bar, noise.

python3 scripts/sem_image.py FILE.png

It draws the images of the documents and of the tests, so that a traced outline can be compared with
the drawn one. Needs numpy.
"""

import struct
import sys
import zlib

import numpy as np

# Width, height with the legend, height of the legend: pixels.
WIDTH, HEIGHT, LEGEND = 900, 720, 60
UM_PER_PIXEL = 0.8
BAR_UM = 200
# Outline of the grain, pixels from the lower left, counter-clockwise, with one shallow hollow.
OUTLINE = np.array(
    [
        (232, 205), (330, 150), (470, 138), (590, 170), (668, 262), (690, 380),
        (622, 478), (560, 474), (470, 548), (352, 560), (250, 498), (192, 372),
    ],
    float,
)  # fmt: skip


def drawn(seed=1):
    """Grey values from 0 to 1, row by row from above."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    y = HEIGHT - y  # upwards
    inside = within(x, y, OUTLINE)
    # Facets: each pixel belongs to the nearest of some points, each with a brightness of its own.
    seeds = rng.uniform((210, 150), (680, 550), (14, 2))
    away = (x[..., None] - seeds[:, 0]) ** 2 + (y[..., None] - seeds[:, 1]) ** 2
    facet = np.argmin(away, axis=2)
    slope = rng.normal(0, 2.5e-4, (len(seeds), 2))
    shade = rng.uniform(0.48, 0.78, len(seeds))[facet]
    shade += slope[facet, 0] * (x - seeds[facet, 0]) + slope[facet, 1] * (y - seeds[facet, 1])
    # Conchoidal ripples about the point of the blow; edges shine in a microscope.
    shade += 0.02 * np.sin(np.hypot(x - 240, y - 500) / 5)
    shade += 0.22 * np.exp(-edge_distance(x, y, OUTLINE) / 5)
    grey = np.where(inside, shade, 0.14 + 0.04 * (y / HEIGHT))
    grey += rng.normal(0, 0.05, grey.shape)
    legend = y < LEGEND
    grey[legend] = 0.04
    bar = BAR_UM / UM_PER_PIXEL
    grey[(y > 24) & (y < 32) & (x > 40) & (x < 40 + bar)] = 0.98
    for tick in (42, 38 + bar):
        grey[(y > 16) & (y < 40) & (np.abs(x - tick) < 2)] = 0.98
    return np.clip(grey, 0, 1)


def within(x, y, corners):
    """Whether points are inside a polygon: an odd number of its sides is to their right."""
    odd = np.zeros(np.shape(x), bool)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0)):
        spans = (ay > y) != (by > y)
        odd ^= spans & (x < (bx - ax) * (y - ay) / (by - ay if by != ay else 1) + ax)
    return odd


def edge_distance(x, y, corners):
    least = np.full(np.shape(x), np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        along = b - a
        t = np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / (along @ along), 0, 1)
        least = np.minimum(least, np.hypot(x - a[0] - t * along[0], y - a[1] - t * along[1]))
    return least


def write_png(path, grey):
    """Eight bits of grey, nothing more."""
    rows = (grey * 255).round().astype(np.uint8)
    raw = np.hstack([np.zeros((len(rows), 1), np.uint8), rows]).tobytes()

    def chunk(kind, content):
        return (
            struct.pack(">I", len(content))
            + kind
            + content
            + struct.pack(">I", zlib.crc32(kind + content))
        )

    header = struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 0, 0, 0, 0)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header))
        out.write(chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


if __name__ == "__main__":
    write_png(sys.argv[1], drawn())
