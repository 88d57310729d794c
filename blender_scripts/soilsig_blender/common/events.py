"""What the caller hears while Blender works: one JSON object a line on standard output."""

import json

PREFIX = "@soilsig "


def emit(event, **fields):
    # Flushed one by one: Blender's own buffer would hold every line back until the end.
    print(PREFIX + json.dumps({"event": event, **fields}, ensure_ascii=True), flush=True)


def progress(stage, done, total):
    emit("progress", stage=stage, done=done, total=total)


def warning(message):
    emit("warning", message=message)
