"""Compares absorption in a heap of refractive grains with another program, photontracer.

    python3 scripts/photontracer_check.py SOILSIG PLACED-SCENE FOLDER

It needs numpy and photontracer 1.1, which traces complex indices and polarisation on the
processor. The grains of a placed scene are shrunk by 1.5 %, so that none overlap, and stand in the
open without a floor. Both programs give the share of light from above that they absorb, of five
indices and two sizes.
"""

import argparse
import itertools
import json
import subprocess
from pathlib import Path

import numpy as np
import photontracer as pt

INDICES = (1.5 + 0.01j, 2.2 + 0.02j, 3 + 0.1j, 0.6 + 0.002j, 1.2 + 0.1j)
SCALES = (0.05, 0.2)
SHRUNK = 0.985
UM = 9.0
RAYS = 100_000


def prototypes(scene, folder):
    """Vertices and triangles of each prototype, um."""
    meshes = {}
    for prototype in scene["geometry"]["placed"]["prototypes"]:
        vertices, faces, current = [], [], None
        for line in (folder / prototype["file"]).read_text().splitlines():
            word, *rest = line.split() or [""]
            if word == "v":
                vertices.append([float(x) for x in rest[:3]])
            elif word in ("o", "g"):
                current = " ".join(rest)
            elif word == "f" and prototype.get("object") in (None, current):
                corners = [int(corner.split("/")[0]) - 1 for corner in rest]
                faces += [[corners[0], a, b] for a, b in itertools.pairwise(corners[1:])]
        used, faces = np.unique(np.array(faces), return_inverse=True)
        meshes[prototype["name"]] = (np.array(vertices)[used], faces.reshape(-1, 3))
    return meshes


def transform(instance, scale):
    matrix = np.array(instance["transform"], float).reshape(3, 4)
    matrix[:, :3] *= SHRUNK * scale
    matrix[:, 3] *= scale
    return matrix


def by_photontracer(scene, meshes, scale, index):
    instances = scene["geometry"]["placed"]["instances"]
    names = list(meshes)
    matrices = np.array([transform(of, scale) for of in instances], np.float32)
    kinds = np.array([names.index(of["prototype"]) for of in instances], np.uint32)
    parts = [pt.MeshGeometry(v.astype(np.float32), f.astype(np.uint32)) for v, f in meshes.values()]
    simulation = pt.Simulation()
    ones = np.ones(len(instances), np.uint32)
    simulation.geometry = pt.InstanceGeometry(parts, matrices, kinds, ones)
    vacuum, grain = (pt.Material(pt.REFRACTIVE, complex(n)) for n in (1, index))
    simulation.materials = [vacuum, grain]
    simulation.wavelength_um = UM
    middle = matrices[:, :, 3].mean(axis=0)
    reach = np.abs(matrices[:, :2, 3] - middle[:2]).max() * 1.5
    origin = [float(middle[0]), float(middle[1]), float(matrices[:, 2, 3].max() + reach)]
    simulation.ray_generator = pt.ParallelRayGenerator(4 * RAYS, origin, [0, 0, -1], float(reach))
    simulation.max_scattering_count = 10_000
    outputs = pt.OutputType
    simulation.outputs = [outputs.RAY_STATE, outputs.SCATTERING_COUNT, outputs.STOKES_VECTOR]
    simulation.run()
    state = simulation.get_output_buffer(outputs.RAY_STATE)
    count = simulation.get_output_buffer(outputs.SCATTERING_COUNT)
    left = simulation.get_output_buffer(outputs.STOKES_VECTOR)[:, 0]
    met = (count > 0) | (state == 1)
    escaped = np.where(state == 0, left, 0)[met]
    return 1 - escaped.mean(), escaped.std() / np.sqrt(len(escaped))


def by_soilsig(soilsig, scene, source, folder, scale, index):
    axis = {"wavelength_um": [1, 100], "n": [index.real] * 2, "k": [index.imag] * 2}
    constants = {"title": "grain", "citation": "made up", "range_um": [2, 20]}
    constants["isotropic"] = {"table": axis}
    (folder / "constants.json").write_text(json.dumps(constants))
    scene = json.loads(json.dumps(scene))
    for material in scene["materials"]:
        material["spectrum"] = {"refractive": {"file": "constants.json"}}
    scene["view"] = {"zenith_deg": 0}
    placed = scene["geometry"]["placed"]
    placed.pop("domain")
    for prototype in placed["prototypes"]:
        prototype["file"] = str(source / prototype["file"])
    for instance in placed["instances"]:
        instance["transform"] = list(transform(instance, scale).ravel())
    (folder / "scene.json").write_text(json.dumps(scene))
    grid = ["--range", f"{UM}-{UM}", "--paths", str(RAYS)]
    for command in (
        ["trace", folder / "scene.json", "--out", folder / "table.json", *grid],
        ["signature", folder / "table.json", "--out", folder / "s.csv", "--range", f"{UM}-{UM}"],
    ):
        subprocess.run([soilsig, *map(str, command)], check=True, capture_output=True)
    header, row = (line.split(",") for line in (folder / "s.csv").read_text().split()[:2])
    found = dict(zip(header, row))
    return float(found["emissivity"]), float(found["emissivity_standard_error"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("soilsig")
    parser.add_argument("scene", type=Path)
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    scene, source = json.loads(given.scene.read_text()), given.scene.parent.resolve()
    meshes = prototypes(scene, source)
    print("| index | scale | photontracer | soilsig | difference | combined error |")
    print("|---|---|---|---|---|---|")
    for index in INDICES:
        for scale in SCALES:
            other, other_error = by_photontracer(scene, meshes, scale, index)
            soilsig = str(Path(given.soilsig).resolve())
            own, own_error = by_soilsig(soilsig, scene, source, given.folder, scale, index)
            error = np.hypot(other_error, own_error)
            cells = (other, own, own - other, error)
            print(f"| {index} | {scale} |", " | ".join(f"{x:.5f}" for x in cells), "|", flush=True)


if __name__ == "__main__":
    main()
