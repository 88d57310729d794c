"""The grain's body: scaled to a diameter, checked, filled up to its hull."""

import hashlib

import numpy as np
from mathutils import Matrix, Vector

from . import dress, objects
from .operators import GrainOperator, registration
from .soilsig_blender.common.errors import BedError
from .soilsig_blender.model import own_grains
from .soilsig_blender.model.convex_hull import hull_of
from .soilsig_blender.model.mesh_faults import faults
from .soilsig_blender.model.polyhedron import volume_and_centroid
from .soilsig_blender.model.shapes import equivalent_diameter


class Normalise(GrainOperator):
    bl_idname = "soilsig.normalise"
    bl_label = "Normalise"
    bl_description = (
        "Scale the grain so that its volume is that of a sphere of the diameter. Its origin goes "
        "to its centre of mass"
    )

    def work(self, context):
        o = objects.grain(context)
        diameter = context.scene.soilsig.diameter_um
        if o.modifiers:
            raise BedError("scene", f"{o.name} has modifiers", "apply them first")
        mesh = objects.triangle_mesh(context, o)
        unsound = faults(mesh)
        if unsound:
            where = objects.show(context, o, unsound)
            raise BedError("scene", f"{o.name} has no volume: {unsound[0].what}", where)
        volume, centre = volume_and_centroid(mesh.vertices, mesh.triangles)
        factor = diameter / equivalent_diameter(volume)
        if o.data.users > 1:
            o.data = o.data.copy()
        place = o.matrix_world.translation + Vector(centre) / objects.UNIT_UM
        turn = o.matrix_world.to_quaternion()
        # Scale and shear go into the mesh; the rotation stays with the object.
        back = np.array(turn.to_matrix()).T
        vertices = (mesh.vertices - centre) * factor @ back.T / objects.UNIT_UM
        if np.linalg.det(np.array(o.matrix_world)[:3, :3]) < 0:
            o.data.flip_normals()
        o.data.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
        o.data.update()
        o.matrix_world = Matrix.LocRotScale(place, turn, None)
        context.view_layer.update()
        o.soilsig.role = "GRAIN"
        if objects.fines_of(o):
            dress.dress(context, o)
        return f"{o.name}: {diameter:g} um, scaled by {factor:.4g}"


class Check(GrainOperator):
    bl_idname = "soilsig.check"
    bl_label = "Check"
    bl_description = (
        "Is the grain closed, turned outward, in one piece and free of self-intersection? "
        "Faces at fault are selected; descriptors are shown"
    )

    def work(self, context):
        o = objects.grain(context)
        o.soilsig.fingerprint = fingerprint(o)
        mesh = objects.triangle_mesh(context, o)
        found = faults(mesh)
        if found:
            o.soilsig.report = "\n".join(fault.what for fault in found)
            where = objects.show(context, o, found)
            self.report({"WARNING"}, f"{o.name}: {'; '.join(f.what for f in found)} ({where})")
            return None
        about = own_grains.describe(own_grains.body_of(mesh))
        form, filled = about["descriptors"], about["descriptors"]["convexity"]
        o.soilsig.report = "\n".join(
            (
                "closed, outward, one piece",
                "not through itself",
                "convex" if filled == 1 else f"hollow: fills {filled:.3f} of its hull",
                f"diameter {about['diameter_um']:.1f} um",
                f"L I S {', '.join(f'{x:.0f}' for x in about['feret_um'])} um",
                f"elongation I/L {form['elongation']:.3f}",
                f"flatness S/I {form['flatness']:.3f}",
                f"sphericity {form['sphericity']:.3f}",
                f"roundness {form['roundness']:.3f}: {about['roundness_class']}",
            )
        )
        return f"{o.name} is sound"


class Level(GrainOperator):
    """Add the convex hull of the grain as a new grain. The old grain is hidden, not changed"""

    bl_idname = "soilsig.level"
    bl_label = "Convex Hull"

    def work(self, context):
        o = objects.grain(context)
        mesh = objects.triangle_mesh(context, o)
        try:
            body = hull_of(mesh.vertices)
        except ValueError as error:
            raise BedError("scene", f"{o.name} has no hull: {error}", "give it a body") from error
        volume = volume_and_centroid(mesh.vertices, mesh.triangles)[0]
        share = volume / body.volume_and_centroid[0]
        place = Matrix.Translation(o.matrix_world.translation)
        objects.add_grain(
            context, f"{o.name}_hull", body, o.soilsig.size_class, o.soilsig.made_from, place
        )
        o.hide_set(True)
        return f"{o.name} filled {share:.3f} of its hull"


def fingerprint(o):
    """Of the mesh and its scale, to tell whether it was changed since it was checked."""
    if o.mode == "EDIT":
        return ""
    corners = np.empty(3 * len(o.data.vertices), np.float32)
    o.data.vertices.foreach_get("co", corners)
    parts = (corners.tobytes(), len(o.data.polygons), tuple(o.scale), len(o.modifiers))
    return hashlib.sha1(repr(parts).encode()).hexdigest()


register, unregister = registration(Normalise, Check, Level)
