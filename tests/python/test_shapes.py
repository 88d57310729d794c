"""The modelled shapes, and the checks that a damaged body does not pass."""

import dataclasses
import unittest
from itertools import pairwise

import numpy as np
from soilsig_blender.common.errors import BedError
from soilsig_blender.common.randomness import stream
from soilsig_blender.model import body_check, shapes
from soilsig_blender.model.polyhedron import Polyhedron


def body(seed=1, name="worn"):
    return shapes.model(shapes.SHAPES[name], 100.0, stream(seed, "shape", name, 0))


class Modelling(unittest.TestCase):
    def test_every_body_is_within_tolerance_and_the_mean_is_what_is_asked(self):
        for name, shape in shapes.SHAPES.items():
            reached = [shapes.measure(body(seed, name)) for seed in range(10)]
            for key, asked in shape.asked.items():
                values = [r[key] for r in reached]
                for value in values:
                    self.assertLessEqual(abs(value - asked), shapes.TOLERANCE[key], (name, key))
                near = shapes.TOLERANCE[key] / 2
                self.assertAlmostEqual(np.mean(values), asked, delta=near, msg=(name, key))

    def test_stretched_shapes_have_the_proportions_asked_for_and_no_other_volume(self):
        for elongation, flatness in ((0.5, 0.3), (0.3, 0.9), (0.9, 0.25), (1.0, 1.0)):
            entry = {"elongation": elongation, "flatness": flatness, "like": "subangular"}
            shape = shapes.shape_of(entry)
            one = shapes.model(shape, 100.0, stream(1, "shape", "plate", 0))
            reached = shapes.measure(one)
            self.assertAlmostEqual(reached["elongation"], elongation, delta=0.01)
            self.assertAlmostEqual(reached["flatness"], flatness, delta=0.01)
            self.assertAlmostEqual(one.volume_and_centroid[0], np.pi / 6 * 1e6, delta=1.0)
        with self.assertRaisesRegex(BedError, "sphericity"):
            entry = {"elongation": 0.3, "flatness": 0.3, "sphericity": 0.9, "like": "angular"}
            shapes.model(shapes.shape_of(entry), 100.0, stream(1, "shape", "plate", 0))

    def test_any_ribs_make_sound_bodies_within_tolerance_and_more_make_more_facets(
        self,
    ):
        for name, shape in shapes.SHAPES.items():
            facets = []
            for ribs in range(3):
                bodies = [
                    shapes.model(shape.with_ribs(ribs), 100.0, stream(seed, "shape", name, 0))
                    for seed in range(4)
                ]
                for one in bodies:
                    body_check.check(one, f"{name} with {ribs} ribs")
                    reached = shapes.measure(one)
                    for key, wanted in shape.asked.items():
                        self.assertAlmostEqual(
                            reached[key], wanted, delta=shapes.TOLERANCE[key], msg=(name, ribs)
                        )
                facets.append([len(one.facets) for one in bodies])
                if shape.edge_radius == 0:  # no bevels: a facet for each plane, less those cut off
                    self.assertLessEqual(max(facets[-1]), shape.fractures * (1 + ribs))
            for fewer, more in pairwise(facets):
                self.assertLess(max(fewer), min(more), name)

    def test_the_volume_is_that_of_the_sphere_about_the_origin(self):
        for name in shapes.SHAPES:
            volume, centre = body(2, name).volume_and_centroid
            self.assertAlmostEqual(volume / (np.pi / 6 * 100**3), 1, 9)
            self.assertLess(np.abs(centre).max(), 1e-9)

    def test_one_seed_gives_one_body_and_another_another(self):
        one, again, other = body(1), body(1), body(2)
        np.testing.assert_array_equal(one.vertices, again.vertices)
        self.assertNotEqual(one.vertices.tolist(), other.vertices.tolist())

    def test_descriptors_out_of_reach_are_refused_by_name(self):
        shape = dataclasses.replace(shapes.SHAPES["flake"], roundness=0.9)
        with self.assertRaisesRegex(BedError, "'roundness': 0.9"):
            shapes.model(shape, 35.0, stream(1, "shape"))


class Damage(unittest.TestCase):
    """A sound body passes; each way to damage it is found, and named."""

    def setUp(self):
        self.body = body()
        body_check.check(self.body, "a body")

    def refused(self, words, **damage):
        with self.assertRaisesRegex(BedError, f"a body is no sound body: .*{words}"):
            body_check.check(_damaged(self.body, **damage), "a body")

    def test_a_missing_facet(self):
        facets, normals, offsets = self.body.facets, self.body.normals, self.body.offsets
        self.refused("open", facets=facets[1:], normals=normals[1:], offsets=offsets[1:])

    def test_a_facet_turned_over(self):
        first, *others = self.body.facets
        self.refused("same direction", facets=(first[::-1], *others))

    def test_a_body_inside_out(self):
        self.refused("inside out", facets=tuple(loop[::-1] for loop in self.body.facets))

    def test_a_corner_pushed_in(self):
        vertices = self.body.vertices.copy()
        vertices[5] *= 0.9
        self.refused("leaves its plane|before the plane|faces inward", vertices=vertices)

    def test_a_corner_pulled_out(self):
        vertices = self.body.vertices.copy()
        vertices[5] *= 1.001
        self.refused("before the plane", vertices=vertices)

    def test_a_corner_that_is_no_number(self):
        vertices = self.body.vertices.copy()
        vertices[5, 1] = np.nan
        self.refused("not all finite", vertices=vertices)

    def test_a_loose_vertex(self):
        self.refused("belong to no facet", vertices=np.vstack([self.body.vertices, np.zeros(3)]))

    def test_two_bodies_in_one(self):
        count = len(self.body.vertices)
        again = tuple(tuple(corner + count for corner in loop) for loop in self.body.facets)
        self.refused(
            "V - E . F is 4",
            vertices=np.vstack([self.body.vertices] * 2),
            normals=np.vstack([self.body.normals] * 2),
            offsets=np.concatenate([self.body.offsets] * 2),
            facets=self.body.facets + again,
        )


def _damaged(body, **changes):
    fields = {field.name: getattr(body, field.name) for field in dataclasses.fields(Polyhedron)}
    return Polyhedron(**{**fields, **changes})
