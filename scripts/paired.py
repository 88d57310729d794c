"""Measures the effect of a change of a recipe on the emissivity, bed by bed.

python3 scripts/paired.py SOILSIG SCENE.json PACKINGS KEY=JSON[,KEY=JSON...] ...

Each argument is one change, such as drop.substeps=4 or dust.layers=8,dust.overlap=0, made to the
scene. Keys are those of its packing. Beds of one seed have the same input but for the change;
a drop is chaotic, so they still differ by chance. Prints a table of
docs/measurements/packings.md.
"""

import json
import statistics
import sys
import tempfile
from pathlib import Path

from packings import BANDS_UM, Bed, differences, mean_and_error, row


def main(soilsig, scene, packings, *changes):
    scene = json.loads(Path(scene).read_text())
    with tempfile.TemporaryDirectory() as folder:
        bed = Bed(soilsig, Path(folder))
        row("change", "drop, s", "interior porosity", *(f"at {um:g} um" for um in BANDS_UM))
        row(*["---"] * (3 + len(BANDS_UM)))
        before = measured(bed, scene, packings)
        row("none", *before[0], *(f"{mean_and_error(band)[0]:.4f}" for band in zip(*before[1])))
        for change in changes:
            after = measured(bed, changed(scene, change), packings)
            row(f"`{change}`", *after[0], *differences(after[1], before[1]))


def changed(scene, change):
    scene = json.loads(json.dumps(scene))
    for part in change.split(","):
        path, value = part.split("=")
        *above, key = path.split(".")
        place = scene["geometry"]["packing"]
        for name in above:
            place = place[name]
        place[key] = json.loads(value)
    return scene


def measured(bed, scene, packings):
    """Median time of a drop and mean porosity as text, and the emissivities of every bed."""
    paths = bed.drop(scene, int(packings))
    reports = [json.loads((path.parent / "drop.json").read_text()) for path in paths]
    seconds = statistics.median(report["timings_s"]["drop"] for report in reports)
    porosity = statistics.fmean(report["bed"]["interior_porosity"] for report in reports)
    return (f"{seconds:.1f}", f"{porosity:.3f}"), [bed.emissivity(path) for path in paths]


if __name__ == "__main__":
    main(*sys.argv[1:])
