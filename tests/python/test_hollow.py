"""Bodies with hollows: checks, descriptors, seats, gaps between them, and a bed of them."""

import time
import unittest

import numpy as np
from scan import bracket, scan
from soilsig_blender.check.bed_check import check
from soilsig_blender.check.distance import distance
from soilsig_blender.common.randomness import stream
from soilsig_blender.drop.settle import drop
from soilsig_blender.dust import ground
from soilsig_blender.dust.cover import measure
from soilsig_blender.dust.dressing import FineClass, dress, seated_on_base
from soilsig_blender.dust.hollow_core import HollowCore
from soilsig_blender.dust.prototype import Prototype, Surface, coats_of
from soilsig_blender.dust.reduced_hull import reduced_hull
from soilsig_blender.dust.solids import DustySolids, Solids
from soilsig_blender.model import own_grains, shapes
from soilsig_blender.model.convex_hull import depth_below, hull_of
from soilsig_blender.model.hollow_body import HollowBody
from soilsig_blender.model.mesh_faults import TriangleMesh, faults
from soilsig_blender.model.polyhedron import volume_and_centroid


def body_of(mesh):
    return own_grains.body_of(mesh)


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)])


def pose(turn=None, shift=(0, 0, 0)):
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) if turn is None else turn
    matrix[:3, 3] = shift
    return matrix


def fines(shape="flake", diameter=35.0):
    made = [
        seated_on_base(shapes.model(shapes.SHAPES[shape], diameter, stream(1, shape, i)))
        for i in range(3)
    ]
    return (FineClass("fine", diameter, "fine", 1.0, *zip(*made)),)


def prototype(grain, dust, of, name="grain", diameter=500.0):
    core = Surface("coarse", grain.vertices, grain.triangles)
    coats = coats_of(of, dust)
    volume = sum(volume_and_centroid(s.vertices, s.triangles)[0] for s in (core, *coats))
    points = np.vstack([s.vertices for s in (core, *coats)])
    grain_class = {"name": name, "diameter_um": diameter}
    return Prototype(
        name, grain_class, grain, dust, of, core, coats, volume,
        measure(grain, of, dust), reduced_hull(points, 1e-3 * diameter),
    )  # fmt: skip


def bare(grain):
    dust, _ = dress(grain, (), 0, {"layers": 1, "overlap": 1.0}, 1, "grain")
    return prototype(grain, dust, ())


class Checks(unittest.TestCase):
    def test_a_scan_of_a_hundred_thousand_triangles_is_sound_and_soon_checked(self):
        def cost(mesh):
            start = time.process_time()
            self.assertEqual(faults(mesh), [])
            return time.process_time() - start

        few, many = scan(5), scan(7)
        self.assertGreater(len(many.triangles), 1e5)
        # 16 times the triangles. Comparing each pair of them would take 256 times as long.
        self.assertLess(cost(many), 120 * min(cost(few) for _ in range(3)))

    def test_one_triangle_of_them_that_is_wrong_is_found(self):
        mesh = scan(5)
        turned_over = mesh.triangles.copy()
        turned_over[4000] = turned_over[4000][::-1]
        found = faults(TriangleMesh(mesh.vertices, turned_over, mesh.face))
        self.assertIn(4000, found[0].faces)
        three = np.concatenate([mesh.triangles + i * len(mesh.vertices) for i in range(3)])
        names = np.random.default_rng(1).permutation(3 * len(mesh.vertices))
        vertices = np.empty((len(names), 3))
        vertices[names] = np.concatenate(
            [mesh.vertices + 1000 * i * np.eye(3)[0] for i in range(3)]
        )
        (found,) = faults(TriangleMesh(vertices, names[three], np.arange(len(three))))
        self.assertIn("in 3 pieces", found.what)
        self.assertEqual(len(found.faces), 2 * len(mesh.triangles))
        pierced = mesh.vertices.copy()
        pierced[1000] *= -1.2
        (found,) = faults(TriangleMesh(pierced, mesh.triangles, mesh.face))
        self.assertIn("through itself", found.what)
        self.assertTrue(set(np.flatnonzero((mesh.triangles == 1000).any(axis=1))) & {*found.faces})


