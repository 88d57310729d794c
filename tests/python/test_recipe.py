"""What the recipe says of a class: the ribs of its fractures, and own grains taken in turn."""

import json
import os
import tempfile
import unittest

import numpy as np
from soilsig_blender.common import recipe
from soilsig_blender.dust import prototype
from soilsig_blender.model.shapes import SHAPES

SPARSE = os.path.join(os.path.dirname(__file__), "..", "..", "scenes", "sparse.json")


def loaded(change):
    """The packing of the sparse scene, after a change."""
    with open(SPARSE, encoding="utf-8") as file:
        scene = json.load(file)
    packing = scene["geometry"]["packing"]
    change(packing)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "recipe.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(scene, file)
        return recipe.load(path)[1]


def asking(ribs):
    return lambda packing: packing["fines"][0].update(ribs=ribs)


def fines(packing):
    return prototype.model_fines(packing)[0].bodies


class Ribs(unittest.TestCase):
    def test_what_a_class_asks_for_is_modelled(self):
        facets = [sum(len(b.facets) for b in fines(loaded(asking(ribs)))) for ribs in (0, 1, 2)]
        self.assertEqual(facets[0], 4 * SHAPES["fine_35"].fractures)
        self.assertTrue(facets[0] < facets[1] < facets[2], facets)
        packing = loaded(lambda packing: packing["grains"][0].update(ribs=0))
        grains = [prototype.build(g, 0, (), bare(packing)).grain for g in packing["grains"][:2]]
        self.assertEqual(len(grains[0].facets), SHAPES["grain_500"].fractures)
        self.assertGreater(len(grains[1].facets), 40)

    def test_the_shape_s_own_number_is_what_is_modelled_without_them(self):
        own = fines(loaded(asking(SHAPES["fine_35"].ribs)))
        for one, other in zip(own, fines(loaded(lambda packing: None))):
            np.testing.assert_array_equal(one.vertices, other.vertices)


class FineShares(unittest.TestCase):
    def test_a_class_of_grains_has_its_own_shares_and_its_kinds_make_the_cover(self):
        def change(packing):
            packing["grains"][0].update(fines=100, fine_shares={"fine_60": 1})
            packing["grains"][1].update(fines=100, fine_shares={"fine_35": 0.5, "fine_60": 0.5})
            packing["grains"][2].update(fines=100)

        packing = loaded(change)
        classes = prototype.model_fines(packing)
        for grain, wanted in zip(packing["grains"], ([0, 100], [50, 50], [80, 20])):
            built = prototype.build(grain, 0, classes, packing)
            kinds = built.dust.kind
            self.assertEqual(np.bincount(kinds, minlength=2).tolist(), wanted)
            by_kind = built.cover.silhouette_by(kinds, 2)
            self.assertAlmostEqual(by_kind.sum(), built.cover.silhouette(100), places=12)
            self.assertEqual((by_kind > 0).tolist(), [n > 0 for n in wanted])


class OwnGrains(unittest.TestCase):
    def test_each_of_them_is_modelled_as_often(self):
        for names, bodies in ((1, 4), (3, 6), (4, 4), (5, 5)):
            self.assertEqual(recipe.whole_rounds(4, {"library": list("abcde"[:names])}), bodies)
        self.assertEqual(recipe.whole_rounds(4, "fine_35"), 4)


def bare(packing):
    for grain in packing["grains"]:
        grain["fines"] = 0
    return packing
