"""Counts how often the error budget holds, on random recipes and far finer references.

python3 scripts/budget.py SOILSIG RECIPES OUT.csv [SEED]

Each recipe is run with one packing and with four. The reference has REFERENCE packings of other
seeds. Its tray has twice the area, its bed is 1.5 times as deep, its rim is wider by 200 um, and
its rays have less noise. Writes a line for each recipe, run and band. Prints the
table of docs/measurements/budgets.md. Needs nothing but Python's own library.
"""

import csv
import json
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

BANDS_UM = ("8.2", "8.63", "9.03", "9.7", "11", "12.5")
GRID = ("--range", "8.2-12.5", "--step", "0.01")
PACKINGS = (1, 4)
REFERENCE = 8
TOLERANCE, REFERENCE_TOLERANCE = 0.01, 0.003
TERMS = ("rays_half_width_95", "packings_half_width_95", "rim", "floor", "given_up")
SHAPES = {"angular": 500, "subangular": 640, "worn": 853}
BUILTIN = ("quartz_fine", "quartz_medium", "quartz_coarse")
# Coarser than the default, and the same for all beds.
DROP = {"substeps": 3, "iterations": 15}
# The share of the tray's volume below the bed's surface that grains fill.
SOLID = 0.45
# Exit statuses: fines find no seat, or the bed is refused.
REFUSED, NOT_REACHED = (13, 16), 4


def main(soilsig, recipes, out, seed="1"):
    draws = random.Random(int(seed))
    scenes = [recipe(draws, number) for number in range(int(recipes))]
    Path(out).parent.mkdir(parents=True, exist_ok=True)
    with (
        tempfile.TemporaryDirectory() as folder,
        Path(out).open("w", newline="") as file,
        ThreadPoolExecutor(os.cpu_count()) as workers,
    ):
        writer = None
        rows, refused = [], 0
        for of_scene in workers.map(lambda s: judged(soilsig, s, Path(folder)), scenes):
            refused += not of_scene
            for line in of_scene:
                writer = writer or csv.DictWriter(file, line)
                if not rows:
                    writer.writeheader()
                writer.writerow(line)
                rows.append(line)
            file.flush()
            print(f"{len(rows)} lines", file=sys.stderr)
    print_tables(rows, refused)


