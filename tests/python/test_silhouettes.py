"""Silhouettes traced out of images whose outlines are known, and bodies made from them."""

import os
import sys
import unittest

import numpy as np
from soilsig_blender.common.errors import BedError
from soilsig_blender.common.randomness import stream
from soilsig_blender.model import body_check, convex_hull, silhouette, silhouette_body
from soilsig_blender.model.descriptors import outline
from soilsig_blender.model.shapes import SHAPES

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scripts"))
import sem_image

GREY = sem_image.drawn()[::-1]
Y, X = np.mgrid[: sem_image.HEIGHT, : sem_image.WIDTH] + 0.5
TRUE = sem_image.within(X, Y, sem_image.OUTLINE)


def share(one, two):
    return (one & two).sum() / (one | two).sum()


def disc(shape, x, y, radius):
    v, u = np.mgrid[: shape[0], : shape[1]] + 0.5
    return np.hypot(u - x, v - y) < radius


class Tracing(unittest.TestCase):
    def test_the_outline_that_was_drawn_is_traced(self):
        traced = silhouette.trace(GREY, None, sem_image.LEGEND)
        self.assertGreater(share(traced.mask, TRUE), 0.985)
        self.assertFalse(traced.cut_off)
        # The outline is that of the mask, corner by corner.
        self.assertEqual(silhouette.area(traced.outline), traced.mask.sum())
        inside = sem_image.within(X, Y, traced.outline)
        np.testing.assert_array_equal(inside, traced.mask)
        self.assertLess(traced.solidity, 0.995)

    def test_the_bar_is_as_long_as_it_was_drawn(self):
        bar = silhouette.bar_length(GREY, sem_image.LEGEND)
        self.assertEqual(bar, sem_image.BAR_UM / sem_image.UM_PER_PIXEL)
        with self.assertRaisesRegex(BedError, "legend has no height"):
            silhouette.bar_length(GREY, 0)
        with self.assertRaisesRegex(BedError, "no bar"):
            silhouette.bar_length(np.full((50, 50), 0.1), 10)

    def test_the_largest_patch_is_taken_without_its_holes(self):
        shape = (200, 300)
        image = 0.8 * (disc(shape, 150, 100, 60) & ~disc(shape, 150, 100, 20))
        image += 0.8 * disc(shape, 40, 40, 25)
        traced = silhouette.trace(image)
        self.assertGreater(share(traced.mask, disc(shape, 150, 100, 60)), 0.97)

    def test_a_grain_at_the_edge_is_told(self):
        self.assertTrue(silhouette.trace(0.8 * disc((200, 300), 20, 100, 60)).cut_off)

    def test_an_image_without_a_grain_is_refused(self):
        with self.assertRaisesRegex(BedError, "no patch of the image"):
            silhouette.trace(0.5 * disc((200, 300), 150, 100, 60), 0.9)
        with self.assertRaisesRegex(BedError, "less than 16 pixels"):
            silhouette.trace(GREY, None, len(GREY) - 3)


class Modelling(unittest.TestCase):
    def test_the_body_has_the_silhouette_of_the_outline(self):
        traced = silhouette.trace(GREY, None, sem_image.LEGEND)
        middle = (traced.hull.min(axis=0) + traced.hull.max(axis=0)) / 2
        for seed in range(8):
            name = ("angular", "worn")[seed % 2]
            body, told = silhouette_body.model(
                traced, 0.8, 0.8, SHAPES[name], stream(seed, "silhouette")
            )
            body_check.check(body, name)
            self.assertGreater(len(body.facets), 20)
            # Measured here against what was drawn, pixel by pixel.
            corners = outline(body.vertices[:, :2]) / 0.8 + middle
            shown = sem_image.within(X, Y, corners)
            self.assertGreaterEqual(share(shown, TRUE), silhouette_body.LEAST_OVERLAP)
            self.assertAlmostEqual(share(shown, traced.mask), told, 3)
            self.assertAlmostEqual(
                convex_hull.hull_of(body.vertices).volume_and_centroid[0]
                / body.volume_and_centroid[0],
                1,
                6,
            )

    def test_an_outline_too_hollow_for_a_convex_body_is_refused_with_what_is_reached(self):
        ring = disc((300, 300), 150, 150, 100) & ~disc((300, 300), 220, 150, 80)
        traced = silhouette.trace(0.8 * ring)
        self.assertLess(traced.solidity, 0.8)
        with self.assertRaisesRegex(BedError, r"fills 0\.\d+ of its convex hull"):
            silhouette_body.model(traced, 1.0, 0.8, SHAPES["angular"], stream(1, "s"))


if __name__ == "__main__":
    unittest.main()
