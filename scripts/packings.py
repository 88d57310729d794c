"""Measures the spread between packings of one recipe, and the effect of the tray on them.

python3 scripts/packings.py SOILSIG SCENE.json PACKINGS [BIGGER_TRAY_UM]

Drops the packings, then traces them again: with other rims, without their lower grains, and with
bare lower grains. Prints the tables of docs/measurements/packings.md.
Needs nothing but Python's own library.
"""

import csv
import io
import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

BANDS_UM = (9.0, 11.0)
MEAN_DIAMETER_UM = 664.0
RIMS_UM = (0, 150, 300, 450, 600, 800)
DEPTHS = (0.5, 1.0, 1.5, 2.0)  # mean diameters below the surface
RAYS = ["--tolerance", "0.003", "--range", "9-11", "--step", "2"]
GROUP = 4
BARE = "bare.obj"


def main(soilsig, scene, packings, bigger_um=None):
    scene = json.loads(Path(scene).read_text())
    with tempfile.TemporaryDirectory() as folder:
        bed = Bed(soilsig, Path(folder))
        beds = bed.drop(scene, int(packings))
        print(f"\n## {scene['name']}, {len(beds)} packings\n")
        spread_table(beds, bed)
        rim_table(beds, bed)
        depth_table(beds, bed)
        dust_table(beds, bed)
        if bigger_um:
            bigger_table(scene, float(bigger_um), beds, bed)


class Bed:
    """Runs soilsig and reads what it writes."""

    def __init__(self, soilsig, folder):
        self.soilsig, self.folder = soilsig, folder

    def drop(self, scene, packings):
        """Placed scenes of so many packings."""
        folder = Path(tempfile.mkdtemp(dir=self.folder))
        recipe, out = folder / "recipe.json", folder / "out"
        recipe.write_text(json.dumps(scene))
        what = ["--scene", recipe, "--packings", packings, "--out", out, "--no-cache"]
        self.run("pipeline", *what, "--tolerance", 0.2)
        return [out / f"packings/{i + 1}/scene.json" for i in range(packings)]

    def emissivity(self, path, change=lambda placed: None):
        """Emissivity of a placed scene in each band, after a change to its geometry."""
        scene = json.loads(path.read_text())
        change(scene["geometry"]["placed"])
        changed, table = path.parent / "changed.json", path.parent / "changed_table.json"
        changed.write_text(json.dumps(scene))
        self.run("trace", changed, "--out", table, *RAYS)
        text = self.run("signature", table, "--range", "9-11", "--step", "2")
        return [float(row["emissivity"]) for row in csv.DictReader(io.StringIO(text))]

    def run(self, *arguments):
        command = [self.soilsig, *map(str, arguments)]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def row(*cells):
    print("|", " | ".join(cells), "|")


def mean_and_error(values):
    return statistics.fmean(values), statistics.stdev(values) / math.sqrt(len(values))


def differences(after, before):
    """The mean difference of two sets of beds in each band and its standard error, as text."""
    cells = []
    for new, old in zip(zip(*after), zip(*before)):
        mean, error = mean_and_error([a - b for a, b in zip(new, old)])
        cells.append(f"{mean:+.4f} +- {error:.4f}")
    return cells


def spread_table(beds, bed):
    values = [bed.emissivity(path) for path in beds]
    row("band", "mean", "standard deviation", f"intervals of {GROUP} packings that hold the rest")
    row(*["---"] * 4)
    for i, um in enumerate(BANDS_UM):
        column = [value[i] for value in values]
        held, groups = coverage(column)
        mean, spread = statistics.fmean(column), statistics.stdev(column)
        row(f"{um:g} um", f"{mean:.4f}", f"{spread:.4f}", f"{held} of {groups}")
    print()


def coverage(column):
    """How many 95 % intervals of groups of packings hold the mean of all other packings."""
    t = 3.182446  # Student, 3 degrees of freedom
    groups = [column[i : i + GROUP] for i in range(0, len(column) - GROUP + 1, GROUP)]
    held = 0
    for n, group in enumerate(groups):
        mean, error = mean_and_error(group)
        rest = [value for m, other in enumerate(groups) if m != n for value in other]
        truth, truth_error = mean_and_error(rest)
        held += abs(mean - truth) <= t * math.hypot(error, truth_error)
    return held, len(groups)