def recipe(draws, number):
    """A scene of 15 to 30 grains that lie two to three of their diameters deep."""
    shapes = draws.sample(sorted(SHAPES), draws.randint(1, 3))
    diameters = [SHAPES[shape] * draws.uniform(0.75, 1.25) for shape in shapes]
    count = draws.randint(15, 30)
    counts = [count // len(shapes) + (i < count % len(shapes)) for i in range(len(shapes))]
    # Few fines more often than many, which take long.
    fines = round(250 * draws.random() ** 2)
    coarse_share = round(draws.random(), 2)
    volume = sum(n * math.pi / 6 * d**3 for n, d in zip(counts, diameters))
    mean = sum(n * d for n, d in zip(counts, diameters)) / count
    tray = math.sqrt(volume / (SOLID * draws.uniform(2, 3) * mean))
    kind = draws.choice(("builtin", "constant", "inverted"))
    grain, fine, floor = (spectrum(draws, kind) for _ in range(3))
    return {
        "soilsig_scene": 1,
        "name": f"recipe_{number}",
        "seed": 1000 * number + 1,
        "temperature_k": 300,
        "view": {"zenith_deg": draws.uniform(0, 50), "azimuth_deg": draws.uniform(0, 360)},
        "materials": [
            {"name": "fine", "spectrum": fine},
            {"name": "coarse", "spectrum": grain},
            {"name": "floor", "spectrum": floor},
        ],
        "geometry": {
            "packing": {
                "seed": 1000 * number + 1,
                "grains": [
                    {
                        "name": f"grain_{SHAPES[shape]}",
                        "shape": shape,
                        "diameter_um": diameter,
                        "material": "coarse",
                        "count": n,
                        "fines": fines,
                    }
                    for shape, diameter, n in zip(shapes, diameters, counts)
                ],
                "fines": [
                    {
                        "name": f"fine_{um}",
                        "shape": shape,
                        "diameter_um": um,
                        "material": "fine",
                        "share": share,
                    }
                    for shape, um, share in (
                        ("flake", 35, round(1 - coarse_share, 2)),
                        ("chip", 60, coarse_share),
                    )
                ],
                "dust": {"layers": draws.randint(1, 4), "overlap": draws.choice((0, 0.5, 1))},
                "variants": draws.randint(1, 2),
                "tray_um": [tray, tray],
                "crop_um": draws.uniform(0.08, 0.25) * tray,
                "floor_material": "floor",
                "drop": DROP,
            }
        },
    }


def spectrum(draws, kind):
    if kind == "constant":
        return {"constant": round(draws.uniform(0.4, 0.98), 3)}
    powder = {"builtin": draws.choice(BUILTIN)}
    return powder if kind == "builtin" else {"inverted": {"spectrum": powder}}


def finer(scene):
    """The recipe with a wider tray, a deeper bed, a wider rim and other seeds."""
    scene = json.loads(json.dumps(scene))
    packing = scene["geometry"]["packing"]
    packing["tray_um"] = [math.sqrt(2) * side for side in packing["tray_um"]]
    packing["crop_um"] += 200
    for grains in packing["grains"]:
        grains["count"] *= 3
    packing["seed"] += 500
    scene["seed"] += 500
    return scene


def judged(soilsig, scene, folder):
    """A line for each run and band; no line if a bed was refused."""
    folder = folder / scene["name"]
    folder.mkdir()
    reference = run(soilsig, finer(scene), REFERENCE, REFERENCE_TOLERANCE, folder / "reference")
    runs = {n: run(soilsig, scene, n, TOLERANCE, folder / str(n)) for n in PACKINGS}
    if not (reference and all(runs.values())):
        return []
    return [
        {
            "scene": scene["name"],
            "packings": n,
            "wavelength_um": um,
            "emissivity": bands[um]["emissivity"],
            "reference": reference[um]["emissivity"],
            "reference_half_width_95": reference[um]["emissivity_half_width_95"],
            "total_half_width_95": bands[um]["total_half_width_95"],
            **{term: bands[um][term] for term in TERMS},
        }
        for n, bands in runs.items()
        for um in BANDS_UM
    ]


def run(soilsig, scene, packings, tolerance, out):
    """The columns of a run's signature and budget for each band."""
    file = out.with_suffix(".json")
    file.write_text(json.dumps(scene))
    what = ["--scene", file, "--packings", packings, "--tolerance", tolerance, "--out", out]
    command = [soilsig, "pipeline", *what, *GRID, "--no-cache", "--threads", 1]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode in REFUSED:
        return None
    if done.returncode not in (0, NOT_REACHED):
        sys.exit(done.stderr)
    bands = {}
    for name in ("signature.csv", "budget.csv"):
        for line in csv.DictReader((out / name).open()):
            if line["wavelength_um"] in BANDS_UM:
                bands.setdefault(line["wavelength_um"], {}).update(
                    {key: float(value or 0) for key, value in line.items()}
                )
    return bands


def print_tables(rows, refused):
    scenes = len({line["scene"] for line in rows})
    print(f"{scenes} recipes, {refused} more refused; {REFERENCE} packings as reference\n")
    row("packings", "bands", "scenes by their widest band", "abs(error) / total", "mean error")
    row(*["---"] * 5)
    for n in PACKINGS:
        mine = [line for line in rows if line["packings"] == n]
        by_scene = {}
        for line in mine:
            by_scene.setdefault(line["scene"], []).append(line)
        shares = [statistics.fmean(map(holds, lines)) for lines in by_scene.values()]
        widest = [max(lines, key=total) for lines in by_scene.values()]
        held = sum(map(holds, widest))
        ratio = statistics.fmean(abs(error(line)) / total(line) for line in mine)
        errors = [statistics.fmean(map(error, lines)) for lines in by_scene.values()]
        row(
            str(n),
            f"{100 * statistics.fmean(shares):.1f} +- {100 * half_width(shares):.1f} %",
            "{} of {} ({:.1f} to {:.1f} %)".format(held, scenes, *wilson(held, scenes)),
            f"{ratio:.2f}",
            f"{statistics.fmean(errors):+.4f} +- {half_width(errors):.4f}",
        )
    print("\nMean share of the total that each part has, in the widest band:\n")
    row("packings", "total", *(term.removesuffix("_half_width_95") for term in TERMS))
    row(*["---"] * (2 + len(TERMS)))
    for n in PACKINGS:
        by_scene = {}
        for line in rows:
            if line["packings"] == n:
                by_scene.setdefault(line["scene"], []).append(line)
        widest = [max(lines, key=total) for lines in by_scene.values()]
        parts = [statistics.fmean(line[term] / total(line) for line in widest) for term in TERMS]
        mean = statistics.fmean(map(total, widest))
        row(str(n), f"{mean:.4f}", *(f"{100 * part:.1f} %" for part in parts))


def error(line):
    return line["emissivity"] - line["reference"]


def total(line):
    return line["total_half_width_95"]


def holds(line):
    """Whether the reference is within the budget and its own uncertainty."""
    return abs(error(line)) <= math.hypot(total(line), line["reference_half_width_95"])


def half_width(of_scenes):
    return 1.96 * statistics.stdev(of_scenes) / math.sqrt(len(of_scenes))


def wilson(held, n):
    """Ends of Wilson's 95 % interval of a share, per cent."""
    z2 = 1.96**2
    middle, half = held + z2 / 2, 1.96 * math.sqrt(held * (n - held) / n + z2 / 4)
    return 100 * (middle - half) / (n + z2), 100 * (middle + half) / (n + z2)


def row(*cells):
    print("|", " | ".join(cells), "|")


if __name__ == "__main__":
    main(*sys.argv[1:])
