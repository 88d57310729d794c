"""Fines on a grain: flush, clear of it and of each other, and as many as asked."""

import unittest
from unittest import mock

import numpy as np
from soilsig_blender.check.distance import gaps
from soilsig_blender.common.errors import BedError
from soilsig_blender.common.randomness import stream
from soilsig_blender.dust import cover, dressing, prototype
from soilsig_blender.dust.solids import Solids
from soilsig_blender.model.shapes import SHAPES, model

TOUCH_UM = 1e-4
FINES = [
    {"name": "fine_35", "shape": "flake", "diameter_um": 35, "material": "fine", "share": 0.8},
    {"name": "fine_60", "shape": "chip", "diameter_um": 60, "material": "fine", "share": 0.2},
]
fines = prototype.model_fines({"seed": 1, "fines": FINES})
grain = model(SHAPES["angular"], 400.0, stream(1, "shape", "grain", 0))


def dressed(wanted, layers=8, overlap=0, classes=fines):
    return dressing.dress(
        grain, classes, wanted, {"layers": layers, "overlap": overlap}, 1, "grain_0"
    )


def solids(worn):
    """The fines in their places, as the check of the bed takes them."""
    bodies = [body for fine in fines for body in fine.bodies]
    first = np.cumsum([0] + [len(fine.bodies) for fine in fines])
    which = first[worn.kind] + worn.body
    return Solids.of(bodies).take(which).moved(worn.rotation, worn.position)


def depths(worn):
    """How deep every pair of fines overlaps, exactly, as a share of the finer's diameter."""
    i, j = np.triu_indices(len(worn), 1)
    near = np.linalg.norm(worn.position[i] - worn.position[j], axis=1) < 150
    i, j = i[near], j[near]
    placed = solids(worn)
    diameter = np.array([fine.diameter_um for fine in fines])[worn.kind]
    return -gaps(placed.take(i), placed.take(j)) / np.minimum(diameter[i], diameter[j])


class Covers(unittest.TestCase):
    def test_a_cover_that_all_fines_do_not_make_is_refused_by_their_number(self):
        with (
            mock.patch.object(dressing, "_MOST", 8),
            self.assertRaisesRegex(BedError, "8 fines are"),
        ):
            dressed({"silhouette": 0.9})


class Seating(unittest.TestCase):
    def test_no_fine_sinks_into_its_grain_and_bases_lie_flush_on_it(self):
        for layers, overlap in [(8, 0), (3, 0.3), (1, 1)]:
            worn, _ = dressed(400, layers, overlap)
            heights = solids(worn).corners @ grain.normals.T - grain.offsets
            clear = heights.min(axis=1).max(axis=1)
            self.assertGreater(clear.min(), -TOUCH_UM, (layers, overlap))
            first = worn.layer == 1
            below = (-worn.rotation[first, :, 2] @ -grain.normals.T).max(axis=1)
            np.testing.assert_allclose(below, 1, atol=1e-12)
            np.testing.assert_allclose(clear[first], 0, atol=TOUCH_UM)

    def test_neighbours_pass_through_each_other_no_deeper_than_asked(self):
        self.assertLess(depths(dressed(400)[0]).max(), 1e-5)
        deepest = depths(dressed(300, 2, 0.3)[0]).max()
        self.assertLess(deepest, 0.3 + 1e-5)
        self.assertGreater(deepest, 0.1, "the overlap is made use of")
        self.assertGreater(depths(dressed(400, 1, 1)[0]).max(), 0.3)

    def test_counts_and_shares_are_what_is_asked_in_no_more_layers_than_asked(self):
        for count, layers, overlap in [(0, 1, 0), (1, 1, 0), (150, 1, 0), (400, 3, 0), (900, 1, 1)]:
            worn, _ = dressed(count, layers, overlap)
            self.assertEqual(len(worn), count)
            self.assertLessEqual(abs((worn.kind == 1).sum() - 0.2 * count), 1)
            self.assertLessEqual(worn.layer.max(initial=0), layers)

    def test_fewer_fines_are_the_first_of_more(self):
        for layers, overlap in [(8, 0), (2, 0.3), (1, 1)]:
            more, _ = dressed(300, layers, overlap)
            fewer, _ = dressed(120, layers, overlap)
            for one, other in zip(fewer._arrays(), more[:120]._arrays()):
                np.testing.assert_array_equal(one, other)

    def test_a_grain_takes_fines_beyond_its_first_lattice_if_they_may_overlap(self):
        worn, _ = dressed(5000, 1, 1)
        self.assertEqual(len(worn), 5000)

    def test_fines_without_a_seat_are_refused_with_the_remedy(self):
        with self.assertRaises(BedError) as raised:
            dressed(400, 1)
        said = str(raised.exception)
        self.assertRegex(said, r"of the 400 fines on grain_0 only \d+ find a seat")
        self.assertRegex(said, r"no seat is left for a fine_\d+ in 1 layer")
        self.assertIn("dust.layers or overlap", raised.exception.hint)


class Covering(unittest.TestCase):
    def test_a_cover_is_reached_by_the_fewest_fines(self):
        for share in (0.3, 0.6, 0.8):
            worn, reached = dressed({"silhouette": share})
            self.assertGreaterEqual(reached.silhouette(len(worn)), share)
            self.assertLess(reached.silhouette(len(worn) - 1), share)
            by_count, _ = dressed(len(worn))
            np.testing.assert_array_equal(worn.position, by_count.position)

    def test_a_cover_of_nothing_is_bare(self):
        worn, reached = dressed({"silhouette": 0})
        self.assertEqual((len(worn), reached.silhouette(0), reached.surface(0)), (0, 0, 0))
        _, bare = dressed(0, classes=())
        self.assertEqual((bare.silhouette(0), bare.surface(0)), (0, 0))

    def test_a_cover_out_of_reach_is_refused_with_what_can_be_reached(self):
        with self.assertRaises(BedError) as raised:
            dressed({"silhouette": 0.95}, 1)
        self.assertRegex(str(raised.exception), r"no more than 0\.\d+ can be fines \(\d+ of them\)")

    def test_the_cover_of_a_prefix_is_that_of_the_fewer_fines(self):
        worn, whole = dressed(300)
        part = cover.measure(grain, fines, worn[:100])
        # The lines fill a sphere about the fines: they are others about fewer fines.
        self.assertAlmostEqual(whole.silhouette(100), part.silhouette(100), delta=0.05)
        self.assertEqual(whole.surface(100), part.surface(100))
        covers = [whole.silhouette(n) for n in range(301)]
        self.assertEqual(covers, sorted(covers))

    def test_a_monolayer_covers_the_surface_that_its_bases_and_overhangs_do(self):
        worn, reached = dressed(100, 1)
        floor = roof = 0.0
        for kind, body in zip(worn.kind, worn.body):
            shape = fines[kind].bodies[body]
            areas, _ = shape.facet_areas_and_centroids
            floor += areas.max()
            roof += (areas * np.maximum(shape.normals[:, 2], 0)).sum()
        surface = grain.facet_areas_and_centroids[0].sum()
        share = reached.surface(len(worn))
        self.assertGreater(share, floor / surface - 0.05)
        self.assertLess(share, roof / surface + 0.05)


if __name__ == "__main__":
    unittest.main()
