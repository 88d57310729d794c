"""Models dusty quartz grains, drops them into a tray and exports the settled bed.

blender -b --factory-startup --python-exit-code 13 --python drop.py -- --scene S --out DIR
python drop.py -- --scene S --out DIR        (a Python that imports bpy)

A bed's files go into a folder of DIR named after its seed.
"""

import argparse
import os
import sys
import traceback

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from soilsig_blender.errors import BedError
from soilsig_blender.progress import emit

FAILED = 13


def main(arguments):
    parser = argparse.ArgumentParser(prog="drop.py", description="Drop a bed of dusty grains.")
    parser.add_argument("--scene", required=True, help="scene file with a packing")
    parser.add_argument("--out", required=True, help="folder for the beds")
    parser.add_argument(
        "--bed",
        type=int,
        action="append",
        metavar="SEED",
        help="a bed to make, instead of the scene's",
    )
    parser.add_argument(
        "--also",
        action="append",
        default=[],
        choices=("scene.glb", "scene.blend", "patch.obj"),
        help="write this too, of the first bed",
    )
    options = parser.parse_args(arguments)
    try:
        import numpy  # noqa: F401
    except ImportError as error:
        raise BedError(
            "numpy",
            f"the Python inside Blender ({sys.prefix}) cannot import numpy: {error}",
            "apt install python3-numpy",
        ) from error
    from soilsig_blender.make_bed import make_beds

    make_beds(options.scene, options.out, options.bed, options.also)


def run():
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    try:
        main(arguments)
    except BedError as error:
        emit("error", kind=error.kind, message=str(error), hint=error.hint)
        return FAILED
    except Exception as error:  # whatever it is, the caller hears of it
        traceback.print_exc()
        emit("error", kind="internal", message=f"{type(error).__name__}: {error}", hint=None)
        return FAILED
    return 0


if __name__ == "__main__":
    status = run()
    sys.stdout.flush()
    if status:
        sys.exit(status)
