"""Says which Blender, Python and numpy this is, in one line."""

import json
import platform

import bpy

try:
    import numpy

    NUMPY = numpy.__version__
except ImportError:
    NUMPY = None

print(
    "@soilsig "
    + json.dumps(
        {
            "event": "probe",
            "blender": bpy.app.version_string,
            "python": platform.python_version(),
            "numpy": NUMPY,
        }
    ),
    flush=True,
)
