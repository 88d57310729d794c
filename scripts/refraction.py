"""Compares beds whose grains let light through with measured quartz powders.

Writes the table of docs/measurements/refraction.md and its curves into FOLDER.

    python3 scripts/refraction.py SOILSIG FOLDER LIBRARY-FILE...

It needs numpy. LIBRARY-FILEs are those of scripts/chemistry.py, sample TS-1A or TS-1B. Beds of
crushed quartz that touch, seven diameters deep, are dropped once. Each is scaled to a Sauter
diameter and traced with opaque and with refractive facets by `quartz_zeidler`. Nothing is fitted.
Results that are already in FOLDER are used again.
"""

import argparse
import csv
import json
from pathlib import Path

import chemistry
import numpy as np
from chemistry import Measured, Work

RANGES_UM = ((7.5, 12.0), (8.0, 9.5), (9.5, 12.2), (10.0, 12.0), (13.1, 14.0), (7.3, 14.0))
UM = np.round(np.arange(7.3, 14.0001, 0.02), 2)
# Sauter diameters of the library's fractions, um: named before anything was traced.
SIZES_UM = {"fine": (12, 16, 20), "medium": (52, 70, 88), "coarse": (225, 300, 375)}
# Of equal-volume spheres: sum n d^3 / sum n d^2 over the three classes.
BED_UM = 327
FACETS = ("fresnel", "refractive")


def deeper(packing):
    for grains in packing["grains"]:
        grains["count"] *= 2


def touching(packing):
    packing["drop"] = {}
    deeper(packing)


# The shipped sand keeps its grains apart, as fine powders are poured.
BEDS = {"touching": touching, "loose": deeper}


def scaled(placed, factor):
    """A placed scene with all lengths times a factor."""
    scene = json.loads(placed.read_text())
    bed = scene["geometry"]["placed"]
    for prototype in bed["prototypes"]:
        prototype["unit_um"] = factor * prototype.get("unit_um", 1)
    for instance in bed["instances"]:
        for i in (3, 7, 11):
            instance["transform"][i] *= factor
    domain = bed["domain"]
    for key in ("min_um", "max_um"):
        domain[key] = [factor * x for x in domain[key]]
    domain["floor"]["z_um"] *= factor
    return scene


def table(work, placed, kind, size_um, paths):
    name = f"{kind}_{size_um}"
    out = placed.with_name(f"{name}_table.json")
    if not out.is_file():
        scene = scaled(placed, size_um / BED_UM)
        scene["materials"][0]["spectrum"] = {kind: "quartz_zeidler"}
        file = placed.with_name(f"{name}.json")
        file.write_text(json.dumps(scene))
        grid = ["--range", "7.3-14", "--step", "0.02"]
        work.run("trace", file, "--out", out, "--paths", paths, *grid)
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("soilsig")
    parser.add_argument("folder")
    parser.add_argument("library", nargs="+", type=Path)
    parser.add_argument("--packings", type=int, default=16)
    parser.add_argument("--paths", type=int, default=2048)
    parser.add_argument("--bed", choices=BEDS, default="touching")
    parser.add_argument("--sizes", choices=("all", "middle"), default="all")
    given = parser.parse_args()
    chemistry.UM = UM
    work = Work(given.soilsig, given.folder)
    beds = work.drop(f"sand_{given.bed}_deep", BEDS[given.bed], given.packings)
    curves, errors_of = [], []
    for measured in map(Measured, given.library):
        sizes = SIZES_UM[measured.size]
        for size in sizes if given.sizes == "all" else sizes[1:2]:
            for kind in FACETS:
                tables = [table(work, bed, kind, size, given.paths) for bed in beds]
                out = Path(given.folder) / "refraction.csv"
                grid = ["--range", "7.3-14", "--step", "0.02", "--out", out]
                work.run("signature", *tables, *grid)
                with out.open() as file:
                    bands = list(csv.DictReader(file))
                emissivity = np.array([float(band["emissivity"]) for band in bands])
                valid = np.array([band["valid"] == "1" for band in bands])
                errors = [f"{measured.rms(emissivity, within):.3f}" for within in RANGES_UM]
                held = measured.rms(emissivity, (7.3, 14.0), valid)
                errors += [f"{held:.3f}" if valid.any() else "", f"{100 * valid.mean():.0f} %"]
                which = [measured.sample, measured.size, size, kind]
                errors_of.append([*which, *errors])
                curves.append([*which, *np.round(emissivity, 4)])
                print(*which, *errors, flush=True)
    head = ["sample", "size", "diameter, um", "facets"]
    ranges = [f"{a}-{b}" for a, b in RANGES_UM]
    for name, columns, rows in (
        ("rms", [*ranges, "valid bands", "share"], errors_of),
        ("curves", UM, curves),
    ):
        with (Path(given.folder) / f"refraction_{name}.csv").open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([[*head, *columns], *rows])


if __name__ == "__main__":
    main()
