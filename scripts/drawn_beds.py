"""Draws beds of four recipes, and writes the emissivity of each: the beds of the test of plans.

python3 scripts/drawn_beds.py PROGRAM OUT.csv BEDS

Recipes with fines are there as hulls and, from the same drops, with fines that touch.
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BANDS_UM = (8.0, 8.4, 9.03, 9.3, 10.0, 11.0, 12.0, 13.0)
# Recipe, and whether hulls keep its fines apart.
RECIPES = (("sparse", True), ("less", True), ("bare", False), ("quartz_sand", False))
TOUCHING = "geometry.packing.drop.collision=hull_then_fines"


def main(program, out, beds):
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for recipe, keeps_apart in RECIPES:
            for level in ("hulls", "touching")[: 1 + keeps_apart]:
                run = Path(folder, recipe, level)
                change = ["--set", TOUCHING] if level == "touching" else []
                scene = ROOT / "scenes" / f"{recipe}.json"
                arguments = ["pipeline", "--scene", scene, "--packings", beds, *change]
                soilsig(program, *arguments, "--tolerance", "0.0012", "--out", run)
                for bed in range(1, int(beds) + 1):
                    curve = curve_of(program, run, bed)
                    rows.append([recipe, level, bed, *(f"{curve[um]:.5f}" for um in BANDS_UM)])
    with Path(out).open("w", newline="") as file:
        heading = ["recipe", "level", "bed", *BANDS_UM]
        csv.writer(file, lineterminator="\n").writerows([heading, *rows])


def soilsig(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    # 4: rays or beds did not reach the tolerance, which one number for all beds cannot.
    if done.returncode not in (0, 4):
        sys.exit(f"soilsig {' '.join(map(str, arguments))}: {done.stderr}")


def curve_of(program, run, bed):
    """Emissivity of one bed, by wavelength."""
    table = run / "packings" / str(bed) / "table.json"
    soilsig(program, "signature", table, "--out", run / f"bed{bed}.csv")
    with (run / f"bed{bed}.csv").open() as file:
        return {float(r["wavelength_um"]): float(r["emissivity"]) for r in csv.DictReader(file)}


if __name__ == "__main__":
    main(*sys.argv[1:])
