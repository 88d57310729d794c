"""Installs the add-on's zip as Blender's preferences do, and models a grain by it: -- FILE.zip"""

import sys

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.preferences.addon_install(filepath=sys.argv[sys.argv.index("--") + 1])
bpy.ops.preferences.addon_enable(module="soilsig_addon")
scripts = sys.modules["soilsig_blender"]
assert scripts.__path__[0].endswith("soilsig_addon/soilsig_blender")
bpy.ops.soilsig.from_shape()
bpy.ops.soilsig.check()
assert "closed, outward" in bpy.context.active_object.soilsig.report
bpy.context.scene.soilsig.handful = 2
bpy.ops.soilsig.drop()
bpy.ops.preferences.addon_disable(module="soilsig_addon")
assert not hasattr(bpy.types.Scene, "soilsig")
print("installed, used and disabled", flush=True)
