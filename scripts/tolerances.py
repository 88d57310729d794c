"""Measures the time and the error of runs within a tolerance, beside one bed from nothing.

python3 scripts/tolerances.py PATH-OF-SOILSIG SCENE OUT SEEDS TOLERANCE...

Prints the table of docs/measurements/tolerances.md: medians over seeds 1 to SEEDS. Every run starts
with an empty cache. Times are also given as ratios to that of one bed in the same seed. The
reference of a seed is the mean of the finest runs of all other seeds, whose beds are others.
"""

import csv
import json
import pathlib
import resource
import statistics
import subprocess
import sys
import time


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(soilsig, scene, out, seed, tolerance=None):
    command = [soilsig, "pipeline", "--scene", scene, "--no-cache", "--seed", str(seed)]
    command += ["--out", out, "--json"]
    command += [] if tolerance is None else ["--tolerance", str(tolerance)]
    wall, cpu = time.monotonic(), cpu_seconds()
    ended = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    wall, cpu = time.monotonic() - wall, cpu_seconds() - cpu
    if ended.returncode not in (0, 4):
        sys.exit(f"{' '.join(map(str, command))} failed with status {ended.returncode}")
    (reached,) = json.loads(ended.stdout)["reached"].values()
    with open(out / "signature.csv") as file:
        bands = list(csv.DictReader(file))
    return {
        "wall": wall,
        "cpu": cpu,
        "plan": reached["plan"]["by"] if tolerance else {"drops": 1, "pairs": 0},
        "total": reached["budget"]["total"],
        "emissivity": [float(band["emissivity"]) for band in bands],
        "totals": [float(band["emissivity_total_half_width_95"]) for band in bands],
    }


def row(name, runs, ones, references):
    def median(of):
        return statistics.median(map(of, range(len(runs))))

    def number(key):
        return median(lambda i: runs[i]["plan"][key])

    held = []
    for one, reference in zip(runs, references):
        bands = zip(one["emissivity"], reference or [], one["totals"])
        held += [abs(e - r) <= total for e, r, total in bands]
    return [
        name,
        f"{number('drops'):.0f}",
        f"{number('pairs'):.0f}",
        f"{median(lambda i: runs[i]['wall']):.1f}",
        f"{median(lambda i: runs[i]['wall'] / ones[i]['wall']):.1f}",
        f"{median(lambda i: runs[i]['cpu']):.0f}",
        f"{max(one['total'] for one in runs):.4f}",
        f"{sum(held) / len(held):.2f}" if held else "",
    ]


def main(soilsig, scene, out, seeds, tolerances):
    out = pathlib.Path(out)
    seeds = range(1, int(seeds) + 1)
    # The machine's speed drifts: the runs of a seed follow each other.
    one, runs = [], {tolerance: [] for tolerance in tolerances}
    for seed in seeds:
        one.append(run(soilsig, scene, out / f"one{seed}", seed))
        for t, of in runs.items():
            of.append(run(soilsig, scene, out / f"{t}-{seed}", seed, float(t)))
    finest = [each["emissivity"] for each in runs[min(tolerances, key=float)]]
    references = []
    for i in range(len(finest)):
        others = finest[:i] + finest[i + 1 :]
        references.append([statistics.fmean(band) for band in zip(*others)])
    heads = ["tolerance", "beds", "pairs", "wall s", "times one bed", "CPU s"]
    print(",".join([*heads, "widest total of any seed", "bands within their total"]))
    print(",".join(row("one bed", one, one, references)))
    for tolerance, of in runs.items():
        print(",".join(row(tolerance, of, one, references)))


if __name__ == "__main__":
    if len(sys.argv) < 6:
        sys.exit(__doc__)
    main(*sys.argv[1:5], sys.argv[5:])
