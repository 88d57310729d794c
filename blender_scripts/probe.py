"""Reports the versions of Blender, Python and numpy, in one line."""

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
