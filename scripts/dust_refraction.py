"""Compares the paper's four covers by kinds of facets, library to refractive.

Writes the tables and the charts of docs/measurements/dust_refraction.md into FOLDER.

    python3 scripts/dust_refraction.py SOILSIG FOLDER

It needs numpy and Blender. The beds of each cover are dropped once, and all kinds of facets are
seen on the same beds. `inverted` facets are evaluated from the tables of `library`; `fresnel` and
`refractive` ones, by `quartz_zeidler`, are traced. `lifted` is refractive with each fine moved out
by 2 um, so that air is between it and its grain. `small` kinds are the same beds with all lengths
times 0.4: the fines then have the size of fine powders. The floor is the same in all. Results that
are already in FOLDER are used again.
"""

import argparse
import csv
import json

import numpy as np
from chemistry import Work
from refraction import scaled

COVERS = ("full", "less", "sparse", "bare")
TRACED = ("fresnel", "refractive", "lifted", "small refractive", "small lifted")
FACETS = ("library", "inverted", *TRACED)
GRID = ["--range", "7.5-14", "--step", "0.02"]
RANGES_UM = ((8.0, 9.5), (10.0, 12.0), (10.7, 12.0), (13.1, 14.0))
INVERTED = ("fine=inverted:quartz_fine", "coarse=inverted:quartz_coarse")
CONSTANTS = "quartz_zeidler"
LIFT_UM = 2.0
SMALL = 0.4


class Curves:
    """A curve of each packing."""

    def __init__(self, work, tables, *options):
        out = work.folder / "signature.csv"
        self.emissivity = []
        for table in tables:
            work.run("signature", table, *GRID, "--out", out, *options)
            with out.open() as file:
                rows = list(csv.DictReader(file))
            self.emissivity.append([float(row["emissivity"]) for row in rows])
        self.um = np.array([float(row["wavelength_um"]) for row in rows])
        self.emissivity = np.array(self.emissivity)

    def mean(self, within):
        """The mean over a range and its standard error, by the spread of the packings."""
        means = self.emissivity[:, self.inside(within)].mean(1)
        error = means.std(ddof=1) / np.sqrt(len(means)) if len(means) > 1 else np.nan
        return means.mean(), error

    def inside(self, within):
        return (within[0] - 1e-9 <= self.um) & (within[1] + 1e-9 >= self.um)


def beds(work, cover, packings):
    """The folders of the packings of a cover."""
    out = work.folder / cover
    what = ["--coverage", cover, "--packings", packings, "--tolerance", 0.02, *GRID]
    if not (out / "run.json").is_file():
        work.run("pipeline", *what, "--out", out)
    if packings == 1:
        return [out]
    return [out / f"packings/{i + 1}" for i in range(packings)]


def traced(work, bed, kind, paths):
    """The table of a bed whose grains and fines have other facets."""
    name = kind.replace(" ", "_")
    placed, table = bed / f"{name}.json", bed / f"{name}_table.json"
    if not table.is_file():
        scene = scaled(bed / "scene.json", SMALL if kind.startswith("small") else 1)
        floor = scene["geometry"]["placed"]["domain"]["floor"]
        for material in scene["materials"]:
            if material["name"] != floor["material"]:
                facets = "fresnel" if kind == "fresnel" else "refractive"
                material["spectrum"] = {facets: CONSTANTS}
        if kind.endswith("lifted"):
            for prototype in scene["geometry"]["placed"]["prototypes"]:
                prototype["file"] = lifted(bed / prototype["file"]).name
        placed.write_text(json.dumps(scene))
        work.run("trace", placed, "--out", table, "--paths", paths, *GRID)
    return table


def lifted(prototypes):
    """The prototypes with each fine moved away from the middle of its grain, as a file beside."""
    out = prototypes.with_name("lifted.obj")
    if out.is_file():
        return out
    lines = prototypes.read_text().splitlines()
    at, points, faces, is_fine = [], [], [], False
    for i, line in enumerate(lines):
        key, _, rest = line.partition(" ")
        if key == "v":
            at.append(i)
            points.append(rest.split())
        elif key == "usemtl":
            is_fine = rest == "fine"
        elif key == "f" and is_fine:
            faces.append([int(corner.split("/")[0]) - 1 for corner in rest.split()])
    points, faces = np.array(points, float), np.array(faces, int)
    if len(faces):
        # The least number of a vertex among all that are connected to it names each fine.
        name, before = np.arange(len(points)), None
        while before is None or (name != before).any():
            before = name.copy()
            least = name[faces].min(1)
            for corner in faces.T:
                np.minimum.at(name, corner, least)
        # Prototypes have their origin in the middle of the grain.
        vertices = np.unique(faces)
        _, fine, count = np.unique(name[vertices], return_inverse=True, return_counts=True)
        middle = np.stack([np.bincount(fine, points[vertices, i]) for i in range(3)], 1)
        middle /= count[:, None]
        points[vertices] += LIFT_UM * (middle / np.linalg.norm(middle, axis=1)[:, None])[fine]
    for i, point in zip(at, points):
        lines[i] = "v " + " ".join(f"{x:.9g}" for x in point)
    out.write_text("\n".join(lines) + "\n")
    return out


def write(file, rows):
    with file.open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("soilsig")
    parser.add_argument("folder")
    parser.add_argument("--packings", type=int, default=8)
    parser.add_argument("--paths", type=int, default=2048)
    given = parser.parse_args()
    work = Work(given.soilsig, given.folder)
    curves = {}
    for cover in COVERS:
        folders = beds(work, cover, given.packings)
        tables = [folder / "table.json" for folder in folders]
        spectra = [x for text in INVERTED for x in ("--spectrum", text)]
        curves["library", cover] = Curves(work, tables)
        curves["inverted", cover] = Curves(work, tables, *spectra)
        for kind in TRACED:
            # A bare grain has no fine to lift.
            of = kind.replace("lifted", "refractive") if cover == "bare" else kind
            tables = [traced(work, folder, of, given.paths) for folder in folders]
            curves[kind, cover] = Curves(work, tables)
        for kind in FACETS:
            means = [f"{m:.3f} ±{e:.3f}" for m, e in map(curves[kind, cover].mean, RANGES_UM)]
            print(kind, cover, *means, flush=True)
    head = ["facets", "cover"]
    for a, b in RANGES_UM:
        head += [f"{a:g}-{b:g}", f"± {a:g}-{b:g}"]
    rows = [head]
    for kind in FACETS:
        for cover in COVERS:
            curve = curves[kind, cover]
            cells = [f"{x:.4f}" for within in RANGES_UM for x in curve.mean(within)]
            rows.append([kind, cover, *cells])
    write(work.folder / "dust_refraction.csv", rows)
    um = curves["library", "bare"].um
    names = [f"{kind} {cover}" for kind, cover in curves]
    means = [curve.emissivity.mean(0) for curve in curves.values()]
    of_band = [[f"{x:g}", *(f"{e:.4f}" for e in column)] for x, *column in zip(um, *means)]
    write(work.folder / "dust_refraction_curves.csv", [["wavelength, um", *names], *of_band[::5]])
    for kind in FACETS:
        files = []
        for cover in COVERS:
            files.append(work.folder / f"{cover}, {kind}")  # the name is the label
            mean = curves[kind, cover].emissivity.mean(0)
            rows = [["wavelength_um", "emissivity"], *zip(um, np.round(mean, 5))]
            write(files[-1], rows)
        out = work.folder / f"dust_{kind}.png"
        work.run("spectra", "plot", *files, "--range", "9.6-14", "--out", out)


if __name__ == "__main__":
    main()
