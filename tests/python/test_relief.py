"""Reliefs by shading, of images of known bodies as a microscope's law makes them."""

import unittest

import numpy as np
from soilsig_blender.common.randomness import stream
from soilsig_blender.model import outline_body, silhouette
from soilsig_blender.model.hollow_body import HollowBody
from soilsig_blender.model.mesh_faults import TriangleMesh, faults
from soilsig_blender.model.relief import Shading
from soilsig_blender.model.shapes import SHAPES, model

PIXELS, AROUND = 160, 15
# Brightness of level ground, and of a pixel as the law has it up to white: 1 / cos of the tilt.
LEVEL = 0.25


def image(body, noise=0.0):
    """Grey values of a body seen from above, its true heights in um, and um per pixel."""
    low, extent = body.vertices[:, :2].min(axis=0), np.ptp(body.vertices[:, :2], axis=0)
    scale = extent.max() / PIXELS
    columns, rows = np.ceil(extent / scale).astype(int) + 2 * AROUND
    y, x = np.mgrid[:rows, :columns] + 0.5
    places = low + scale * (np.column_stack([x.ravel(), y.ravel()]) - AROUND)
    grey, height = np.full(x.size, 0.04), np.full(x.size, np.nan)
    for i, (u, v) in enumerate(places.tolist()):
        place, normal, _, away = body.tree.ray_cast((u, v, 1e4), (0, 0, -1))
        if away is not None:
            grey[i], height[i] = min(LEVEL / max(abs(normal[2]), 1e-9), 1), place[2]
    grey = grey * (1 + noise * np.random.default_rng(1).standard_normal(x.size))
    return grey.reshape(x.shape), height.reshape(x.shape), scale


def dish(rise):
    """A body over an ellipse whose upper side rises by so much from its middle to its rim."""
    angle = np.linspace(0, 2 * np.pi, 97)[:-1]
    share = np.linspace(0, 1, 41)[1:]
    upper = [(r, 90 + rise * (r**2 - 0.5)) for r in share]
    rings = [*upper, *((r, -100 * np.sqrt(1 - r**2)) for r in share[::-1])]
    around = np.column_stack([250 * np.cos(angle), 200 * np.sin(angle)])
    points = [np.column_stack([r * around, np.full(96, z)]) for r, z in rings]
    points = np.vstack([[(0, 0, 90 - rise / 2)], *points, [(0, 0, -100)]])
    i, j = np.arange(96), (np.arange(96) + 1) % 96
    last = 1 + 96 * (len(rings) - 1)
    faces = [np.column_stack([0 * i, 1 + i, 1 + j])]
    for one in range(1, last, 96):
        faces.append(np.column_stack([one + i, one + 96 + i, one + 96 + j]))
        faces.append(np.column_stack([one + i, one + 96 + j, one + j]))
    faces.append(np.column_stack([last + i, 0 * i + len(points) - 1, last + j]))
    return HollowBody(points, np.vstack(faces))


def heights(body, traced, scale):
    """Of the body's upper side at every pixel of the outline, um."""
    y, x = np.nonzero(traced.mask)
    middle = (traced.hull.min(axis=0) + traced.hull.max(axis=0)) / 2
    at = (np.column_stack([x, y]) + 0.5 - middle) * scale
    origins = np.column_stack([at, np.full(len(at), 1e4)])
    found = np.full(traced.mask.shape, np.nan)
    found[y, x] = 1e4 - body.first_hits(origins, np.broadcast_to((0.0, 0, -1), origins.shape))
    return found


def alike(one, two, where):
    where = where & np.isfinite(one) & np.isfinite(two)
    return np.corrcoef(one[where], two[where])[0, 1]


class Relief(unittest.TestCase):
    def made(self, grey, scale, depth, thickness=0.8):
        traced = silhouette.trace(grey, 0.15)
        shading = Shading.of(grey, traced.mask) if depth else None
        view = outline_body.View(traced, scale, 0.0)
        body, (overlap,) = outline_body.model(
            [view], thickness, SHAPES["angular"], stream(1, "silhouette"), shading, depth or 0.0
        )
        mesh = TriangleMesh(body.vertices, body.triangles, np.arange(len(body.triangles)))
        self.assertEqual(faults(mesh), [])
        self.assertGreaterEqual(overlap, 0.95)
        return body, traced

    def test_the_relief_is_that_of_the_body_in_the_image(self):
        found = []
        for name in ("angular", "subangular", "worn"):
            for seed in (1, 2, 3):
                true = model(SHAPES[name], 500, stream(seed, "shape"))
                true = HollowBody.of(true.vertices, true.triangles)
                grey, height, scale = image(true, noise=0.05)
                with_relief, without = (
                    alike(heights(*self.made(grey, scale, depth), scale), height, height < np.inf)
                    for depth in (1.0, None)
                )
                found.append((with_relief, without))
        with_relief, without = np.array(found).T
        print("\ncorrelation of heights, with relief and without:", np.round(found, 2).tolist())
        # The worst are grains that are level nowhere.
        self.assertGreater(with_relief.min(), 0.8)
        self.assertGreater(with_relief.mean(), 0.9)
        self.assertGreater(np.mean(with_relief - without), 0.05)

    def test_a_dome_and_a_dish_look_the_same_and_the_sign_of_the_depth_chooses(self):
        (grey, dome, scale), (same, bowl, _) = image(dish(-60)), image(dish(60))
        inner = silhouette.blurred((grey > 0.15).astype(float), 4) > 0.999
        np.testing.assert_allclose(grey[inner], same[inner], atol=1e-6)
        for depth, right, wrong in ((1.0, dome, bowl), (-1.0, bowl, dome)):
            found = heights(*self.made(grey, scale, depth, 0.5), scale)
            self.assertGreater(alike(found, right, inner), 0.9)
            self.assertLess(alike(found, wrong, inner), -0.9)
        # Half the depth is half as far from the inflated outline.
        rise = [
            np.ptp(heights(*self.made(grey, scale, depth, 0.5), scale)[inner])
            for depth in (-0.5, -1.0)
        ]
        self.assertAlmostEqual(rise[0] / rise[1], 0.5, delta=0.05)

    def test_bodies_of_outlines_with_bays_are_sound_too(self):
        y, x = np.mgrid[:300, :300] + 0.5
        disc = np.hypot(x - 150, y - 150) < 100
        light = 0.4 + 0.003 * np.hypot(x - 150, y - 150)
        light += 0.02 * np.random.default_rng(1).standard_normal(light.shape)
        for bay in (np.hypot(x - 250, y - 170) < 50, (np.abs(y - 150) < 6) & (x > 175)):
            for depth in (3.0, 1.0, -1.0):
                self.made(np.where(disc & ~bay, light, 0.04), 1.0, depth)

    def test_an_evenly_bright_grain_has_no_relief(self):
        grey = image(dish(-60))[0]
        even = np.where(grey > 0.15, 0.6, 0.04)
        mask = silhouette.trace(even, 0.15).mask
        self.assertIsNone(Shading.of(even, mask))
        noise = 1 + 0.05 * np.random.default_rng(1).standard_normal(even.shape)
        self.assertIsNone(Shading.of(even * noise, mask))
        self.assertIsNotNone(Shading.of(grey, mask))


if __name__ == "__main__":
    unittest.main()