def rim_table(beds, bed):
    scene = json.loads(beds[0].read_text())
    domain = scene["geometry"]["placed"]["domain"]
    side = domain["min_um"][0] + domain["max_um"][0]
    widest = max(RIMS_UM)

    def cropped(rim):
        def change(placed):
            placed["domain"]["min_um"] = [rim, rim]
            placed["domain"]["max_um"] = [side - rim, side - rim]

        return change

    values = {rim: [bed.emissivity(path, cropped(rim)) for path in beds] for rim in RIMS_UM}
    row("rim left out, um", *(f"at {um:g} um, less that of {widest}" for um in BANDS_UM))
    row("---", *["---"] * len(BANDS_UM))
    for rim in RIMS_UM:
        same = ["0"] * len(BANDS_UM)
        row(f"{rim}", *(same if rim == widest else differences(values[rim], values[widest])))
    print()


def above(placed, depth):
    """The grains whose centres lie no deeper than so many mean diameters."""
    tops = sorted(i["transform"][11] for i in placed["instances"])
    # The upper decile of the grains' centres is taken for the surface.
    level = tops[int(0.9 * len(tops))] - depth * MEAN_DIAMETER_UM
    return [i for i in placed["instances"] if i["transform"][11] >= level]


def depth_table(beds, bed):
    """The change of the emissivity when the lower grains are taken away."""
    shares = {}

    def without(depth):
        def change(placed):
            placed["instances"], all_of_them = above(placed, depth), placed["instances"]
            shares.setdefault(depth, []).append(len(placed["instances"]) / len(all_of_them))
            used = {i["prototype"] for i in placed["instances"]}
            placed["prototypes"] = [p for p in placed["prototypes"] if p["name"] in used]

        return change

    whole = [bed.emissivity(path) for path in beds]
    row("depth kept, mean diameters", "grains kept", *(f"change at {um:g} um" for um in BANDS_UM))
    row(*["---"] * (2 + len(BANDS_UM)))
    for depth in DEPTHS:
        cut = [bed.emissivity(path, without(depth)) for path in beds]
        row(f"{depth:g}", f"{statistics.fmean(shares[depth]):.2f}", *differences(cut, whole))
    print()


def dust_table(beds, bed):
    """The change of the emissivity when the lower grains lose their fines."""
    shares = {}

    def bare_below(depth):
        def change(placed):
            dusty = above(placed, depth)
            shares.setdefault(depth, []).append(1 - len(dusty) / len(placed["instances"]))
            for instance in placed["instances"]:
                if instance not in dusty:
                    instance["prototype"] += "_bare"
            for prototype in list(placed["prototypes"]):
                name = prototype["name"]
                placed["prototypes"].append({**prototype, "name": name + "_bare", "file": BARE})

        return change

    for path in beds:
        without_fines(path.parent / "prototypes.obj", path.parent / BARE)
    whole = [bed.emissivity(path) for path in beds]
    row("bare below, mean diameters", "bare grains", *(f"change at {um:g} um" for um in BANDS_UM))
    row(*["---"] * (2 + len(BANDS_UM)))
    for depth in DEPTHS:
        bare = [bed.emissivity(path, bare_below(depth)) for path in beds]
        row(f"{depth:g}", f"{statistics.fmean(shares[depth]):.2f}", *differences(bare, whole))
    print()


def without_fines(prototypes, bare):
    """Writes prototypes with their first material alone, the grain's."""
    kept, materials = [], 0
    for line in prototypes.read_text().splitlines(keepends=True):
        if line.startswith("o "):
            materials = 0
        elif line.startswith("usemtl "):
            materials += 1
        if materials < 2 or not line.startswith("f "):
            kept.append(line)
    bare.write_text("".join(kept))


def bigger_table(scene, side_um, beds, bed):
    """The same recipe in a tray so wide that the walls do not affect its middle."""
    packing = scene["geometry"]["packing"]
    share = (side_um / packing["tray_um"][0]) ** 2
    wide = json.loads(json.dumps(scene))
    wide_packing = wide["geometry"]["packing"]
    wide_packing["tray_um"] = [side_um, side_um]
    for grain in wide_packing["grains"]:
        grain["count"] = round(grain["count"] * share)
    rim = 1.5 * packing["crop_um"] + 300
    wide_packing["crop_um"] = rim
    middles = bed.drop(wide, max(4, round(len(beds) / share)))
    there = [bed.emissivity(path) for path in middles]
    here = [bed.emissivity(path) for path in beds]
    print(f"Middle of a {side_um:g} um tray, {rim:g} um from its walls, less the bed above:")
    for i, um in enumerate(BANDS_UM):
        (a, ea), (b, eb) = (mean_and_error([v[i] for v in values]) for values in (there, here))
        print(f"{um:g} um: {a - b:+.4f} +- {math.hypot(ea, eb):.4f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
