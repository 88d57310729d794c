"""Kills a sweep of small beds at many moments, and checks what is left.

python3 scripts/kills.py PROGRAM KILLS SECONDS

Each run lives for 1 to SECONDS: with 3 on a quiet machine some beds are finished in between. Of
each kill: no finished bed is lost, and none is made twice. In the end the results are those of a
sweep that was not killed.
"""

import csv
import filecmp
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

STUDY = {
    "soilsig_study": 1,
    "name": "kills",
    "source": {"scene": os.path.abspath("scenes/small.json")},
    "axes": [
        {
            "name": "fines",
            "key": "geometry.packing.grains.grain_500.fines",
            "values": [0, 40, 80, 120],
        },
    ],
    "seeds": list(range(1, 26)),
    "tolerance": 0.05,
    "bands": {"from_um": 7.5, "to_um": 14, "step_um": 0.1},
}


def beds(out):
    """The tables that are there, with the times at which they were made."""
    found = {}
    for folder, _, names in os.walk(os.path.join(out, "beds")):
        if "table.json" in names and "/." not in folder[len(out) :]:
            found[folder] = os.stat(os.path.join(folder, "table.json")).st_mtime_ns
    return found


def drops(cache):
    """The beds in the cache with the times at which they were dropped, without unfinished ones."""
    found = {}
    for folder, _, names in os.walk(cache):
        if "drop.json" in names and "/." not in folder[len(cache) :]:
            found[folder] = os.stat(os.path.join(folder, "drop.json")).st_mtime_ns
    return found


def main(program, kills, longest_s):
    place = tempfile.mkdtemp(prefix="soilsig-kills-")
    study = os.path.join(place, "study.json")
    with open(study, "w") as file:
        json.dump(STUDY, file)

    def start(out, cache):
        env = {**os.environ, "SOILSIG_CACHE": os.path.join(place, cache)}
        command = [os.path.abspath(program), "sweep", study, "-o", os.path.join(place, out)]
        return subprocess.Popen(command, env=env, stderr=subprocess.DEVNULL)

    chance = random.Random(1)
    before = {}
    lost = 0
    done = 0
    for kill in range(kills):
        process = start("out", "cache")
        try:
            process.wait(timeout=chance.uniform(1, longest_s))
            done += 1
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
        tables = beds(os.path.join(place, "out"))
        dropped = drops(os.path.join(place, "cache"))
        now = {**tables, **dropped}
        lost += sum(now.get(bed) != made for bed, made in before.items())
        print(
            f"kill {kill + 1}: {len(dropped)} dropped, {len(tables)} traced, "
            f"{lost} lost or made twice",
            flush=True,
        )
        before = now
    start("out", "cache").wait()
    begin = time.monotonic()
    start("fresh", "fresh_cache").wait()
    print(f"a sweep that was not killed took {time.monotonic() - begin:.0f} s")
    same = True
    for name in ["results.csv", "beds.csv", "results.nc", "chart.svg"]:
        files = [os.path.join(place, out, name) for out in ["out", "fresh"]]
        same &= filecmp.cmp(*files, shallow=False)
    with open(os.path.join(place, "out", "beds.csv")) as file:
        number = len(list(csv.DictReader(file)))
    print(f"{number} beds, {lost} lost or made twice, results the same: {same}")
    sys.exit(0 if same and not lost and number == 100 else 1)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
