"""What the panel asks for, with its limits: kept in the scene and on the grains."""

import os

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .soilsig_blender.model.shapes import SHAPES

_SHAPES = [(name, name.capitalize(), f"The shape {name} of scenes") for name in SHAPES]


def _rescale(settings, _context):
    from . import reference

    reference.rescale(settings)


def _redress(settings, context):
    from . import dress

    if settings.live:
        dress.refresh(context)


class OfScene(bpy.types.PropertyGroup):
    """Settings of the panel."""

    reference: PointerProperty(
        name="Image", type=bpy.types.Object, description="The SEM image that is the reference"
    )
    scale_by: EnumProperty(
        name="Scale",
        description="How the image's scale is known",
        items=[
            ("PIXELS", "Pixels per um", "By the number of pixels in a micrometre"),
            ("BAR", "Scale bar", "By a bar of known length in the image"),
        ],
        update=_rescale,
    )
    pixels_per_um: FloatProperty(
        name="Pixels per um",
        description="How many pixels of the image make a micrometre",
        default=1.0,
        min=1e-4,
        max=1e4,
        precision=4,
        update=_rescale,
    )
    bar_um: FloatProperty(
        name="Bar, um",
        description="Length of the scale bar, micrometres",
        default=100.0,
        min=1e-3,
        max=1e6,
        update=_rescale,
    )
    bar_pixels: FloatProperty(
        name="Bar, pixels",
        description="Length of the scale bar in the image, pixels",
        default=100.0,
        min=1.0,
        max=1e5,
        update=_rescale,
    )
    legend_pixels: IntProperty(
        name="Legend, pixels",
        description="Height of the microscope's legend at the lower edge, which is not looked at",
        default=0,
        min=0,
        max=100_000,
    )
    own_threshold: BoolProperty(
        name="Own threshold",
        description="Choose the grey value that parts the grain from the ground; else Otsu's",
    )
    threshold: FloatProperty(
        name="Threshold",
        description="Grey value above which a pixel is of the grain",
        default=0.4,
        min=0.0,
        max=1.0,
    )
    thickness: FloatProperty(
        name="Thickness",
        description="Height of the body as a share of the outline's breadth: an image shows none",
        default=0.8,
        min=0.2,
        max=1.5,
    )
    hollows: BoolProperty(
        name="Follow hollows",
        description="Let the body follow the hollows of the outline; else it is convex",
    )
    relief: BoolProperty(
        name="Relief by shading",
        description="Take brightness for slope, as secondary electrons show it, and give the side "
        "that is seen a relief",
    )
    relief_depth: FloatProperty(
        name="Depth",
        description="How many times as deep the relief is as the slopes tell. Negative if they "
        "fall inward, as in a dish: the image does not tell",
        default=1.0,
        min=-3.0,
        max=3.0,
    )
    tilted: PointerProperty(
        name="Tilted image",
        type=bpy.types.Object,
        description="A second image of the grain at the same scale, after the stage was tilted",
    )
    tilt: FloatProperty(
        name="Tilt",
        description="Angle by which the stage was tilted about the images' horizontal axis. "
        "Positive if the upper side of the image came nearer",
        subtype="ANGLE",
        default=0.785398,
        min=-1.570797,
        max=1.570797,
    )
    shape: EnumProperty(
        name="Shape", description="The shape to start from", items=_SHAPES, default="angular"
    )
    seed: IntProperty(
        name="Seed",
        description="Seed of fractures and fines: another gives another body",
        default=1,
        min=0,
        max=2**31 - 1,
        update=_redress,
    )
    diameter_um: FloatProperty(
        name="Diameter, um",
        description="Diameter of the sphere of the grain's volume, micrometres",
        default=500.0,
        min=1.0,
        max=1e5,
        soft_min=20.0,
        soft_max=2000.0,
    )
    fines_by: EnumProperty(
        name="Fines",
        description="How many fines sit on the grain",
        items=[
            ("COUNT", "Count", "So many fines"),
            ("COVER", "Cover", "As many as make this share of the silhouette fines"),
        ],
        update=_redress,
    )
    fines_count: IntProperty(
        name="Fines",
        description="Fines on the grain",
        default=200,
        min=0,
        max=10_000,
        soft_max=2000,
        update=_redress,
    )
    fines_cover: FloatProperty(
        name="Cover",
        description="Share of the dusty grain's silhouette, over all sides, that is fines",
        default=0.6,
        min=0.0,
        max=0.98,
        update=_redress,
    )
    live: BoolProperty(
        name="Live",
        description="Dress the grain again whenever the fines' settings change",
        default=True,
    )
    library: StringProperty(
        name="Library",
        description="Folder of your grains: NAME.obj and NAME.json",
        subtype="DIR_PATH",
        default=os.path.join(os.path.expanduser("~"), "soilsig_grains"),
    )
    handful: IntProperty(
        name="Handful",
        description="How many grains to drop for a look",
        default=12,
        min=1,
        max=60,
    )
    bed_count: IntProperty(
        name="Grains",
        description="How many grains the exported scene drops",
        default=72,
        min=3,
        max=1000,
    )

    @property
    def um_per_pixel(self):
        if self.scale_by == "BAR":
            return self.bar_um / self.bar_pixels
        return 1 / self.pixels_per_um

    @property
    def fines(self):
        """As scene files have it."""
        if self.fines_by == "COUNT":
            return self.fines_count
        return {"silhouette": round(self.fines_cover, 4)}


class OfObject(bpy.types.PropertyGroup):
    """What an object is to the add-on, and what is known of a grain."""

    role: EnumProperty(
        name="Role",
        items=[
            ("NONE", "None", "Not of the add-on"),
            ("GRAIN", "Grain", "A bare grain"),
            ("FINES", "Fines", "The fines on a grain"),
            ("REFERENCE", "Reference", "An SEM image"),
            ("OUTLINE", "Outline", "What was traced out of an image"),
        ],
    )
    # .blend files keep it under this name.
    size_class: EnumProperty(
        name="Stands for",
        description="The shape that the grain stands for in scenes",
        items=_SHAPES,
        default="angular",
    )
    made_from: StringProperty(name="Made from", description="JSON: what the grain was made from")
    report: StringProperty(name="Report", description="What the check found")
    fingerprint: StringProperty(name="Fingerprint", description="Of the mesh that was checked")


_CLASSES = (OfScene, OfObject)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.soilsig = PointerProperty(type=OfScene)
    bpy.types.Object.soilsig = PointerProperty(type=OfObject)


def unregister():
    del bpy.types.Object.soilsig
    del bpy.types.Scene.soilsig
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
