"""Files appear whole or not at all: written beside, then renamed."""

import os
from contextlib import contextmanager


@contextmanager
def whole(folder, name):
    """A path to write to; on success the file takes its name, on failure it is removed."""
    stem, _, ending = name.rpartition(".")
    beside = os.path.join(folder, f".{stem}.part.{ending}")
    try:
        yield beside
        os.replace(beside, os.path.join(folder, name))
    finally:
        if os.path.exists(beside):
            os.remove(beside)