class Body(unittest.TestCase):
    def test_what_is_simple_to_compute_is_right(self):
        body = body_of(bracket())
        self.assertIsInstance(body, HollowBody)
        volume, centre = body.volume_and_centroid
        self.assertAlmostEqual(volume, 256e3, places=6)
        np.testing.assert_allclose(centre, (38.75, 38.75, 20), atol=1e-9)
        # The hull's triangle fills the corner of the L: 60 x 60 / 2 x 40 um3 more.
        self.assertAlmostEqual(body.convexity, 256 / (256 + 72), places=6)
        points = np.random.default_rng(1).uniform((0, 0, 0), (100, 100, 40), (2000, 3))
        arm = (points[:, 0] < 40) | (points[:, 1] < 40)
        np.testing.assert_array_equal(body.contains(points), arm)
        notch = np.array([(70.0, 70, 20), (42, 90, 20), (20, 20, 35)])
        np.testing.assert_allclose(body.distances(notch), (30, 2, 5), atol=1e-4)

    def test_gaps_to_points_are_distances_with_a_sign(self):
        for body in (body_of(bracket()), body_of(scan(3))):
            low, extent = body.vertices.min(axis=0), np.ptp(body.vertices, axis=0)
            points = low + extent * np.random.default_rng(1).uniform(-0.2, 1.2, (3000, 3))
            away = np.where(body.contains(points), -1, 1) * body.distances(points)
            reach = 0.05 * extent.max()
            gaps = body.gaps(points, reach)
            told = np.isfinite(gaps)
            np.testing.assert_array_equal(gaps[told], away[told])
            self.assertGreater(away[~told].min(), reach)
            self.assertGreater((gaps < 0).sum(), 500)

    def test_its_envelopes_hold_it(self):
        body = body_of(scan(4))
        for around in (body.envelope, body.tight_envelope):
            self.assertGreaterEqual(depth_below(around, body.vertices).min(), 0)
            filled = hull_of(body.outermost).volume_and_centroid[0]
            self.assertLess(around.volume_and_centroid[0], 1.1 * filled)

    def test_descriptors_of_a_convex_mesh_are_those_of_the_convex_body(self):
        body = shapes.model(shapes.SHAPES["angular"], 500, stream(1, "shape"))
        one, two = (
            shapes.measure(body),
            shapes.measure(HollowBody.of(body.vertices, body.triangles)),
        )
        for name in ("elongation", "flatness", "sphericity"):
            self.assertAlmostEqual(one[name], two[name], places=3, msg=name)
        self.assertAlmostEqual(one["roundness"], two["roundness"], delta=0.03)

    def test_hollows_lower_the_convexity(self):
        for seed in (1, 2):
            said = own_grains.describe(body_of(scan(4, seed)))["descriptors"]
            self.assertLess(said["convexity"], 0.98)
            self.assertGreater(said["convexity"], 0.85)
            self.assertLess(said["sphericity"], 0.95)


class Seats(unittest.TestCase):
    def test_places_are_thinned_first_come_first_served(self):
        rng = stream(1, "places")
        points, normals = rng.random((300, 3)) * (1, 1, 0.1), rng.random((300, 3)) - 0.3
        kept = [0]
        for i in range(1, len(points)):
            away = np.linalg.norm(points[kept] - points[i], axis=1)
            if not ((away < 0.1) & (normals[kept] @ normals[i] > 0)).any():
                kept.append(i)
        self.assertLess(len(kept), 250)
        np.testing.assert_array_equal(ground._thinned(points, normals, 0.1), kept)

    def gaps(self, grain, of, dust):
        """Of every fine to the grain's true surface, negative inside; and its depth in the hull."""
        core = HollowCore(grain)
        placed = Solids.of(of[0].bodies).take(dust.body).moved(dust.rotation, dust.position)
        middle = placed.corners.mean(axis=1)
        outer = np.linalg.norm(placed.corners - middle[:, None], axis=2).max(axis=1)
        gap = [
            core.gap_to_convex(placed.take([i]), middle[[i]], outer[[i]], 10.0)
            for i in range(len(dust))
        ]
        return np.array(gap), depth_below(hull_of(grain.outermost), middle)

    def test_fines_sit_in_hollows_and_touch_the_grain_without_entering_it(self):
        for halvings in (3, 5):
            grain = own_grains.normalised(body_of(scan(halvings)), 500)
            of = fines()
            dust, cover = dress(grain, of, 300, {"layers": 1, "overlap": 1.0}, 1, "grain")
            gap, depth = self.gaps(grain, of, dust)
            self.assertGreater(gap.min(), -0.01)
            self.assertLess(np.quantile(gap, 0.9), 0.05 * 35)
            self.assertGreater(depth.max(), 8, "some sit in the hollows")
            self.assertGreater(cover.surface(300), 0.25)

    def test_fines_fill_a_notch_as_they_do_the_rest_and_keep_out_of_its_walls(self):
        mesh = bracket()
        grain = own_grains.normalised(body_of(mesh), 500)
        of = fines()
        dust, _ = dress(grain, of, 500, {"layers": 3, "overlap": 0.0}, 1, "grain")
        gap, depth = self.gaps(grain, of, dust)
        self.assertGreater(gap.min(), -0.01)
        # The walls of the notch are a sixth of the surface. All of them lie below the hull.
        self.assertAlmostEqual((depth > 0).mean(), 1 / 6, delta=0.06)

    def test_a_hollow_fine_keeps_its_mesh_and_sits_on_its_envelope(self):
        convex, mesh = seated_on_base(own_grains.normalised(body_of(scan(3)), 35))
        self.assertLess(mesh.convexity, 0.98)
        self.assertGreaterEqual(depth_below(convex, mesh.vertices).min(), -1e-9)
        self.assertAlmostEqual(convex.vertices[:, 2].min(), 0, places=9)
        self.assertLess(mesh.vertices[:, 2].min(), 0.35)


