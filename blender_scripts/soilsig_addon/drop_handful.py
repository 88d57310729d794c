"""Drops a handful of the grain in another Blender and lays the bed beside it."""

import contextlib
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading

import bpy
from mathutils import Vector

from . import SCRIPTS, objects
from .operators import GrainOperator, registration
from .soilsig_blender.common.errors import BedError
from .soilsig_blender.common.events import PREFIX
from .soilsig_blender.export import grain_files, json_files, own_scene
from .soilsig_blender.model import own_grains

# Where each stage begins, in per cent of the drop's time; the pointer shows the progress.
_STAGES = {"model": 0, "dust": 5, "drop": 20, "check": 85, "export": 90}


class DropHandful(GrainOperator):
    bl_idname = "soilsig.drop"
    bl_label = "Drop a Handful"
    bl_description = (
        "Drop a handful of the dusty grain into a tray and lay the bed beside it. Another Blender "
        "does it in the background: Esc ends it"
    )

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
    """drop.py at work in another Blender, which leaves the open file alone."""

    def __init__(self, context):
        o = objects.grain(context)
        body = objects.sound_body(context, o)
        settings = context.scene.soilsig
        self.beside = objects.moved(o.matrix_world, (0.0, 0.0, 0.0)).translation + Vector(
            (3 * max(o.dimensions), 0, 0)
        )
        self.folder = tempfile.TemporaryDirectory(prefix="soilsig-")
        place = self.folder.name
        diameter = own_grains.describe(body)["diameter_um"]
        entry = grain_files.save(
            os.path.join(place, "grains"),
            "grain",
            own_grains.normalised(body, diameter),
            "angular",
            {},
        )
        recipe = os.path.join(place, "scene.json")
        scene = own_scene.scene(
            o.name, {"grain": entry}, "grains", settings.handful, settings.fines, settings.seed, 0
        )
        scene["geometry"]["packing"]["variants"] = 1
        json_files.write(recipe, scene)
        self.bed = os.path.join(place, "scene", "scene.blend")
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


register, unregister = registration(DropHandful)
