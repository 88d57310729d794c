"""Grains into the library, a handful of them dropped, the scene of all of them written."""

import contextlib
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper
from mathutils import Vector
from soilsig_blender import author_scene, export_json, library
from soilsig_blender.errors import BedError
from soilsig_blender.progress import PREFIX

from . import SCRIPTS, objects
from .step import OnGrain, Step, registration

# Stages of the drop as shares of its time, for the pointer that shows how far it is.
_STAGES = {"model": 0, "dust": 5, "drop": 20, "check": 85, "export": 90}


class Save(OnGrain):
    """Write the grain into the library by its object's name; refused if it fails the check"""

    bl_idname = "soilsig.save"
    bl_label = "Save to Library"

    def work(self, context):
        o = objects.grain(context)
        body = objects.sound_body(context, o)
        made_from = json.loads(o.soilsig.made_from or '{"mesh": "by hand"}')
        made_from["blender"] = bpy.app.version_string
        folder = _library(context)
        diameter = library.describe(body)["diameter_um"]
        entry = library.save(
            folder, o.name, library.normalised(body, diameter), o.soilsig.size_class, made_from
        )
        return f"{o.name}: {entry['size_class']}, {diameter:.1f} um, in {folder}"


class ExportScene(Step, ExportHelper):
    """Write the scene file of a bed of the library's grains, for `soilsig pipeline --scene`"""

    bl_idname = "soilsig.export_scene"
    bl_label = "Export Scene File"
    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, context):
        settings = context.scene.soilsig
        made = author_scene.export(
            self.filepath, _library(context), settings.bed_count, settings.fines, settings.seed
        )
        classes = made["geometry"]["packing"]["grains"]
        return ", ".join(f"{c['count']} {c['name']}" for c in classes)


class DropHandful(OnGrain):
    """Drop a handful of the grain, dressed, into a tray and lay the bed beside it. A Blender in the background does it: Esc ends it"""  # noqa: E501

    bl_idname = "soilsig.drop"
    bl_label = "Drop a Handful"

    def work(self, context):
        drop = _Drop(context)
        with contextlib.closing(drop):
            for line in drop.process.stdout:
                drop.hear(line)
            return drop.take_up(context)

    def invoke(self, context, _event):
        try:
            self.drop = _Drop(context)
        except BedError as error:
            self.report({"ERROR"}, f"{error} ({error.hint})")
            return {"CANCELLED"}
        self.lines = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self.timer = manager.event_timer_add(0.2, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._end(context)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        while not self.lines.empty():
            line = self.lines.get()
            if line is not None:
                self.drop.hear(line)
                context.window_manager.progress_update(self.drop.percent)
                context.workspace.status_text_set(f"drop: {self.drop.percent} %")
                continue
            try:
                self.report({"INFO"}, self.drop.take_up(context))
                return {"FINISHED"}
            except BedError as error:
                self.report({"ERROR"}, f"{error} ({error.hint})")
                return {"CANCELLED"}
            finally:
                self._end(context)
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        self._end(context)

    def _listen(self):
        for line in self.drop.process.stdout:
            self.lines.put(line)
        self.lines.put(None)

    def _end(self, context):
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        self.drop.close()


class _Drop:
    """drop.py at work in another Blender, so that nothing of this one's file is touched."""

    def __init__(self, context):
        o = objects.grain(context)
        body = objects.sound_body(context, o)
        settings = context.scene.soilsig
        self.beside = objects.moved(o.matrix_world, (0.0, 0.0, 0.0)).translation + Vector(
            (3 * max(o.dimensions), 0, 0)
        )
        self.folder = tempfile.TemporaryDirectory(prefix="soilsig-")
        place = self.folder.name
        diameter = library.describe(body)["diameter_um"]
        entry = library.save(
            os.path.join(place, "grains"),
            "grain",
            library.normalised(body, diameter),
            "grain_500",
            {},
        )
        recipe = os.path.join(place, "scene.json")
        scene = author_scene.scene(
            o.name, {"grain": entry}, "grains", settings.handful, settings.fines, settings.seed, 0
        )
        scene["geometry"]["packing"]["variants"] = 1
        export_json.write(recipe, scene)
        self.bed = os.path.join(place, str(settings.seed), "scene.blend")
        script = os.path.join(SCRIPTS, "drop.py")
        blender = bpy.app.binary_path
        command = [sys.executable, script]
        if blender:
            command = [blender, "--background", "--factory-startup", "-noaudio"]
            command += ["--python-exit-code", "13", "--python", script]
        command += ["--", "--scene", recipe, "--out", place, "--also", "scene.blend"]
        self.percent = 0
        self.error = None
        self.done = False
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )

    def hear(self, line):
        """Takes in one line of what the other Blender says."""
        at = line.find(PREFIX)
        if at < 0:
            return
        try:
            event, _ = json.JSONDecoder().raw_decode(line[at + len(PREFIX) :])
        except ValueError:
            return
        if event["event"] == "progress" and event["stage"] in _STAGES:
            stages = [*_STAGES.values(), 100]
            first = _STAGES[event["stage"]]
            width = stages[stages.index(first) + 1] - first
            self.percent = first + width * event["done"] // max(event["total"], 1)
        elif event["event"] == "error":
            self.error = BedError(event["kind"], event["message"], event["hint"])
        elif event["event"] == "done":
            self.done = True

    def take_up(self, context):
        """Brings the settled bed into this file, in a collection of its own."""
        if self.error:
            raise self.error
        if self.process.wait() or not self.done:
            raise BedError(
                "internal", "the other Blender ended before it was done", "try `soilsig doctor`"
            )
        objects.to_object_mode(context)
        with bpy.data.libraries.load(self.bed) as (there, here):
            here.objects = [name for name in there.objects if name not in ("camera", "sun")]
        collection = bpy.data.collections.new("Soilsig bed")
        context.scene.collection.children.link(collection)
        for o in here.objects:
            collection.objects.link(o)
            if o.parent is None:
                o.location += self.beside
        return f"{context.scene.soilsig.handful} grains settled, in {collection.name}"

    def close(self):
        if self.process.poll() is None:
            self.process.terminate()
            self.process.wait()
        self.process.stdout.close()
        self.folder.cleanup()


def _library(context):
    folder = bpy.path.abspath(context.scene.soilsig.library)
    if not folder:
        raise BedError("scene", "the library has no folder", "choose one in the panel")
    return os.path.abspath(folder)


register, unregister = registration(Save, ExportScene, DropHandful)
