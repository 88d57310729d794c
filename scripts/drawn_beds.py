"""Draws beds of four recipes, and writes the emissivity of each: the beds of the test of plans.

python3 scripts/drawn_beds.py PROGRAM BEDS.csv CELLS.csv NUMBER

Recipes with fines are there as hulls and, from the same drops, with fines that touch. CELLS.csv
tells how much beds differ, and how much they do by the cells of single ones.
"""

import csv
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BANDS_UM = (8.0, 8.4, 9.03, 9.3, 10.0, 11.0, 12.0, 13.0)
# Recipe, and whether hulls keep its fines apart.
RECIPES = (("sparse", True), ("small", True), ("bare", False), ("quartz_sand", False))
TOUCHING = "geometry.packing.drop.collision=hull_then_fines"
# Student's t of the 15 degrees of freedom that the cells of a bed have, 95 %.
QUANTILE = 2.1314


def main(program, out, cells, beds):
    rows = [["recipe", "level", "bed", *BANDS_UM]]
    spreads = [["recipe", "band (um)", "mean", "spread between beds", "by the cells of one bed"]]
    with tempfile.TemporaryDirectory() as folder:
        for recipe, keeps_apart in RECIPES:
            for level in ("hulls", "touching")[: 1 + keeps_apart]:
                run = Path(folder, recipe, level)
                change = ["--set", TOUCHING] if level == "touching" else []
                scene = ROOT / "scenes" / f"{recipe}.json"
                arguments = ["pipeline", "--scene", scene, "--packings", beds, *change]
                soilsig(program, *arguments, "--tolerance", "0.0012", "--out", run)
                curves = [curve_of(program, run, bed) for bed in range(1, int(beds) + 1)]
                for bed, curve in enumerate(curves, 1):
                    rows.append([recipe, level, bed, *(f"{curve[um][0]:.5f}" for um in BANDS_UM)])
                if level == "hulls":
                    spreads.extend(spreads_of(recipe, curves))
    for path, lines in ((out, rows), (cells, spreads)):
        with Path(path).open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(lines)


def soilsig(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    # 4: rays or beds did not reach the tolerance, which one number for all beds cannot.
    if done.returncode not in (0, 4):
        sys.exit(f"soilsig {' '.join(map(str, arguments))}: {done.stderr}")


def curve_of(program, run, bed):
    """Emissivity of one bed, and the spread between beds by its cells, by wavelength."""
    table = run / "packings" / str(bed) / "table.json"
    files = [run / f"{name}{bed}.csv" for name in ("curve", "budget")]
    soilsig(program, "signature", table, "--out", files[0], "--budget", files[1])
    rows = [list(csv.DictReader(file.open())) for file in files]
    return {
        float(band["wavelength_um"]): (
            float(band["emissivity"]),
            float(budget["packings_half_width_95"]) / QUANTILE,
        )
        for band, budget in zip(*rows)
    }


def spreads_of(recipe, curves):
    for um in BANDS_UM:
        emissivities, by_cells = zip(*(curve[um] for curve in curves))
        spread = statistics.stdev(emissivities)
        by_cells = statistics.fmean(x * x for x in by_cells) ** 0.5
        numbers = (statistics.fmean(emissivities), spread, by_cells)
        yield [recipe, um, *(f"{number:.4f}" for number in numbers)]


if __name__ == "__main__":
    main(*sys.argv[1:])
