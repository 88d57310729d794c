"""Writes the scene file of a bed of the user's own grains."""

from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper

from . import save_grain
from .operators import Operator, registration
from .soilsig_blender.export import own_scene


class ExportScene(Operator, ExportHelper):
    """Write the scene file of a bed of the library's grains, for `soilsig pipeline --scene`"""

    bl_idname = "soilsig.export_scene"
    bl_label = "Export Scene File"
    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, context):
        settings = context.scene.soilsig
        made = own_scene.export(
            self.filepath,
            save_grain.library(context),
            settings.bed_count,
            settings.fines,
            settings.seed,
        )
        classes = made["geometry"]["packing"]["grains"]
        return ", ".join(f"{c['count']} {c['name']}" for c in classes)


register, unregister = registration(ExportScene)
