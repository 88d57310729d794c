"""The checks of a bed, on poses damaged on purpose, and the settings of the second try."""

import unittest
from types import SimpleNamespace
from unittest import mock

import numpy as np
from soilsig_blender.check import attempts, bed_check, porosity
from soilsig_blender.common.errors import BedError
from soilsig_blender.drop.settle import Drop
from soilsig_blender.dust.solids import DustySolids, Solids
from soilsig_blender.model.polyhedron import intersect

PACKING = {"tray_um": [1000, 1000], "seed": 1, "drop": {}}
SETTINGS = {
    "collision": "mesh",
    "substeps": 8,
    "iterations": 60,
    "max_frames": 50,
    "scale": 0.01,
    "gravity": 5.0,
    "margin": 0.5,
}


def cube(side):
    """A bare grain: a cube about the origin."""
    return intersect(np.vstack([np.eye(3), -np.eye(3)]), np.full(6, side / 2))


def grain(side):
    body = cube(side)
    core = Solids.of([body])
    none = np.empty(0, int)
    radius = np.linalg.norm(body.vertices, axis=1).max()
    return SimpleNamespace(
        name="cube",
        grain=body,
        outline=body.vertices,
        grain_class={"diameter_um": side},
        volume_um3=side**3,
        solids=DustySolids(core, core.take(none), np.empty((0, 3)), np.empty(0), radius),
    )


def dropped(*middles, settled=True):
    poses = np.tile(np.eye(4), (len(middles), 1, 1))
    poses[:, :3, 3] = middles
    return Drop(
        np.zeros(len(middles), int), poses, settled, 70, 0.01, 1e-5, (0.1, 0.5), 900.0, [], None
    )


class Checks(unittest.TestCase):
    def found(self, drop):
        return bed_check.check([grain(100.0)], drop, PACKING)["overlaps"]

    def refusal(self, drop):
        with self.assertRaises(BedError) as caught:
            bed_check.check([grain(100.0)], drop, PACKING)
        return caught.exception

    def test_a_sound_bed_passes_with_its_gap(self):
        found = self.found(dropped((500, 500, 50), (602, 500, 50)))
        self.assertEqual((found["contacts"], found["overlapping"]), (1, 0))
        self.assertAlmostEqual(found["median_gap_um"], 2.0)

    def test_a_position_that_is_not_a_number(self):
        for value in (np.nan, np.inf):
            drop = dropped((500, 500, 50), (700, 500, 50))
            drop.poses[1, 0, 3] = value
            error = self.refusal(drop)
            self.assertEqual(error.kind, "nan")
            self.assertIn("1 of 2 grains", str(error))

    def test_grains_beside_below_and_above(self):
        for out in ((-1, 500, 50), (500, 1001, 50), (500, 500, -1), (500, 500, 901)):
            error = self.refusal(dropped((500, 500, 50), out))
            self.assertEqual(error.kind, "escaped")
            self.assertIn("1 of 2 grains", str(error))

    def test_a_bed_that_moves(self):
        error = self.refusal(dropped((500, 500, 50), settled=False))
        self.assertEqual(error.kind, "not_settled")
        self.assertIn("0.10 (mean) and 0.50 (greatest)", str(error))
        self.assertIn("allowed are 0.2 and 0.9, for up to 3 frames in a row", str(error))
        self.assertIn("70 frames", str(error))

    def test_overlap_to_the_limit_passes_and_beyond_it_is_refused(self):
        found = self.found(dropped((500, 500, 50), (598.1, 500, 50)))
        self.assertAlmostEqual(found["max_depth_um"], 1.9)
        self.assertEqual((found["overlapping"], found["deeper_than_1_um"]), (1, 1))
        error = self.refusal(dropped((500, 500, 50), (597, 500, 50)))
        self.assertEqual(error.kind, "overlap")
        self.assertIn("3.0 um", str(error))

    def test_sinking_to_the_limit_passes_and_beyond_it_is_refused(self):
        self.assertAlmostEqual(self.found(dropped((500, 500, 48.1)))["floor_depth_um"], 1.9)
        for into in ((500, 500, 47), (47, 500, 50), (500, 953, 50)):
            error = self.refusal(dropped(into))
            self.assertEqual(error.kind, "sunk")
            self.assertIn("3.0 um", str(error))

    def test_standing_off_the_floor_to_the_limit_passes_and_floating_is_refused(self):
        found = self.found(dropped((500, 500, 52.9), (700, 500, 80)))
        self.assertAlmostEqual(found["floor_gap_um"], 2.9)
        error = self.refusal(dropped((500, 500, 54), (700, 500, 80)))
        self.assertEqual(error.kind, "floating")
        self.assertIn("4.0 um", str(error))


class Tries(unittest.TestCase):
    def test_the_second_try_is_safer_in_every_setting(self):
        self.assertEqual(
            attempts.safer(SETTINGS),
            {
                "collision": "mesh",
                "substeps": 16,
                "iterations": 60,
                "max_frames": 100,
                "scale": 6.5,
                "gravity": 98.1,
                "margin": 0.04,
            },
        )

    def test_what_another_drop_cannot_cure_is_not_dropped_again(self):
        tried = []

        def drop(_, packing, is_second_try):
            tried.append(packing["drop"])
            raise BedError("scene", "too narrow", "widen the tray")

        with mock.patch.object(attempts, "drop", drop), self.assertRaises(BedError) as caught:
            attempts.settled_bed([], {"drop": SETTINGS})
        self.assertEqual((len(tried), caught.exception.kind), (1, "scene"))


class Porosity(unittest.TestCase):
    def test_the_interior_of_a_lattice_of_cubes(self):
        places = [(x, y, z) for x in range(10) for y in range(10) for z in range(5)]
        drop = dropped(*(50 + 100 * np.array(places)))
        void_share = porosity._interior_porosity([grain(80.0)], drop, PACKING, 500.0)
        self.assertAlmostEqual(void_share, 1 - 0.8**3, delta=0.015)


if __name__ == "__main__":
    unittest.main()
