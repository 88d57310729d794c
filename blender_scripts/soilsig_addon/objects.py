"""Between Blender's objects and the bodies of `soilsig_blender`. One Blender unit is a millimetre.

What the add-on makes is marked by a role; it never removes an object without its mark.
"""

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .soilsig_blender.common.errors import BedError
from .soilsig_blender.model import own_grains
from .soilsig_blender.model.mesh_faults import TriangleMesh, faults

UNIT_UM = 1000.0


def grain(context):
    """The mesh to work on: the active object, or the grain that its fines are on."""
    active = context.active_object
    if active is not None and active.soilsig.role == "FINES" and active.parent:
        active = active.parent
    if active is None or active.type != "MESH" or active.soilsig.role not in ("NONE", "GRAIN"):
        return None
    return active


def triangle_mesh(context, o) -> TriangleMesh:
    """The object as it is seen, its modifiers and scale applied: um, about its own origin."""
    to_object_mode(context)
    seen = o.evaluated_get(context.evaluated_depsgraph_get())
    mesh = seen.to_mesh()
    mesh.calc_loop_triangles()
    vertices = _values(mesh.vertices, "co", np.float32).reshape(-1, 3).astype(float)
    triangles = _values(mesh.loop_triangles, "vertices", np.int32).reshape(-1, 3).astype(int)
    face = _values(mesh.loop_triangles, "polygon_index", np.int32).astype(int)
    seen.to_mesh_clear()
    linear = np.array(o.matrix_world)[:3, :3]
    if np.linalg.det(linear) < 0:
        triangles = triangles[:, ::-1]
    return TriangleMesh(vertices @ linear.T * UNIT_UM, triangles, face)


def _values(collection, name, kind):
    width = {"co": 3, "vertices": 3}.get(name, 1)
    values = np.empty(len(collection) * width, kind)
    collection.foreach_get(name, values)
    return values


def sound_body(context, o):
    """The grain as a body about its own origin, or `BedError` with its faces selected."""
    mesh = triangle_mesh(context, o)
    found = faults(mesh)
    if found:
        where = show(context, o, found)
        raise BedError("scene", f"{o.name}: {'; '.join(f.what for f in found)}", where)
    return own_grains.body_of(mesh)


def show(context, o, found):
    """Selects the faces at fault in the window; says where to look."""
    faces = {face for fault in found for face in fault.faces}
    if any(modifier.show_viewport for modifier in o.modifiers):
        return "apply the modifiers to have the faces selected"
    if not faces:
        return "model it anew"
    to_object_mode(context)
    activate(context, o)
    context.tool_settings.mesh_select_mode = (False, False, True)
    bpy.ops.object.mode_set(mode="EDIT")
    # Blender 5.0 crashes where a script writes the selection of edges.
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    polygons = o.data.polygons
    polygons.foreach_set("select", np.isin(np.arange(len(polygons)), list(faces)))
    bpy.ops.object.mode_set(mode="EDIT")
    return "the faces are selected in Edit Mode"


def to_object_mode(context):
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


def activate(context, o):
    """Makes an object the active one, alone selected."""
    for other in context.selected_objects:
        other.select_set(False)
    o.select_set(True)
    context.view_layer.objects.active = o


def add(context, name, mesh, role, matrix=None):
    """A new object of the add-on's own, in the active collection."""
    o = bpy.data.objects.new(name, mesh)
    context.collection.objects.link(o)
    o.soilsig.role = role
    if matrix is not None:
        o.matrix_world = matrix
    return o


def mesh_of(name, vertices_um, faces, edges=()):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata((np.asarray(vertices_um) / UNIT_UM).tolist(), edges, faces)
    mesh.update(calc_edges=not len(edges))
    return mesh


def add_grain(context, name, body, shape, made_from, matrix):
    """A body as a grain, facet by facet, active and selected."""
    to_object_mode(context)
    o = add(context, name, mesh_of(name, body.vertices, body.facets), "GRAIN", matrix)
    o.soilsig.size_class = shape
    o.soilsig.made_from = made_from
    o.data.materials.append(material("soilsig grain", (0.75, 0.55, 0.32, 1.0)))
    activate(context, o)
    return o


def fines_of(o):
    """The fines that the add-on put on a grain, or None."""
    return next((child for child in o.children if child.soilsig.role == "FINES"), None)


def remove(o):
    """Removes an object of the add-on's own, with its mesh."""
    mesh = o.data
    bpy.data.objects.remove(o)
    if mesh is not None and not mesh.users:
        bpy.data.meshes.remove(mesh)


def material(name, colour):
    """A material for the look in the window alone."""
    found = bpy.data.materials.get(name)
    if found is None:
        found = bpy.data.materials.new(name)
        found.diffuse_color = colour
    return found


def moved(matrix, offset_um):
    """Where something stands that is so far from an origin, without the origin's scale."""
    place, turn, _ = matrix.decompose()
    return Matrix.LocRotScale(place + turn @ Vector(offset_um) / UNIT_UM, turn, None)
