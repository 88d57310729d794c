"""Models dusty grains, drops them into a tray and exports the settled bed.

blender -b --factory-startup --python-exit-code 13 --python drop.py -- --scene S --out DIR
python drop.py -- --scene S --out DIR        (a Python that imports bpy)

S is a recipe that `soilsig` has checked; there may be several. The files of its bed go into a
folder of DIR that has the name of the recipe's file without its ending.
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from soilsig_blender.common.files import EXTRA
from soilsig_blender.common.script import run


def main(arguments):
    parser = argparse.ArgumentParser(prog="drop.py", description="Drop beds of dusty grains.")
    parser.add_argument(
        "--scene",
        action="append",
        required=True,
        help="scene file with a packing; each gives one bed",
    )
    parser.add_argument("--out", required=True, help="folder for the beds")
    parser.add_argument(
        "--also",
        action="append",
        default=[],
        choices=EXTRA,
        help="a further file to write, of the first bed",
    )
    options = parser.parse_args(arguments)
    from soilsig_blender.make_bed import make_beds

    make_beds(options.scene, options.out, options.also)


if __name__ == "__main__":
    run(main)
