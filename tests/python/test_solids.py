"""Hulls of points, and the checks that tell what is wrong with a mesh from anywhere."""

import unittest
import unittest.mock

import numpy as np
from soilsig_blender.common import neighbours
from soilsig_blender.common.randomness import stream
from soilsig_blender.model import body_check, convex_hull, shapes
from soilsig_blender.model.mesh_faults import TriangleMesh, faults, is_hollow

CUBE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * 100
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def said(vertices, faces):
    return [fault.what for fault in faults(TriangleMesh.of_faces(vertices, faces))]


class Hull(unittest.TestCase):
    def test_of_a_modelled_body_is_that_body_facet_by_facet(self):
        for name in ("flake", "angular", "worn"):
            body = shapes.model(shapes.SHAPES[name], 500.0, stream(3, "shape", name))
            # As a modelling program holds it, in millimetres and single precision.
            single = (body.vertices / 1000).astype(np.float32).astype(float) * 1000
            hull = convex_hull.hull_of(np.vstack([single, 0.5 * single]))
            body_check.check(hull, name, 2 * convex_hull.FLATNESS)
            self.assertEqual(len(hull.facets), len(body.facets))
            one, two = body.volume_and_centroid[0], hull.volume_and_centroid[0]
            self.assertAlmostEqual(two / one, 1, 6)

    def test_holds_all_points_whatever_lies_in_one_plane(self):
        rng = np.random.default_rng(2)
        ticks = np.linspace(0, 1, 4)
        grid = np.array([(x, y, z) for x in ticks for y in ticks for z in ticks])
        clouds = [grid, np.round(rng.normal(size=(60, 3)), 1), rng.normal(size=(200, 3))]
        for points in clouds:
            with np.errstate(invalid="raise", divide="raise"):
                hull = convex_hull.hull_of(points)
            body_check.check(hull, "a hull", 2 * convex_hull.FLATNESS)
            size = np.ptp(points, axis=0).max()
            self.assertGreater(convex_hull.depth_below(hull, points).min(), -2e-5 * size)
        self.assertEqual(len(convex_hull.hull_of(grid).facets), 6)

    def test_a_corner_hardly_off_an_edge_makes_no_facet_without_breadth(self):
        near = np.array([50, -1e-4, -1e-4])
        hull = convex_hull.hull_of(np.vstack([CUBE, near, near + near * (0.4, 0, 0)]))
        self.assertEqual((len(hull.facets), len(hull.vertices)), (6, 8))

    def test_of_points_in_a_plane_is_refused(self):
        with self.assertRaisesRegex(ValueError, "plane"):
            convex_hull.hull_of(CUBE * (1, 1, 0) + (0, 0, 5))


class Faults(unittest.TestCase):
    def test_a_sound_body_has_none(self):
        self.assertEqual(said(CUBE, SIDES), [])

    def test_every_damage_is_found_at_its_faces(self):
        def found(vertices, faces):
            return faults(TriangleMesh.of_faces(vertices, faces))

        (hole,) = found(CUBE, SIDES[:-1])
        self.assertIn("open", hole.what)
        self.assertEqual(hole.faces, (0, 1, 2, 3))
        turned = found(CUBE, [SIDES[0][::-1], *SIDES[1:]])
        self.assertIn(0, turned[0].faces)
        self.assertIn("same way", turned[0].what)
        (inward,) = found(CUBE, [side[::-1] for side in SIDES])
        self.assertIn("inside out", inward.what)
        (two,) = found(
            np.vstack([CUBE, 0.5 * CUBE + 300]),
            SIDES + [tuple(c + 8 for c in side) for side in SIDES],
        )
        self.assertIn("2 pieces", two.what)
        self.assertEqual(two.faces, tuple(range(6, 12)))
        lost = CUBE.copy()
        lost[3, 1] = np.nan
        self.assertIn("no number", said(lost, SIDES)[0])
        self.assertIn("without area", said(CUBE, [*SIDES, (0, 0, 1)])[0])
        self.assertEqual(said(CUBE, []), ["it has no faces"])

    def test_a_corner_pushed_in_is_a_sound_hollow_and_one_pushed_through_is_refused(self):
        triangles = [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))]
        pushed = CUBE.copy()
        pushed[7] = 40
        self.assertEqual(said(pushed, triangles), [])
        mesh = TriangleMesh.of_faces(pushed, triangles)
        self.assertTrue(is_hollow(mesh, convex_hull.hull_of(pushed)))
        pushed[7] = (30, 30, -40)
        self.assertIn("through itself", said(pushed, triangles)[0])

    def test_what_is_less_than_a_hair_is_no_hollow(self):
        triangles = [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))]
        pushed = CUBE.copy()
        pushed[7] -= 0.05
        mesh = TriangleMesh.of_faces(pushed, triangles)
        self.assertFalse(is_hollow(mesh, convex_hull.hull_of(pushed)))


class Neighbours(unittest.TestCase):
    def test_a_table_of_cells_and_a_search_find_the_same(self):
        rng = stream(1, "neighbours")
        few, many = rng.random((3, 3)), rng.random((400, 3))
        for points, others in ((many, many), (many, few), (few, many)):
            away = np.linalg.norm(points[:, None] - others, axis=2)
            for reach in (0.3, 0.02):
                found = np.zeros(away.shape, int)
                np.add.at(found, tuple(neighbours.near(points, others, reach)), 1)
                self.assertEqual(found[away < reach].min(initial=1), 1)
                self.assertLessEqual(found.max(), 1)
        tabled = neighbours.near(many, many, 0.1)
        with unittest.mock.patch.object(neighbours, "_TABLED", 0):
            searched = neighbours.near(many, many, 0.1)
        np.testing.assert_array_equal(np.array(tabled), np.array(searched))


if __name__ == "__main__":
    unittest.main()
