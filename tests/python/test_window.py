"""The add-on's operators, without a window: from an image to a library, a scene and a bed."""

import json
import math
import os
import sys
import tempfile
import unittest

import bpy
import numpy as np
import soilsig_addon
import tomllib
from soilsig_blender.common import recipe
from soilsig_blender.model import own_grains

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scripts"))
import sem_image

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
UNIT_UM = 1000


class Window(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        soilsig_addon.register()

    @classmethod
    def tearDownClass(cls):
        soilsig_addon.unregister()

    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        # Reading the settings takes the add-on away that no preference names.
        if not hasattr(bpy.types.Scene, "soilsig"):
            soilsig_addon.register()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.settings = bpy.context.scene.soilsig
        self.settings.library = os.path.join(self.folder, "grains")
        self.settings.live = False

    def image(self):
        path = os.path.join(self.folder, "sem.png")
        sem_image.write_png(path, sem_image.drawn())
        bpy.ops.soilsig.load_image(filepath=path)
        self.settings.legend_pixels = sem_image.LEGEND

    def shape(self, name="angular", diameter_um=500):
        self.settings.shape, self.settings.diameter_um = name, diameter_um
        bpy.ops.soilsig.from_shape()
        return bpy.context.active_object

    def refused(self, words, operator, **properties):
        with self.assertRaisesRegex(RuntimeError, words):
            operator(**properties)

    def test_an_image_is_laid_true_to_scale_by_pixels_or_by_its_bar(self):
        self.image()
        self.settings.pixels_per_um = 1.25
        shown = self.settings.reference.empty_display_size * UNIT_UM
        self.assertAlmostEqual(shown, sem_image.WIDTH * sem_image.UM_PER_PIXEL, 2)
        self.settings.bar_um = sem_image.BAR_UM
        bpy.ops.soilsig.measure_bar()
        self.assertAlmostEqual(self.settings.um_per_pixel, sem_image.UM_PER_PIXEL)

    def test_the_traced_grain_lies_over_the_one_in_the_image(self):
        self.image()
        self.settings.reference.location = (3, 4, 5)
        self.settings.pixels_per_um = 1 / sem_image.UM_PER_PIXEL
        bpy.ops.soilsig.from_silhouette()
        o = bpy.context.active_object
        bpy.context.view_layer.update()
        corners = np.array([o.matrix_world @ v.co for v in o.data.vertices])
        whole = np.array([sem_image.WIDTH, sem_image.HEIGHT])
        drawn = (sem_image.OUTLINE - whole / 2) * sem_image.UM_PER_PIXEL / UNIT_UM + (3, 4)
        for extreme in (np.min, np.max):
            apart = extreme(corners[:, :2], axis=0) - extreme(drawn, axis=0)
            self.assertLess(np.abs(apart).max(), 0.02)
        self.assertGreater(json.loads(o.soilsig.made_from)["overlap"], 0.9)

    def test_normalising_gives_the_volume_about_the_centre_whatever_the_object_s_scale(self):
        o = self.shape("worn", 853)
        o.scale, o.rotation_euler, o.location = (1, 1.2, -0.7), (0.3, 0.2, 0.1), (1, 2, 3)
        self.settings.diameter_um = 321
        bpy.ops.soilsig.normalise()
        bpy.ops.soilsig.check()
        self.assertIn("diameter 321.0 um", o.soilsig.report)
        self.assertIn("closed, outward", o.soilsig.report)
        np.testing.assert_allclose(o.scale, 1, atol=1e-6)

    def test_a_mesh_of_the_user_s_own_is_a_grain_as_well(self):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.25)
        o = bpy.context.active_object
        bpy.ops.soilsig.save()
        said = own_grains.entries(self.settings.library)
        self.assertEqual([*said], [o.name] if own_grains.NAME.fullmatch(o.name) else [])

    def test_a_damaged_grain_is_refused_and_its_faces_are_selected(self):
        o = self.shape()
        o.data.vertices[3].co *= -2
        bpy.ops.soilsig.check()
        self.assertIn("through itself", o.soilsig.report)
        self.assertEqual(o.mode, "EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        selected = {p.index for p in o.data.polygons if p.select}
        around = {p.index for p in o.data.polygons if 3 in p.vertices}
        self.assertTrue(selected & around)
        self.assertLess(len(selected), len(o.data.polygons))
        self.refused("through itself", bpy.ops.soilsig.save)
        self.refused("through itself", bpy.ops.soilsig.dress)
        self.assertFalse(os.path.exists(self.settings.library))

        before = [v.co[:] for v in o.data.vertices]
        bpy.ops.soilsig.level()
        self.assertIsNot(bpy.context.active_object, o)
        self.assertEqual(before, [v.co[:] for v in o.data.vertices])
        bpy.ops.soilsig.save()

    def test_a_corner_pushed_in_makes_a_hollow_grain_that_is_saved_as_it_is(self):
        o = self.shape()
        o.data.vertices[3].co *= 0.5
        bpy.ops.soilsig.check()
        self.assertIn("hollow: fills 0.9", o.soilsig.report)
        bpy.ops.soilsig.dress()
        self.assertTrue(o.children)
        bpy.ops.soilsig.save()
        saved = own_grains.load(self.settings.library, o.name)
        self.assertLess(saved.convexity, 0.98)

    def test_a_hole_is_refused_by_name(self):
        o = self.shape()
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        o.data.polygons[0].select = True
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.delete(type="ONLY_FACE")
        bpy.ops.soilsig.check()
        self.assertIn("it is open", o.soilsig.report)
        self.refused("no volume", bpy.ops.soilsig.normalise)

    def test_fines_come_by_count_and_by_cover_live_and_go_and_nothing_else_does(self):
        bpy.ops.mesh.primitive_cube_add()
        mine = bpy.context.active_object
        o = self.shape()
        self.settings.fines_count = 50
        bpy.ops.soilsig.dress()
        few = len(self.fines(o).data.vertices)
        self.settings.fines_count = 60
        self.assertEqual(len(self.fines(o).data.vertices), few)
        self.settings.live = True
        self.settings.fines_count = 150
        self.assertGreater(len(self.fines(o).data.vertices), 2 * few)
        self.settings.fines_by = "COVER"
        self.settings.fines_cover = 0.5
        words = bpy.context.scene["soilsig_cover"]
        self.assertRegex(words, r"^\d+ fines: 0\.5\d\d of the silhouette")
        bpy.ops.soilsig.undress()
        self.assertEqual([*o.children], [])
        self.assertEqual({mine.name, o.name}, {x.name for x in bpy.data.objects})

    def fines(self, o):
        (child,) = o.children
        self.assertEqual(child.soilsig.role, "FINES")
        return child

    def test_an_outline_is_followed_into_its_hollows_by_one_image_and_by_a_tilted_one(self):
        self.image()
        upright = self.settings.reference
        self.settings.pixels_per_um = 1 / sem_image.UM_PER_PIXEL
        self.settings.hollows = True
        bpy.ops.soilsig.from_silhouette()
        o = bpy.context.active_object
        self.assertEqual(len(o.data.polygons), 8192)
        one = json.loads(o.soilsig.made_from)
        self.assertGreaterEqual(one["overlap"], 0.97)
        self.assertNotIn("tilt_deg", one)
        # The same image once more: a grain of this outline from the side, too.
        self.settings.tilted, self.settings.tilt = upright, math.pi / 2
        bpy.ops.soilsig.from_silhouette()
        o = bpy.context.active_object
        both = json.loads(o.soilsig.made_from)
        self.assertEqual(both["tilt_deg"], 90)
        self.assertGreaterEqual(both["overlap"], 0.95)
        corners = np.array([v.co for v in o.data.vertices])
        self.assertAlmostEqual(np.ptp(corners[:, 1]), np.ptp(corners[:, 2]), delta=0.02)
        bpy.ops.soilsig.check()

    def test_a_traced_grain_gets_a_relief_if_it_is_asked_for(self):
        self.image()
        self.settings.pixels_per_um = 1 / sem_image.UM_PER_PIXEL
        self.settings.hollows = True
        bpy.ops.soilsig.from_silhouette()
        plain = bpy.context.active_object
        self.settings.relief = True
        bpy.ops.soilsig.from_silhouette()
        o = bpy.context.active_object
        self.assertNotIn("relief_depth", json.loads(plain.soilsig.made_from))
        about = json.loads(o.soilsig.made_from)
        self.assertEqual(about["relief_depth"], 1)
        self.assertGreaterEqual(about["overlap"], 0.95)
        one, two = (np.array([v.co for v in x.data.vertices]) for x in (plain, o))
        upper = one[:, 2] > 0.05
        self.assertGreater(np.abs(one - two)[upper].max(), 0.01)
        bpy.ops.soilsig.check()
        self.assertIn("closed, outward", o.soilsig.report)

    def test_what_is_saved_is_what_the_scripts_read(self):
        o = self.shape("subangular", 640)
        o.name = "stone"
        bpy.ops.soilsig.save()
        said = own_grains.entries(self.settings.library)["stone"]
        self.assertEqual((said["shape"], said["diameter_um"]), ("subangular", 640))
        body = own_grains.load(self.settings.library, "stone")
        self.assertEqual(len(body.facets), len(o.data.polygons))
        o.name = "a stone"
        self.refused("cannot name a grain", bpy.ops.soilsig.save)
        path = os.path.join(self.settings.library, "stone.obj")
        with open(path, encoding="utf-8") as file:
            lines = file.read().splitlines()
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(lines[:-1]))
        with self.assertRaisesRegex(Exception, "stone.obj: it is open"):
            own_grains.load(self.settings.library, "stone")

    def test_the_scene_of_a_library_is_a_recipe_that_the_scripts_take(self):
        path = os.path.join(self.folder, "bed.json")
        self.refused(
            "no grain of the library stands for", bpy.ops.soilsig.export_scene, filepath=path
        )
        for name, diameter in (("angular", 480), ("worn", 853), ("chip", 60)):
            self.shape(name, diameter)
            bpy.ops.soilsig.save()
        self.settings.bed_count = 31
        bpy.ops.soilsig.export_scene(filepath=path)
        _, packing = recipe.load(path)
        self.assertEqual([g["count"] for g in packing["grains"]], [16, 15])
        self.assertEqual(packing["grains"][0]["diameter_um"], 480)
        self.assertEqual(packing["fines"][1]["shape"], {"library": ["chip"]})
        self.assertEqual(
            os.path.realpath(packing["library"]), os.path.realpath(self.settings.library)
        )

    def test_a_handful_falls_beside_what_is_there(self):
        bpy.ops.mesh.primitive_cube_add()
        mine = bpy.context.active_object
        self.shape()
        self.settings.handful, self.settings.fines_count = 3, 20
        before = set(bpy.data.objects)
        bpy.ops.soilsig.drop()
        self.assertLess(before, set(bpy.data.objects))
        bed = bpy.data.collections["Soilsig bed"]
        grains = [o for o in bed.objects if o.parent and o.parent.name == "bed"]
        self.assertEqual(len(grains), 3)
        self.assertIn(mine, [*bpy.data.objects])

    def test_old_and_new_blenders_are_told_the_same_of_the_add_on(self):
        with open(os.path.join(ROOT, "Cargo.toml"), "rb") as file:
            project = tomllib.load(file)["workspace"]["package"]
        folder = os.path.dirname(soilsig_addon.__file__)
        with open(os.path.join(folder, "blender_manifest.toml"), "rb") as file:
            manifest = tomllib.load(file)
        old = soilsig_addon.bl_info
        self.assertEqual(manifest["version"], project["version"])
        self.assertEqual(manifest["version"], ".".join(map(str, old["version"])))
        self.assertEqual((manifest["name"], manifest["maintainer"]), (old["name"], old["author"]))
        licences = [name.removeprefix("SPDX:") for name in manifest["license"]]
        self.assertEqual(" OR ".join(licences), project["license"])

    def test_every_operator_can_be_undone_and_says_what_it_does(self):
        names = [name for name in dir(bpy.ops.soilsig) if not name.startswith("_")]
        self.assertGreater(len(names), 9)
        for name in names:
            operator = getattr(bpy.ops.soilsig, name)
            self.assertLessEqual({"REGISTER", "UNDO"}, operator.bl_options, name)
            self.assertGreater(len(operator.get_rna_type().description), 20, name)
        for group in (bpy.types.Scene, bpy.types.Object):
            settings = group.bl_rna.properties["soilsig"].fixed_type
            for prop in settings.properties:
                if prop.identifier in ("rna_type", "name"):
                    continue
                said = prop.description or prop.identifier == "role"
                self.assertTrue(said, prop.identifier)
                if prop.type in ("INT", "FLOAT"):
                    self.assertLessEqual(prop.hard_max, 2**31 - 1, prop.identifier)


if __name__ == "__main__":
    unittest.main()
