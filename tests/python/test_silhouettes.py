"""Silhouettes traced out of images whose outlines are known, and bodies made from them."""

import dataclasses
import os
import sys
import unittest

import numpy as np
from scan import scan
from soilsig_blender.common.errors import BedError
from soilsig_blender.common.randomness import stream
from soilsig_blender.model import (
    body_check,
    convex_hull,
    outline_body,
    silhouette,
    silhouette_body,
)
from soilsig_blender.model.descriptors import outline
from soilsig_blender.model.hollow_body import HollowBody
from soilsig_blender.model.hollow_outline import pixels_within
from soilsig_blender.model.mesh_faults import TriangleMesh, faults
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


class Hollows(unittest.TestCase):
    """Bodies of outlines with hollows, by images of bodies that are known."""

    def setUp(self):
        mesh = scan(5, 3)
        self.body = HollowBody(mesh.vertices, mesh.triangles)

    def seen(self, tilt, um_per_pixel=1.25):
        """Its image after the stage was tilted, with the middle anywhere."""
        c, s = np.cos(tilt), np.sin(tilt)
        turn = np.array([(1, 0, 0), (0, c, -s), (0, s, c)])
        at = (self.body.vertices @ turn.T)[:, :2] / um_per_pixel + (310 + 40 * tilt, 280)
        facing = self.body.normals @ turn[2] > 0
        mask = pixels_within(at[self.body.triangles[facing]], (560, 640))
        return outline_body.View(silhouette.trace(0.8 * mask), um_per_pixel, tilt)

    def made(self, *tilts, thickness=0.8):
        views = [self.seen(tilt) for tilt in tilts]
        return outline_body.model(views, thickness, SHAPES["worn"], stream(1, "silhouette"))

    def test_an_outline_that_no_convex_body_has_is_followed(self):
        bitten = disc((300, 300), 150, 150, 100) & ~disc((300, 300), 250, 170, 50)
        traced = silhouette.trace(0.8 * bitten)
        for seed in range(3):
            body, overlaps = outline_body.model(
                [outline_body.View(traced, 0.8, 0.0)], 0.8, SHAPES["angular"], stream(seed, "s")
            )
            self.assertGreaterEqual(overlaps[0], 0.97)
            self.assertLess(body.convexity, 0.96)
            self.assertEqual(
                faults(TriangleMesh(body.vertices, body.triangles, np.arange(8192))), []
            )
            # Measured here against what was drawn, by rays at a part of the pixels.
            y, x = np.mgrid[:300:3, :300:3] + 0.5
            middle = (traced.hull.min(axis=0) + traced.hull.max(axis=0)) / 2
            at = np.column_stack([x.ravel(), y.ravel()]) - middle
            origins = np.column_stack([0.8 * at, np.full(len(at), 1e3)])
            down = np.broadcast_to((0.0, 0.0, -1.0), origins.shape)
            shown = np.isfinite(body.first_hits(origins, down)).reshape(x.shape)
            self.assertGreaterEqual(share(shown, traced.mask[::3, ::3]), 0.96)

    def test_a_tilted_image_tells_the_height_and_its_outline_is_followed_too(self):
        volume = self.body.volume_and_centroid[0]
        for tilt in (np.pi / 2, np.pi / 4, np.pi / 6):
            made, overlaps = self.made(0.0, tilt)
            self.assertGreaterEqual(min(overlaps), 0.97)
            # A body of two outlines is the largest that has them.
            self.assertLess(abs(made.volume_and_centroid[0] / volume - 1), 0.2, tilt)
            again, _ = self.made(0.0, tilt, thickness=0.3)
            np.testing.assert_array_equal(again.vertices, made.vertices)
        thin = np.ptp(self.made(0.0, thickness=0.3)[0].vertices[:, 2])
        self.assertLess(thin, 0.5 * np.ptp(self.body.vertices[:, 2]))

    def test_images_that_do_not_fit_each_other_are_refused(self):
        other = dataclasses.replace(self.seen(0.5), um_per_pixel=1.5)
        with self.assertRaisesRegex(BedError, "do not fit: .* um long in one"):
            outline_body.model([self.seen(0.0), other], 0.8, SHAPES["worn"], stream(1, "s"))
        ring = disc((300, 300), 150, 150, 100) & ~disc((300, 300), 190, 150, 80)
        traced = silhouette.trace(0.8 * ring)
        with self.assertRaisesRegex(BedError, "not seen from its middle"):
            outline_body.model(
                [outline_body.View(traced, 1.0, 0.0)], 0.8, SHAPES["worn"], stream(1, "s")
            )


if __name__ == "__main__":
    unittest.main()
