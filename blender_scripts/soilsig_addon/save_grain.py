"""Saves a grain into the folder of the user's own grains."""

import json
import os

import bpy

from . import objects
from .operators import GrainOperator, registration
from .soilsig_blender.common.errors import BedError
from .soilsig_blender.export import grain_files
from .soilsig_blender.model import own_grains


class Save(GrainOperator):
    """Save the grain under its object's name; refused if it fails the check"""

    bl_idname = "soilsig.save"
    bl_label = "Save to Library"

    def work(self, context):
        o = objects.grain(context)
        body = objects.sound_body(context, o)
        made_from = json.loads(o.soilsig.made_from or '{"mesh": "by hand"}')
        made_from["blender"] = bpy.app.version_string
        folder = library(context)
        diameter = own_grains.describe(body)["diameter_um"]
        entry = grain_files.save(
            folder, o.name, own_grains.normalised(body, diameter), o.soilsig.size_class, made_from
        )
        return f"{o.name}: {entry['shape']}, {diameter:.1f} um, in {folder}"


def library(context):
    """The folder that the panel names."""
    folder = bpy.path.abspath(context.scene.soilsig.library)
    if not folder:
        raise BedError("scene", "the library has no folder", "choose one in the panel")
    return os.path.abspath(folder)


register, unregister = registration(Save)
