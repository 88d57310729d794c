"""Installs the add-on's zip as Blender's preferences do, and models a grain by it: -- FILE.zip

Blender 4.2 and later take it for an extension, and say whether it keeps their rules.
"""

import os
import subprocess
import sys

import bpy

ZIP = sys.argv[sys.argv.index("--") + 1]


def install():
    """The add-on's name, as Blender knows it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if bpy.app.version < (4, 2):
        bpy.ops.preferences.addon_install(filepath=ZIP)
        bpy.ops.preferences.addon_enable(module="soilsig_addon")
        return "soilsig_addon"
    checker = os.path.join(
        bpy.utils.system_resource("SCRIPTS"), "addons_core", "bl_pkg", "cli", "blender_ext.py"
    )
    subprocess.run([sys.executable, checker, "validate", ZIP], check=True)
    bpy.ops.extensions.package_install_files(
        filepath=ZIP, repo="user_default", enable_on_install=True
    )
    import addon_utils  # It is there once bpy is.

    warnings = addon_utils._extensions_warnings_get()
    assert not warnings, warnings
    return "bl_ext.user_default.soilsig_addon"


name = install()
scripts = sys.modules[f"{name}.soilsig_blender"]
assert scripts.__path__[0].endswith("soilsig_addon/soilsig_blender")
bpy.ops.soilsig.from_shape()
bpy.ops.soilsig.check()
assert "closed, outward" in bpy.context.active_object.soilsig.report
bpy.context.scene.soilsig.handful = 2
bpy.ops.soilsig.drop()
bpy.ops.preferences.addon_disable(module=name)
assert not hasattr(bpy.types.Scene, "soilsig")
print("installed, used and disabled", flush=True)
