"""From a scene file to a settled bed and all its files."""

import platform
import time

import bpy
import numpy as np

from . import bed, export_json, export_obj, recipe
from .attempts import settled_bed
from .errors import BedError
from .export_blender import BlenderBed
from .files import whole
from .progress import emit, progress
from .prototype import build, describe, model_fines, variants

OLDEST_BLENDER = (3, 4, 0)


def make_bed(scene_path, folder, with_patch):
    if bpy.app.version < OLDEST_BLENDER:
        raise BedError(
            "version",
            f"this is Blender {bpy.app.version_string}",
            "use Blender 3.4 or newer",
        )
    clock = _Clock()
    scene, packing = recipe.load(scene_path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    progress("model", 0, 1)
    fines = model_fines(packing)
    progress("model", 1, 1)
    clock.lap("model")
    prototypes = []
    wanted = variants(packing)
    for grain_class, variant in wanted:
        prototypes.append(build(grain_class, variant, fines, packing["seed"]))
        progress("dust", len(prototypes), len(wanted))
    clock.lap("dust")
    dropped, found, attempts = settled_bed(prototypes, packing)
    clock.lap("drop")
    shape_of_bed = bed.measure(prototypes, dropped, packing)
    clock.lap("check")
    report = {
        "versions": {
            "blender": bpy.app.version_string,
            "python": platform.python_version(),
            "numpy": np.__version__,
        },
        "prototypes": [describe(prototype) for prototype in prototypes],
        "settle": {
            "settled": dropped.settled,
            "frames": dropped.frames,
            "mean_energy_mgd": dropped.mean_energy,
            "top_speed_sqrt_gd": dropped.top_speed,
        },
        "attempts": attempts,
        "checks": found,
        "bed": shape_of_bed,
    }
    files = _export(folder, scene, packing, prototypes, dropped, report, clock, with_patch)
    emit("done", files=files)


def _export(folder, scene, packing, prototypes, dropped, report, clock, with_patch):
    materials = [material["name"] for material in scene["materials"]]
    beds = []

    def bed_in_blender():
        if not beds:
            beds.append(BlenderBed(materials, prototypes, dropped, packing))
        return beds[0]

    writers = {
        "prototypes.obj": lambda path: export_obj.write_prototypes(path, prototypes),
        "prototypes.mtl": lambda path: export_obj.write_materials(path, materials),
        "scene.json": lambda path: export_json.write_scene(
            path, scene, packing, prototypes, dropped
        ),
        "scene.glb": lambda path: bed_in_blender().write_glb(path),
        "scene.blend": lambda path: bed_in_blender().write_blend(path),
    }
    if with_patch:
        writers["patch.obj"] = lambda path: export_obj.write_patch(
            path, prototypes, dropped.prototype_of, dropped.poses
        )
    for done, (name, write) in enumerate(writers.items()):
        progress("export", done, len(writers) + 1)
        with whole(folder, name) as path:
            write(path)
        clock.lap(f"export {name}")
    with whole(folder, "drop.json") as path:
        export_json.write(path, {**report, "timings_s": clock.laps})
    progress("export", len(writers) + 1, len(writers) + 1)
    return [*writers, "drop.json"]


class _Clock:
    """Seconds by stage, in the order of the stages."""

    def __init__(self):
        self.last = time.monotonic()
        self.laps = {}

    def lap(self, stage):
        now = time.monotonic()
        self.laps[stage] = round(now - self.last, 3)
        self.last = now
