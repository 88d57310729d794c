"""What all operators have in common: undo, errors told in the window, progress shown."""

from contextlib import contextmanager

import bpy

from . import objects
from .soilsig_blender.common.errors import BedError


class Operator(bpy.types.Operator):
    """Base of the operators; `work` does it and may raise `BedError`."""

    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context):
        try:
            done = self.work(context)
        except BedError as error:
            self.report({"ERROR"}, f"{error} ({error.hint})" if error.hint else str(error))
            return {"CANCELLED"}
        if done:
            self.report({"INFO"}, done)
        return {"FINISHED"}


class GrainOperator(Operator):
    """Base of those that need a mesh to work on."""

    @classmethod
    def poll(cls, context):
        return objects.grain(context) is not None


@contextmanager
def progress(context, steps):
    """Yields a function to call after each of some steps: the pointer shows how many are done."""
    manager = context.window_manager
    done = 0

    def advance():
        nonlocal done
        done += 1
        manager.progress_update(done)

    manager.progress_begin(0, steps)
    try:
        yield advance
    finally:
        manager.progress_end()


def registration(*classes):
    """The `register` and `unregister` of a module."""

    def register():
        for cls in classes:
            bpy.utils.register_class(cls)

    def unregister():
        for cls in reversed(classes):
            bpy.utils.unregister_class(cls)

    return register, unregister
