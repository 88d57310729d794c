"""What the recipe says of a class: the ribs of its fractures, and own grains taken in turn."""

import json
import os
import tempfile
import unittest

import numpy as np
from soilsig_blender.common import recipe
from soilsig_blender.dust import prototype
from soilsig_blender.model import own_grains
from soilsig_blender.model.shapes import SHAPES, known, shape_of

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
        self.assertEqual(facets[0], 4 * SHAPES["flake"].fractures)
        self.assertTrue(facets[0] < facets[1] < facets[2], facets)
        packing = loaded(lambda packing: packing["grains"][0].update(ribs=0))
        grains = [prototype.build(g, 0, (), bare(packing)).grain for g in packing["grains"][:2]]
        self.assertEqual(len(grains[0].facets), SHAPES["angular"].fractures)
        self.assertGreater(len(grains[1].facets), 40)

    def test_the_shape_s_own_number_is_what_is_modelled_without_them(self):
        own = fines(loaded(asking(SHAPES["flake"].ribs)))
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


class EarlierNames(unittest.TestCase):
    def test_recipes_and_libraries_that_name_shapes_by_them_mean_the_same(self):
        def earlier(packing):
            packing["fines"][0]["shape"] = "fine_35"
            packing["grains"][0]["shape"] = {"like": "grain_853", "elongation": 1, "flatness": 1}

        packing = loaded(earlier)
        present = fines(loaded(lambda packing: None))
        for one, two in zip(fines(packing), present, strict=True):
            np.testing.assert_array_equal(one.vertices, two.vertices)
        stretched = shape_of(packing["grains"][0]["shape"])
        self.assertEqual(stretched.edge_radius, SHAPES["worn"].edge_radius)
        self.assertEqual([known(shape.scene_class) for shape in SHAPES.values()], [*SHAPES])
        with tempfile.TemporaryDirectory() as folder:
            for name, key, shape in (
                ("old", "size_class", "grain_640"),
                ("new", "shape", "subangular"),
                ("none", "shape", "pebble"),
            ):
                with open(os.path.join(folder, f"{name}.json"), "w", encoding="utf-8") as file:
                    json.dump({"soilsig_grain": 1, key: shape, "diameter_um": 1}, file)
            found = own_grains.entries(folder)
        self.assertEqual(
            {n: e["shape"] for n, e in found.items()}, dict.fromkeys(("old", "new"), "subangular")
        )


class OwnGrains(unittest.TestCase):
    def test_each_of_them_is_modelled_as_often(self):
        for names, bodies in ((1, 4), (3, 6), (4, 4), (5, 5)):
            self.assertEqual(recipe.whole_rounds(4, {"library": list("abcde"[:names])}), bodies)
        self.assertEqual(recipe.whole_rounds(4, "flake"), 4)


def bare(packing):
    for grain in packing["grains"]:
        grain["fines"] = 0
    return packing
