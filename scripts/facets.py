"""Measures the effect of the number of facets of grains and fines, in finished beds.

python3 scripts/facets.py SOILSIG PACKINGS

Drops the shipped bare and sparse beds. Replaces grains (bare) and fines (sparse) by grains of the
same seeds with fewer or more ribs, and traces the beds by the same paths. The beds are not settled
or checked again. Prints a table of docs/measurements/facets.md. Needs nothing but
Python's own library.
"""

import json
import sys
import tempfile
from pathlib import Path

from packings import BANDS_UM, Bed, differences, row

# Scene, the classes that are exchanged, their own number of ribs, the other numbers.
EXCHANGES = (("bare", "grains", 2, (0, 1)), ("sparse", "fines", 1, (0, 2)))


def main(soilsig, packings):
    with tempfile.TemporaryDirectory() as folder:
        bed = Bed(soilsig, Path(folder))
        row("ribs of", "own", "in their place", *(f"change at {um:g} um" for um in BANDS_UM))
        row(*["---"] * (3 + len(BANDS_UM)))
        for name, classes, own, others in EXCHANGES:
            scene = json.loads(Path(f"scenes/{name}.json").read_text())
            beds = bed.drop(scene, int(packings))
            before = [bed.emissivity(path) for path in beds]
            for ribs in others:
                for entry in scene["geometry"]["packing"][classes]:
                    entry["ribs"] = ribs
                after = [
                    bed.emissivity(path, prototypes_of(other))
                    for path, other in zip(beds, bed.drop(scene, int(packings)))
                ]
                row(f"{classes} ({name})", str(own), str(ribs), *differences(after, before))


def prototypes_of(other):
    """Replaces the prototypes by those of another bed, which have the same names."""

    def change(placed):
        for prototype in placed["prototypes"]:
            prototype["file"] = str(other.parent / prototype["file"])

    return change


if __name__ == "__main__":
    main(*sys.argv[1:])
