"""Models bare grains of every shape and measures them.

blender -b --factory-startup --python-exit-code 13 --python grains.py -- --out DIR
python grains.py -- --out DIR        (a Python that imports bpy)
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from soilsig_blender.common.script import run


def main(arguments):
    parser = argparse.ArgumentParser(prog="grains.py", description="Model and measure grains.")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--variants", type=int, default=4, help="bodies of each shape")
    parser.add_argument("--out", required=True, help="empty folder for the results")
    options = parser.parse_args(arguments)
    from soilsig_blender.make_grains import make_grains

    make_grains(options.seed, options.variants, options.out)


if __name__ == "__main__":
    run(main)
