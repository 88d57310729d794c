"""From a scene file to a settled bed and all its files."""

import os
import time

import bpy

from .check import porosity
from .check.attempts import settled_bed
from .common import recipe
from .common.errors import BedError
from .common.events import emit, progress
from .common.files import EXTRA, whole, whole_folder
from .dust.prototype import build, model_fines, variants
from .export import json_files, obj_files
from .export.blender_files import write_blend
from .export.glb_file import write_glb
from .export.report import report

OLDEST_BLENDER = (3, 4, 0)


def make_beds(scene_paths, folder, extra):
    """Makes the bed of every scene file. Extra files are of the first bed."""
    if bpy.app.version < OLDEST_BLENDER:
        raise BedError(
            "version",
            f"this is Blender {bpy.app.version_string}",
            "use Blender 3.4 or newer",
        )
    files = []
    for done, path in enumerate(scene_paths):
        scene, packing = recipe.load(path)
        bed = os.path.splitext(os.path.basename(path))[0]
        with whole_folder(folder, bed) as beside:
            names = _make_bed(scene, packing, beside, [] if done else extra)
        files += [f"{bed}/{name}" for name in names]
        progress("bed", done + 1, len(scene_paths))
    emit("done", files=files)


def _make_bed(scene, packing, folder, extra):
    clock = _Clock()
    progress("model", 0, 1)
    fines = model_fines(packing)
    progress("model", 1, 1)
    clock.lap("model")
    prototypes = []
    wanted = variants(packing)
    for grain_class, variant in wanted:
        prototypes.append(build(grain_class, variant, fines, packing))
        progress("dust", len(prototypes), len(wanted))
    clock.lap("dust")
    dropped, found, attempts = settled_bed(prototypes, packing)
    clock.lap("drop")
    shape_of_bed = porosity.measure(prototypes, dropped, packing)
    clock.lap("check")
    told = report(prototypes, dropped, attempts, found, shape_of_bed)
    return _export(folder, scene, packing, prototypes, dropped, told, clock, extra)


def _export(folder, scene, packing, prototypes, dropped, told, clock, extra):
    materials = [material["name"] for material in scene["materials"]]
    writers = {
        "prototypes.obj": lambda path: obj_files.write_prototypes(path, prototypes),
        "prototypes.mtl": lambda path: obj_files.write_materials(path, materials),
        "scene.json": lambda path: json_files.write_scene(
            path, scene, packing, prototypes, dropped.prototype_of, dropped.poses
        ),
        "hulls.json": lambda path: json_files.write_scene(
            path, scene, packing, prototypes, dropped.prototype_of, dropped.hulls
        ),
        "frames.json": lambda path: json_files.write_frames(path, packing, prototypes, dropped),
        "scene.glb": lambda path: write_glb(path, materials, prototypes, dropped),
        "scene.blend": lambda path: write_blend(path, materials, prototypes, dropped, packing),
        "patch.obj": lambda path: obj_files.write_patch(
            path, prototypes, dropped.prototype_of, dropped.poses
        ),
    }
    if dropped.hulls is None:
        del writers["hulls.json"]
    names = [name for name in writers if name not in EXTRA or name in extra]
    for done, name in enumerate(names):
        progress("export", done, len(names) + 1)
        with whole(folder, name) as path:
            writers[name](path)
        clock.lap(f"export {name}")
    with whole(folder, "drop.json") as path:
        json_files.write(path, {**told, "timings_s": clock.laps})
    progress("export", len(names) + 1, len(names) + 1)
    return [*names, "drop.json"]


class _Clock:
    """Seconds by stage, in the order of the stages."""

    def __init__(self):
        self.last = time.monotonic()
        self.laps = {}

    def lap(self, stage):
        now = time.monotonic()
        self.laps[stage] = round(now - self.last, 3)
        self.last = now
