"""The bed as a Blender scene, for the .blend.

One Blender unit is a millimetre. A grain is an object, its fines are one mesh object that is its
child, and all grains of a prototype share their meshes.
"""

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .colours import colours

_UNIT_UM = 1000.0
_METRES = _UNIT_UM * 1e-6


def write_blend(path, materials, prototypes, drop, packing):
    _Bed(materials, prototypes, drop, packing)
    # Else Blender leaves a small picture of each file in the user's home.
    bpy.context.preferences.filepaths.file_preview_type = "NONE"
    bpy.ops.wm.save_as_mainfile(
        filepath=path, copy=True, check_existing=False, relative_remap=False, compress=False
    )


class _Bed:
    """Builds the bed in an empty file."""

    def __init__(self, materials, prototypes, drop, packing):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.unit_settings.system = "METRIC"
        scene.unit_settings.scale_length = _METRES
        scene.unit_settings.length_unit = "MILLIMETERS"
        self.materials = {
            name: _material(name, rgb) for name, rgb in zip(materials, colours(materials))
        }
        root = _add("bed", None, None)
        meshes = [self._meshes(prototype) for prototype in prototypes]
        for i, (p, pose) in enumerate(zip(drop.prototype_of, drop.poses)):
            name = f"{prototypes[p].name}.{i:04d}"
            core, coat = meshes[p]
            grain = _add(name, core, root)
            matrix = pose.copy()
            matrix[:3, 3] /= _UNIT_UM
            grain.matrix_basis = Matrix(matrix.tolist())
            if coat:
                _add(f"{name}.fines", coat, grain)
        _add("floor", self._floor(packing), None)
        self._furnish(packing)
        bpy.context.view_layer.update()

    def _meshes(self, prototype):
        core = self._mesh(prototype.name, (prototype.core,))
        coat = prototype.coats and self._mesh(f"{prototype.name}.fines", prototype.coats)
        return core, coat

    def _mesh(self, name, surfaces):
        mesh = bpy.data.meshes.new(name)
        vertices = np.vstack([s.vertices for s in surfaces]) / _UNIT_UM
        first = np.cumsum([0] + [len(s.vertices) for s in surfaces])
        triangles = np.vstack([s.triangles + at for s, at in zip(surfaces, first)])
        slots = np.repeat(np.arange(len(surfaces)), [len(s.triangles) for s in surfaces])
        mesh.vertices.add(len(vertices))
        mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
        mesh.loops.add(3 * len(triangles))
        mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
        mesh.polygons.add(len(triangles))
        mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(triangles), 3, dtype=np.int32))
        if bpy.app.version < (4, 0, 0):
            mesh.polygons.foreach_set("loop_total", np.full(len(triangles), 3, dtype=np.int32))
        for surface in surfaces:
            mesh.materials.append(self.materials[surface.material])
        mesh.polygons.foreach_set("material_index", slots.astype(np.int32))
        if hasattr(mesh, "shade_flat"):  # faces are smooth from Blender 4.1 on
            mesh.shade_flat()
        mesh.update(calc_edges=True)
        return mesh

    def _floor(self, packing):
        x, y = (side / _UNIT_UM for side in packing["tray_um"])
        mesh = bpy.data.meshes.new("floor")
        mesh.from_pydata([(0, 0, 0), (x, 0, 0), (x, y, 0), (0, y, 0)], [], [(0, 1, 2, 3)])
        mesh.materials.append(self.materials[packing["floor_material"]])
        return mesh

    def _furnish(self, packing):
        """A camera that looks down on the tray, a sun, and a look of quartz."""
        scene = bpy.context.scene
        x, y = (side / _UNIT_UM for side in packing["tray_um"])
        size = max(x, y)
        camera = bpy.data.cameras.new("camera")
        camera.lens = 38
        camera.clip_start, camera.clip_end = size / 100, size * 100
        holder = bpy.data.objects.new("camera", camera)
        holder.location = (x / 2, y / 2 - 0.9 * size, 1.9 * size)
        towards = Vector((x / 2, y / 2, 0.1 * size)) - holder.location
        holder.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
        sun = bpy.data.lights.new("sun", "SUN")
        sun.energy = 3.0
        light = bpy.data.objects.new("sun", sun)
        light.location = (0, 0, 2 * size)
        light.rotation_euler = (0.6, 0.3, 0.4)
        for o in (holder, light):
            scene.collection.objects.link(o)
        scene.camera = holder
        scene.render.resolution_x, scene.render.resolution_y = 1200, 900
        scene.render.engine = "BLENDER_WORKBENCH"
        scene.display.shading.show_cavity = True
        scene.display.shading.color_type = "MATERIAL"
        scene.world = bpy.data.worlds.new("sky")


def _add(name, mesh, parent):
    o = bpy.data.objects.new(name, mesh)
    o.parent = parent
    bpy.context.scene.collection.objects.link(o)
    return o


def _material(name, rgb):
    colour = (*rgb, 1.0)
    material = bpy.data.materials.new(name)
    material.diffuse_color = colour
    material.use_nodes = True
    shader = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = colour
    shader.inputs["Roughness"].default_value = 0.8
    return material
