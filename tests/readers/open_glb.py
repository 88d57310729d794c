"""Opens a .glb in Blender and prints what stands in it, in um; started by tests/it/pipeline.rs."""

import json
import sys

import bpy
import numpy as np

# The importer of Blender 3.4 uses a name that Debian's numpy no longer has.
if not hasattr(np, "bool"):
    np.bool = bool
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=sys.argv[-1])
bpy.context.view_layer.update()

triangles, materials, corners = 0, set(), []
for thing in bpy.data.objects:
    if thing.type != "MESH":
        continue
    mesh = thing.data
    mesh.calc_loop_triangles()
    triangles += len(mesh.loop_triangles)
    materials |= {slot.material.name for slot in thing.material_slots}
    points = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", points)
    matrix = np.array(thing.matrix_world)
    corners.append(points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])
corners = np.concatenate(corners) * 1e6
found = {
    "triangles": triangles,
    "materials": sorted(materials),
    "min_um": corners.min(axis=0).tolist(),
    "max_um": corners.max(axis=0).tolist(),
}
print("OPENED " + json.dumps(found), flush=True)
