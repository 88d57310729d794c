"""Fines on a grain, seated as in a bed; shown while the settings change."""

from functools import lru_cache

import numpy as np
from mathutils import Matrix

from . import objects
from .operators import GrainOperator, progress, registration
from .soilsig_blender.common.errors import BedError
from .soilsig_blender.dust import dressing
from .soilsig_blender.dust.prototype import coats_of, model_fines
from .soilsig_blender.export import own_scene


class Dress(GrainOperator):
    """Seat fines on the grain's facets, by count or by cover of the silhouette"""

    bl_idname = "soilsig.dress"
    bl_label = "Dress with Fines"

    def work(self, context):
        return dress(context, objects.grain(context))


class Undress(GrainOperator):
    """Take the fines off that the add-on put on the grain"""

    bl_idname = "soilsig.undress"
    bl_label = "Take Fines Off"

    @classmethod
    def poll(cls, context):
        o = objects.grain(context)
        return o is not None and objects.fines_of(o) is not None

    def work(self, context):
        o = objects.grain(context)
        objects.to_object_mode(context)
        objects.activate(context, o)
        objects.remove(objects.fines_of(o))


def dress(context, o):
    """Puts fines on a grain in place of those that it has; says how many, and their cover."""
    settings = context.scene.soilsig
    with progress(context, 4) as advance:
        body = objects.sound_body(context, o)
        centre = body.volume_and_centroid[1]
        body = body.moved(np.eye(3), -centre)
        advance()
        fines = _fines(settings.seed)
        advance()
        worn, cover = dressing.dress(
            body, fines, settings.fines, own_scene.DUST, settings.seed, o.name
        )
        advance()
        old = objects.fines_of(o)
        if old:
            objects.remove(old)
        count = len(worn)
        if count:
            _show(context, o, coats_of(fines, worn), centre)
        advance()
    o.soilsig.role = "GRAIN"
    silhouette, surface = cover.silhouette(count), cover.surface(count)
    words = f"{count} fines: {silhouette:.3f} of the silhouette, {surface:.3f} of the surface"
    context.scene["soilsig_cover"] = words
    return words


def refresh(context):
    """Dresses the grain again that is dressed already, as its settings have changed."""
    o = objects.grain(context)
    if o is None or objects.fines_of(o) is None:
        return
    try:
        dress(context, o)
    except BedError as error:
        context.scene["soilsig_cover"] = str(error)


@lru_cache(maxsize=4)
def _fines(seed):
    return model_fines({"seed": seed, "fines": own_scene.fine_classes()})


def _show(context, o, coats, centre):
    first = np.cumsum([0] + [len(coat.vertices) for coat in coats])
    vertices = np.vstack([coat.vertices for coat in coats]) + centre
    triangles = np.vstack([coat.triangles + at for coat, at in zip(coats, first)])
    name = f"{o.name} fines"
    mesh = objects.mesh_of(name, vertices, triangles.tolist())
    mesh.materials.append(objects.material("soilsig fines", (0.93, 0.87, 0.74, 1.0)))
    coat = objects.add(context, name, mesh, "FINES")
    coat.parent = o
    # The body has the grain's rotation and scale already.
    coat.matrix_world = Matrix.Translation(o.matrix_world.translation)


register, unregister = registration(Dress, Undress)
