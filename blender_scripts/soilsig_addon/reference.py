"""An SEM image as a scaled reference."""

import bpy
import numpy as np
from bpy.props import StringProperty
from bpy_extras.io_utils import ImportHelper

from . import objects
from .operators import Operator, registration
from .soilsig_blender.common.errors import BedError
from .soilsig_blender.model.silhouette import bar_length


class LoadImage(Operator, ImportHelper):
    """Load an SEM image and lay it flat in the view, true to scale"""

    bl_idname = "soilsig.load_image"
    bl_label = "Load SEM Image"
    filter_glob: StringProperty(
        default="*.png;*.jpg;*.jpeg;*.tif;*.tiff;*.bmp;*.exr", options={"HIDDEN"}
    )

    def work(self, context):
        try:
            image = bpy.data.images.load(self.filepath, check_existing=True)
        except RuntimeError as error:
            raise BedError("scene", f"no image: {self.filepath}", str(error).strip()) from error
        if not image.size[0]:
            raise BedError("scene", f"no image: {self.filepath}", "give one that Blender can read")
        settings = context.scene.soilsig
        objects.to_object_mode(context)
        empty = objects.add(context, f"SEM {image.name}", None, "REFERENCE")
        empty.empty_display_type = "IMAGE"
        empty.data = image
        empty.empty_image_depth = "BACK"
        empty.color[3] = 0.6
        empty.use_empty_image_alpha = True
        settings.reference = empty
        rescale(settings)
        objects.activate(context, empty)
        width, height = (side * settings.um_per_pixel for side in image.size)
        return f"{image.name}: {width:.4g} x {height:.4g} um"


class MeasureBar(Operator):
    """Take the longest bright row of pixels within the legend for the scale bar"""

    bl_idname = "soilsig.measure_bar"
    bl_label = "Find the Bar"

    @classmethod
    def poll(cls, context):
        return image_of(context.scene.soilsig) is not None

    def work(self, context):
        settings = context.scene.soilsig
        grey, _ = pixels(image_of(settings), 1 << 30)
        settings.bar_pixels = bar_length(grey, settings.legend_pixels)
        settings.scale_by = "BAR"
        return f"{settings.bar_pixels:g} pixels: {settings.um_per_pixel:.4g} um a pixel"


def image_of(settings, which="reference"):
    empty = getattr(settings, which)
    return empty.data if empty is not None and empty.type == "EMPTY" else None


def rescale(settings):
    """Makes the reference as large as its scale says."""
    image = image_of(settings)
    if image is not None:
        longer = max(image.size) * settings.um_per_pixel
        settings.reference.empty_display_size = longer / objects.UNIT_UM


def pixels(image, most=1600):
    """Grey values row by row from below, and how many pixels make one of them along a side."""
    width, height = image.size
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(height, width, image.channels)
    grey = values[..., : min(3, image.channels)].mean(axis=2).astype(float)
    share = max(1, -(-max(width, height) // most))
    rows, columns = height // share * share, width // share * share
    blocks = grey[:rows, :columns].reshape(rows // share, share, columns // share, share)
    return blocks.mean(axis=(1, 3)), share


register, unregister = registration(LoadImage, MeasureBar)
