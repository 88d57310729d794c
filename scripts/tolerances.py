"""Measures the time and the error of planned runs of a scene; the finest run is the reference.

python3 scripts/tolerances.py PATH-OF-SOILSIG SCENE OUT TOLERANCE...

Prints the table of docs/measurements/tolerances.md. Every run starts with an empty cache. The error
is the largest of all bands. The finest run is judged by its own interval.
"""

import csv
import json
import pathlib
import resource
import subprocess
import sys
import time


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def planned(soilsig, scene, out, tolerance):
    command = [soilsig, "pipeline", "--scene", scene, "--packings", "auto", "--no-cache"]
    command += ["--tolerance", str(tolerance), "--out", out, "--json"]
    wall, cpu = time.monotonic(), cpu_seconds()
    run = subprocess.run(command, stdout=subprocess.PIPE)
    wall, cpu = time.monotonic() - wall, cpu_seconds() - cpu
    if run.returncode not in (0, 4):
        sys.exit(f"{' '.join(map(str, command))} failed with status {run.returncode}")
    record = json.loads(run.stdout)
    with open(out / "signature.csv") as file:
        bands = list(csv.DictReader(file))
    # Work of the pilots that is no part of the result: beds whose fines were kept apart.
    (reached,) = record["reached"].values()
    spent = sum(stage["seconds"] for stage in record["stages"] if not stage["cached"])
    stages, plan = record["stages"], reached["plan"]
    lost = stages[:2] if plan["touching"] else []
    return {
        "tolerance": tolerance,
        "emissivity": [float(band["emissivity"]) for band in bands],
        "um": [band["wavelength_um"] for band in bands],
        "wall": wall,
        "cpu": cpu,
        "lost": sum(stage["seconds"] for stage in lost) / spent,
        "reached": reached,
    }


def row(run, finest):
    reached, plan = run["reached"], run["reached"]["plan"]
    errors = [abs(a - b) for a, b in zip(run["emissivity"], finest["emissivity"])]
    worst = max(range(len(errors)), key=errors.__getitem__)
    return [
        f"{run['tolerance']:g}",
        str(plan["packings"]) + (", fines touch" if plan["touching"] else ""),
        f"{run['wall']:.0f}",
        f"{run['cpu']:.0f}",
        f"{100 * run['lost']:.0f} %",
        f"{reached['half_width']:.4f}",
        "-" if run is finest else f"{errors[worst]:.4f} at {run['um'][worst]} um",
    ]


def main(soilsig, scene, out, tolerances):
    out = pathlib.Path(out)
    runs = [planned(soilsig, scene, out / t, float(t)) for t in tolerances]
    finest = min(runs, key=lambda run: run["tolerance"])
    heads = [
        "tolerance",
        "packings",
        "wall, s",
        "CPU, s",
        "planning",
        "half-width reached",
        "off the finest by up to",
    ]
    print("| " + " | ".join(heads) + " |")
    print("|" + "---|" * len(heads))
    for run in runs:
        print("| " + " | ".join(row(run, finest)) + " |")


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:4], sys.argv[4:])
