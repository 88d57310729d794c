"""What the caller is told while Blender works: a JSON object on each line of standard output."""

import json

PREFIX = "@soilsig "


def emit(event, **fields):
    # Flushed line by line: Blender's buffer would hold every line back until the end.
    print(PREFIX + json.dumps({"event": event, **fields}, ensure_ascii=True), flush=True)


def progress(stage, done, total):
    emit("progress", stage=stage, done=done, total=total)


def warning(message):
    emit("warning", message=message)
