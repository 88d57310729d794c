"""Prepares Blender's window for grains: loads the add-on, opens its sidebar and sets the units.

blender --python window.py -- [--grains FOLDER]
"""

import argparse
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from soilsig_blender.common.script import run


def main(arguments):
    parser = argparse.ArgumentParser(prog="window.py", description="Open the window for grains.")
    parser.add_argument("--grains", help="the library's folder")
    options = parser.parse_args(arguments)
    # It is there already if the preferences have installed it.
    if not hasattr(bpy.types.Scene, "soilsig"):
        import soilsig_addon

        soilsig_addon.register()
    view = bpy.context.preferences.view
    splash, view.show_splash = view.show_splash, False
    for scene in bpy.data.scenes:
        units = scene.unit_settings
        # The units of a new file. Units that the user has chosen are kept.
        if units.scale_length == 1 and not bpy.data.filepath:
            units.system, units.scale_length, units.length_unit = "METRIC", 0.001, "MICROMETERS"
    if options.grains:
        bpy.context.scene.soilsig.library = os.path.abspath(options.grains)

    def when_open():
        view.show_splash = splash
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    area.spaces.active.show_region_ui = True

    bpy.app.timers.register(when_open, first_interval=0.5)


if __name__ == "__main__":
    run(main)
