"""Where a grain starts: a silhouette out of the image, or one of the shapes."""

import json
import math
import os

import numpy as np

from . import objects, reference
from .operators import Operator, progress, registration
from .soilsig_blender.common.randomness import stream
from .soilsig_blender.model import outline_body, silhouette, silhouette_body
from .soilsig_blender.model.relief import Shading
from .soilsig_blender.model.shapes import SHAPES, model


class FromSilhouette(Operator):
    """Trace the largest bright patch of the image and model a fractured body of that silhouette"""

    bl_idname = "soilsig.from_silhouette"
    bl_label = "Trace Silhouette"

    @classmethod
    def poll(cls, context):
        return reference.image_of(context.scene.soilsig) is not None

    def work(self, context):
        settings = context.scene.soilsig
        image = reference.image_of(settings)
        tilted = reference.image_of(settings, "tilted")
        with progress(context, 2) as advance:
            traced, share, grey = self._traced(settings, image)
            advance()
            shading = None
            if settings.relief and settings.hollows and not tilted:
                shading = Shading.of(grey, traced.mask)
                if not shading:
                    self.report({"WARNING"}, "the grain is evenly bright: no relief")
            um_per_pixel = settings.um_per_pixel * share
            purpose = stream(settings.seed, "silhouette")
            how = settings.thickness, SHAPES[settings.shape], purpose
            if tilted or settings.hollows:
                views = [outline_body.View(traced, um_per_pixel, 0.0)]
                if tilted:
                    other, share_of_other, _ = self._traced(settings, tilted)
                    scale = settings.um_per_pixel * share_of_other
                    views.append(outline_body.View(other, scale, settings.tilt))
                body, overlaps = outline_body.model(views, *how, shading, settings.relief_depth)
                reached = min(overlaps)
            else:
                body, reached = silhouette_body.model(traced, um_per_pixel, *how)
            advance()
        settings.threshold = traced.threshold
        # Pixels count from the corner of the image, but the image is centred on its object.
        whole = np.array(image.size) / share
        middle = (traced.hull.min(axis=0) + traced.hull.max(axis=0)) / 2
        offset = [*((middle - whole / 2) * um_per_pixel), 0]
        place = objects.moved(settings.reference.matrix_world, offset)
        name = os.path.splitext(image.name)[0]
        line = (traced.outline - middle) * um_per_pixel
        self._draw(context, f"{name} outline", line, place)
        made_from = {
            "silhouette": image.name,
            "um_per_pixel": round(settings.um_per_pixel, 6),
            "threshold": round(traced.threshold, 4),
            "thickness": round(settings.thickness, 4),
            "seed": settings.seed,
            "overlap": round(reached, 4),
            "solidity": round(traced.solidity, 4),
        }
        if tilted:
            made_from["tilted"] = tilted.name
            made_from["tilt_deg"] = round(math.degrees(settings.tilt), 3)
        if shading:
            made_from["relief_depth"] = round(settings.relief_depth, 4)
        o = objects.add_grain(
            context, _plain(name), body, settings.shape, json.dumps(made_from), place
        )
        o.soilsig.report = f"overlap with the outline (IoU) {reached:.3f}"
        if traced.cut_off:
            self.report({"WARNING"}, "the grain reaches the edge of the image: it is cut off there")
        return (
            f"overlap (IoU) {reached:.3f}; the outline fills {traced.solidity:.3f} of its hull; "
            f"threshold {traced.threshold:.3f}"
        )

    @staticmethod
    def _traced(settings, image):
        """The silhouette in an image, how many of its pixels make one of it, and the greys."""
        grey, share = reference.pixels(image)
        threshold = settings.threshold if settings.own_threshold else None
        return silhouette.trace(grey, threshold, settings.legend_pixels // share), share, grey

    @staticmethod
    def _draw(context, name, line, place):
        count = len(line)
        edges = [(i, (i + 1) % count) for i in range(count)]
        corners = np.column_stack([line, np.zeros(count)])
        o = objects.add(context, name, objects.mesh_of(name, corners, [], edges), "OUTLINE", place)
        o.show_in_front = True


class FromShape(Operator):
    """Model one of the five shapes at the diameter given"""

    bl_idname = "soilsig.from_shape"
    bl_label = "Add Shape"

    def work(self, context):
        settings = context.scene.soilsig
        name = settings.shape
        shape = SHAPES[name]
        body = model(
            shape, settings.diameter_um, stream(settings.seed, "shape", shape.scene_class, 0)
        )
        made_from = json.dumps({"shape": name, "seed": settings.seed})
        cursor = context.scene.cursor.matrix
        objects.add_grain(context, name, body, name, made_from, objects.moved(cursor, (0, 0, 0)))
        return f"{name}: {settings.diameter_um:g} um"


def _plain(name):
    """A name of letters that can name a grain."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)[:40]


register, unregister = registration(FromSilhouette, FromShape)
