"""Prints the share of each grain that fines cover, by number of fines and share of 60 um fines.

python3 scripts/cover_table.py [LAYERS OVERLAP]

Prints the table of docs/measurements/dust.md. Without LAYERS and OVERLAP the recipes' own dust
is used. Needs a Python with numpy.
"""

import os
import sys

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
sys.path.insert(0, os.path.join(ROOT, "blender_scripts"))
sys.dont_write_bytecode = True

from soilsig_blender.common import recipe  # noqa: E402
from soilsig_blender.common.errors import BedError  # noqa: E402
from soilsig_blender.dust import prototype  # noqa: E402

SHARES = (0.0, 0.2, 0.5)


def cell(packing, grain_class):
    """Silhouette and surface share, mean over the variants, and the layers of the first."""
    fines = prototype.model_fines(packing)
    wanted = [v for g, v in prototype.variants(packing) if g is grain_class]
    try:
        built = [prototype.build(grain_class, v, fines, packing) for v in wanted]
    except BedError as error:
        return f"does not fit: {error}"
    counts = [len(p.dust) for p in built]
    silhouette = np.mean([p.cover.silhouette(n) for p, n in zip(built, counts)])
    surface = np.mean([p.cover.surface(n) for p, n in zip(built, counts)])
    return f"{silhouette:.2f} {surface:.2f} {max(p.dust.layer.max() for p in built)}"


def main(arguments):
    print("Silhouette share, surface share, layers:\n")
    print("| recipe | grain | fines |", *(f"{share:.0%} 60 um |" for share in SHARES))
    print("|---|---|---|" + "---|" * len(SHARES))
    for tier in ("sparse", "less", "full"):
        _, packing = recipe.load(os.path.join(ROOT, "scenes", f"{tier}.json"))
        if arguments:
            packing["dust"] = {"layers": int(arguments[0]), "overlap": float(arguments[1])}
        for grain in packing["grains"]:
            cells = []
            for share in SHARES:
                packing["fines"][0]["share"], packing["fines"][1]["share"] = 1 - share, share
                cells.append(cell(packing, grain))
            row = " | ".join([tier, grain["name"], str(grain["fines"]), *cells])
            print(f"| {row} |", flush=True)


main(sys.argv[1:])
