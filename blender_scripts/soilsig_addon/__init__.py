"""Soilsig's panel in the sidebar of the 3-D view: from an SEM image to grains that `soilsig` uses.

The work is done by `soilsig_blender`, which the headless scripts use as well.
"""

import os

bl_info = {
    "name": "Soilsig grains",
    "description": "Author soil grains over SEM images, for soilsig's thermal-infrared signatures",
    "author": "soilsig",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3-D View > Sidebar > Soilsig",
    "category": "Mesh",
}

# The zip that Blender installs has the scripts inside the add-on; otherwise they are beside it.
_HERE = os.path.dirname(os.path.abspath(__file__))
SCRIPTS = next(
    folder
    for folder in (_HERE, os.path.dirname(_HERE))
    if os.path.isdir(os.path.join(folder, "soilsig_blender"))
)
# An extension may not touch `sys.path`: the scripts are found as a part of this package.
__path__.append(SCRIPTS)


def register():
    for module in _modules():
        module.register()


def unregister():
    for module in reversed(_modules()):
        module.unregister()


def _modules():
    # Imported late: they find `.soilsig_blender` by the path above.
    from . import (
        body,
        dress,
        drop_handful,
        export_scene,
        panel,
        reference,
        save_grain,
        settings,
        start,
    )

    return (settings, reference, start, body, dress, save_grain, drop_handful, export_scene, panel)
