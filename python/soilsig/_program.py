"""The program ``soilsig``."""

import os
import sys


def main() -> int:
    """Run the program on the command line of this process; returns its exit status."""
    # Where bpy is installed beside this module, its Blender is found.
    if sys.executable:
        os.environ["SOILSIG_PYTHON"] = sys.executable
    from . import _soilsig

    return _soilsig.program(["soilsig", *sys.argv[1:]])
