"""Descriptors against closed forms."""

import unittest

import numpy as np
from soilsig_blender.model import descriptors
from soilsig_blender.model.polyhedron import intersect


def box(*sides):
    half = np.array(sides) / 2
    return intersect(np.vstack([np.eye(3), -np.eye(3)]), np.concatenate([half, half]))


def ball(planes):
    height = 1 - (2 * np.arange(planes) + 1) / planes
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(planes)
    ring = np.sqrt(1 - height**2)
    normals = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
    return intersect(normals, np.ones(planes))


def regular(sides):
    angle = 2 * np.pi * np.arange(sides) / sides
    return np.column_stack([np.cos(angle), np.sin(angle)])


def rounded_square(radius, steps=32):
    """A square of half-side 1 whose corners are quarter circles."""
    corners = []
    for quarter, middle in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        angle = np.pi / 2 * (quarter + np.arange(steps + 1) / steps)
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        corners.append(np.array(middle) * (1 - radius) + radius * circle)
    return np.vstack(corners)


class Feret(unittest.TestCase):
    def test_a_box_is_as_long_as_its_diagonal(self):
        a, b, c = 7.0, 5.0, 2.0
        lengths, axes = descriptors.feret_axes(box(a, b, c).vertices)
        squared = a**2 + b**2 + c**2
        # Across the diagonal the longest vector between corners is another diagonal's part.
        turned = min(abs(x**2 + y**2 - z**2) for x, y, z in ((a, b, c), (b, c, a), (c, a, b)))
        self.assertAlmostEqual(lengths[0], np.sqrt(squared), 12)
        self.assertAlmostEqual(lengths[1], np.sqrt(squared - turned**2 / squared), 12)
        self.assertAlmostEqual(lengths[2], np.abs(axes[2]) @ [a, b, c], 12)
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)

    def test_of_a_cube(self):
        elongation, flatness = descriptors.elongation_and_flatness(box(3, 3, 3).vertices)
        self.assertAlmostEqual(elongation, np.sqrt(8 / 9), 12)
        self.assertAlmostEqual(flatness, np.sqrt(3) / 2, 12)

    def test_of_an_ellipsoid_are_its_axes_whichever_way_it_lies(self):
        body = ball(400).scaled([5, 3, 2])
        turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
        for points in (body.vertices, body.vertices @ turn.T):
            elongation, flatness = descriptors.elongation_and_flatness(points)
            self.assertAlmostEqual(elongation, 3 / 5, delta=0.02)
            self.assertAlmostEqual(flatness, 2 / 3, delta=0.02)


class Sphericity(unittest.TestCase):
    def test_of_a_cube_is_the_cube_root_of_pi_over_6(self):
        self.assertAlmostEqual(descriptors.sphericity(box(2, 2, 2)), (np.pi / 6) ** (1 / 3), 12)

    def test_of_a_box(self):
        wanted = np.pi ** (1 / 3) * (6 * 24) ** (2 / 3) / 52
        self.assertAlmostEqual(descriptors.sphericity(box(2, 3, 4)), wanted, 12)

    def test_of_a_ball_of_many_planes_is_nearly_1(self):
        self.assertAlmostEqual(descriptors.sphericity(ball(400)), 1, delta=0.005)


class Roundness(unittest.TestCase):
    def test_of_a_rounded_square_is_the_radius_of_its_corners(self):
        for radius in (0.2, 0.3, 0.5, 0.8):
            reached = descriptors.roundness_of(rounded_square(radius))
            self.assertAlmostEqual(reached, radius, delta=0.01 * radius)

    def test_of_sharp_corners_is_that_of_the_resolution(self):
        for sides in (3, 4, 6):
            corners = regular(sides)
            smoothed = descriptors.RESOLUTION * np.sqrt(2 * np.pi) * sides / (2 * np.pi)
            perimeter_per_radius = 2 * sides * np.tan(np.pi / sides)
            reached = descriptors.roundness_of(corners)
            self.assertAlmostEqual(reached, smoothed * perimeter_per_radius, delta=1e-3)

    def test_of_a_circle_is_1(self):
        self.assertAlmostEqual(descriptors.roundness_of(regular(200)), 1, delta=0.01)

    def test_of_a_body_does_not_hang_on_its_size_or_place(self):
        body = intersect(*_planes(12))
        moved = body.scaled(40).moved(np.eye(3), np.array([3.0, -70.0, 11.0]))
        reached, again = descriptors.roundness(body), descriptors.roundness(moved)
        self.assertAlmostEqual(reached, again, delta=1e-9)

    def test_classes_are_those_of_powers(self):
        for value, name in ((0.12, "very angular"), (0.2, "angular"), (0.25, "subangular")):
            self.assertEqual(descriptors.roundness_class(value), name)


class Outline(unittest.TestCase):
    def test_is_the_convex_hull_counter_clockwise(self):
        points = np.array([(0, 0), (2, 0), (1, 1), (2, 2), (0, 2), (1, 0), (0.5, 1.5)], float)
        hull = descriptors.outline(points)
        self.assertEqual(hull.tolist(), [[0, 0], [2, 0], [2, 2], [0, 2]])

    def test_the_inscribed_circle_of_known_polygons(self):
        rectangle = np.array([(0, 0), (9, 0), (9, 2), (0, 2)], float)
        self.assertAlmostEqual(descriptors.inscribed_radius(rectangle), 1, 12)
        right_triangle = np.array([(0, 0), (4, 0), (0, 3)], float)
        self.assertAlmostEqual(descriptors.inscribed_radius(right_triangle), 1, 12)
        for sides in (3, 5, 8, 50):
            reached = descriptors.inscribed_radius(regular(sides))
            self.assertAlmostEqual(reached, np.cos(np.pi / sides), 9)

    def test_no_circle_in_a_random_polygon_is_larger(self):
        rng = np.random.default_rng(7)
        for _ in range(20):
            corners = descriptors.outline(rng.normal(size=(30, 2)) * (1, rng.random()))
            ahead = np.roll(corners, -1, axis=0) - corners
            ahead /= np.linalg.norm(ahead, axis=1)[:, None]
            tried = corners.min(axis=0) + rng.random((2000, 2)) * np.ptp(corners, axis=0)
            away = tried[:, None] - corners
            room = (ahead[:, 0] * away[..., 1] - ahead[:, 1] * away[..., 0]).min(axis=1).max()
            radius = descriptors.inscribed_radius(corners)
            self.assertGreaterEqual(radius, room)
            self.assertLess(radius, 1.2 * room + 0.02)


def _planes(count):
    rng = np.random.default_rng(3)
    height = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    ring = np.sqrt(1 - height**2)
    normals = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
    return normals, 1 + 0.2 * rng.random(count)