class Distance(unittest.TestCase):
    """Brackets about (38.75, 38.75, 20): two of them fit into one another."""

    def gap(self, *place, reach=50.0):
        grain = own_grains.normalised(body_of(bracket()), (6 * 256e3 / np.pi) ** (1 / 3))
        solids = DustySolids.of(bare(grain))
        return distance(solids, solids, pose(), pose(*place), reach)

    def test_two_that_interlock_do_not_overlap(self):
        # Turned by 180 degrees about its corner, the arm lies in the notch of the other.
        half = turned(np.pi)
        for apart in (1.0, 5.0):
            # Both inner corners face each other, `apart` from touching along x and y.
            shift = 2 * (np.array([40.0, 40, 20]) - (38.75, 38.75, 20)) + (60 + apart, apart, 0)
            self.assertAlmostEqual(self.gap(half, shift), apart, delta=0.2)

    def test_the_depth_of_an_overlap_is_that_of_the_true_meshes(self):
        half = turned(np.pi)
        for deep in (2.0, 6.0):
            shift = 2 * (np.array([40.0, 40, 20]) - (38.75, 38.75, 20)) + (60, -deep, 0)
            self.assertAlmostEqual(self.gap(half, shift), -deep, delta=0.5)

    def test_clumps_that_are_left_out_hold_no_nearer_point(self):
        cores = [HollowCore(own_grains.normalised(body_of(scan(4, i)), 500)) for i in (1, 2)]
        rng = np.random.default_rng(1)
        near = 0
        for _ in range(40):
            turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
            turn *= np.sign(np.linalg.det(turn))
            along = rng.standard_normal(3)
            one = cores[0]
            two = cores[1].moved(turn, along / np.linalg.norm(along) * rng.uniform(380, 520))
            points = two._on_edges.points @ two.turn.T + two.shift
            every, found = one.gap_to_points(points, 15.0), one.gap_to_edges(two, 15.0)
            self.assertEqual(np.isfinite(every), np.isfinite(found))
            if np.isfinite(every):
                self.assertAlmostEqual(found, every, places=4)
                near += 1
        self.assertGreater(near, 10)

    def test_far_ones_are_far(self):
        self.assertGreaterEqual(self.gap(None, (300, 0, 0), reach=20.0), 20.0)


class Bed(unittest.TestCase):
    def test_hollow_grains_settle_as_hulls_and_as_meshes(self):
        grain = own_grains.normalised(body_of(scan(3)), 500)
        for collision in ("hull", "mesh"):
            dropped = drop(
                [bare(grain)], packing := {
                    "seed": 1, "variants": 1, "tray_um": [1500, 1500],
                    "grains": [{"name": "grain", "shape": "angular", "count": 12}],
                    "drop": {"collision": collision, "substeps": 10, "iterations": 30,
                             "max_frames": 400, "scale": 6.5, "gravity": 98.1, "margin": 0.04},
                },
            )  # fmt: skip
            found = check([bare(grain)], dropped, packing)["overlaps"]
            self.assertGreater(found["contacts"], 5)


if __name__ == "__main__":
    unittest.main()
