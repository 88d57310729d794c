"""Makes the atlas of failure: its figure, and the two tables of docs/measurements/stability.md.

python3 scripts/stability.py PATH-OF-SOILSIG [OPTIONS OF soilsig stress]
"""

import csv
import pathlib
import shutil
import subprocess
import sys

DOCS = pathlib.Path(__file__).resolve().parent.parent / "docs"
DATA = DOCS / "measurements" / "data"
TABLES = {
    "stability": ["what is swept", "unit", "it breaks", "the tool says so"],
    "stability_words": ["what is swept", "error of", "words", "what it does"],
}


def main(soilsig, *options):
    out = DOCS.parent / "out" / "stress"
    subprocess.run([soilsig, "stress", "--out", out, *options], check=True)
    shutil.copy(out / "atlas.png", DOCS / "figures" / "atlas.png")
    tables_of((out / "atlas.md").read_text())


def tables_of(atlas):
    """Splits the atlas' table into one of ranges and one of words."""
    rows = []
    for line in atlas.splitlines():
        if line.startswith("| **"):
            swept, error_of, breaks, says, words, does = line.strip("| ").split(" | ")
            what, _, unit = swept.partition("**: ")
            what = what.strip("*")
            rows.append(([what, unit, breaks, says], [what, error_of, words, does]))
    for (name, heading), table in zip(TABLES.items(), zip(*rows, strict=True), strict=True):
        with open(DATA / f"{name}.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([heading, *table])


if __name__ == "__main__":
    main(*sys.argv[1:])
