"""The panel, in the order of the work."""

import textwrap

import bpy

from . import body, dress, drop_handful, export_scene, objects, reference, save_grain, start
from .operators import registration

# Letters that fit into a line of the sidebar at its first width.
_WIDTH = 26


class _Section:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Soilsig"


class ImagePanel(_Section, bpy.types.Panel):
    bl_idname = "SOILSIG_PT_image"
    bl_label = "1  Image"

    def draw(self, context):
        settings, layout = context.scene.soilsig, self.layout
        layout.operator(reference.LoadImage.bl_idname, icon="FILE_IMAGE")
        layout.prop(settings, "reference")
        layout.prop(settings, "legend_pixels")
        layout.row().prop(settings, "scale_by", expand=True)
        if settings.scale_by == "PIXELS":
            layout.prop(settings, "pixels_per_um")
        else:
            layout.prop(settings, "bar_um")
            layout.prop(settings, "bar_pixels")
            layout.operator(reference.MeasureBar.bl_idname, icon="ARROW_LEFTRIGHT")


class StartPanel(_Section, bpy.types.Panel):
    bl_idname = "SOILSIG_PT_start"
    bl_label = "2  Start"

    def draw(self, context):
        settings, layout = context.scene.soilsig, self.layout
        layout.prop(settings, "shape")
        layout.prop(settings, "seed")
        column = layout.column(align=True)
        column.prop(settings, "thickness")
        row = column.row(align=True)
        row.prop(settings, "own_threshold", text="")
        part = row.row()
        part.active = settings.own_threshold
        part.prop(settings, "threshold")
        column.prop(settings, "hollows")
        if settings.hollows and not settings.tilted:
            column.prop(settings, "relief")
            if settings.relief:
                column.prop(settings, "relief_depth")
        column.prop(settings, "tilted", text="Tilted")
        if settings.tilted:
            column.prop(settings, "tilt")
        column.operator(start.FromSilhouette.bl_idname, icon="OUTLINER_DATA_CURVE")
        layout.operator(start.FromShape.bl_idname, icon="MESH_ICOSPHERE")


class FormPanel(_Section, bpy.types.Panel):
    bl_idname = "SOILSIG_PT_form"
    bl_label = "3  Form"

    def draw(self, context):
        settings, layout = context.scene.soilsig, self.layout
        o = objects.grain(context)
        layout.label(text=o.name if o else "No grain is active", icon="MESH_DATA")
        layout.prop(settings, "diameter_um")
        layout.operator(body.Normalise.bl_idname, icon="FULLSCREEN_EXIT")
        row = layout.row(align=True)
        row.operator(body.Check.bl_idname, icon="CHECKMARK")
        row.operator(body.Level.bl_idname)
        if o and o.soilsig.report:
            box = layout.box().column(align=True)
            if o.soilsig.fingerprint and o.soilsig.fingerprint != body.fingerprint(o):
                box.label(text="changed since this check:", icon="ERROR")
            for words in o.soilsig.report.splitlines():
                for line in textwrap.wrap(words, _WIDTH):
                    box.label(text=line)
        if o:
            layout.prop(o.soilsig, "size_class", text="Shape")


class FinesPanel(_Section, bpy.types.Panel):
    bl_idname = "SOILSIG_PT_fines"
    bl_label = "4  Fines"

    def draw(self, context):
        settings, layout = context.scene.soilsig, self.layout
        layout.row().prop(settings, "fines_by", expand=True)
        layout.prop(settings, "fines_count" if settings.fines_by == "COUNT" else "fines_cover")
        row = layout.row(align=True)
        row.operator(dress.Dress.bl_idname, text="Dress")
        row.operator(dress.Undress.bl_idname, text="", icon="X")
        row.prop(settings, "live", toggle=True)
        for line in textwrap.wrap(context.scene.get("soilsig_cover", ""), _WIDTH):
            layout.label(text=line)


class LibraryPanel(_Section, bpy.types.Panel):
    bl_idname = "SOILSIG_PT_library"
    bl_label = "5  Library"

    def draw(self, context):
        settings, layout = context.scene.soilsig, self.layout
        layout.prop(settings, "library", text="")
        layout.operator(save_grain.Save.bl_idname, icon="FILE_TICK")


class BedPanel(_Section, bpy.types.Panel):
    bl_idname = "SOILSIG_PT_bed"
    bl_label = "6  Bed"

    def draw(self, context):
        settings, layout = context.scene.soilsig, self.layout
        row = layout.row(align=True)
        row.prop(settings, "handful", text="Grains")
        row.operator(drop_handful.DropHandful.bl_idname, text="Drop", icon="PHYSICS")
        layout.prop(settings, "bed_count", text="Grains of the scene")
        layout.operator(export_scene.ExportScene.bl_idname, icon="EXPORT")


register, unregister = registration(
    ImagePanel, StartPanel, FormPanel, FinesPanel, LibraryPanel, BedPanel
)
