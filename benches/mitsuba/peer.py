"""A placed scene of soilsig in Mitsuba 3: the same meshes in the same places, seen alike.

Reads a job from standard input, one JSON object:

    scene         path of a placed scene with open sides and a floor
    zenith_deg    where the sensor stands, as in the scene's `view`
    azimuth_deg
    reflectances  for each band, the reflectance of each material in the scene's order
    pixels        side of the film, which covers the sensor's view
    samples       paths through each pixel
    seeds         a render for each
    rr_depth      bounces after which Mitsuba may end paths by Russian roulette; absent: never

Writes a line for each render: the mean over the film of the light of a sky of radiance 1, for each
band, and the CPU seconds of rendering alone; at the end the peak memory. The mean is one less the
bed's emissivity (Kirchhoff).
"""

import json
import resource
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")  # one path at a time with three bands; Embree finds its hits

BANDS = 3  # of a render
FLOOR_UM = 1e7  # half the floor's width: what it lacks to go on without end is below 1e-3 degrees
MAX_DEPTH = 1000


def read_obj(path):
    """Triangles of each object by the material's name: {object: {material: (n, 3, 3) array}}."""
    points, objects, name, material = [], {}, None, None
    for line in path.read_text().splitlines():
        key, *words = line.split() or [""]
        if key == "v":
            points.append([float(word) for word in words[:3]])
        elif key == "o":
            name = words[0]
        elif key == "usemtl":
            material = words[0]
        elif key == "f":
            corners = [int(word.split("/")[0]) - 1 for word in words]
            faces = objects.setdefault(name, {}).setdefault(material, [])
            faces.extend([corners[0], b, c] for b, c in pairwise(corners[1:]))
    points = np.array(points)
    return {o: {m: points[np.array(f)] for m, f in parts.items()} for o, parts in objects.items()}


def write_ply(path, triangles):
    vertices, corners = np.unique(
        triangles.reshape(-1, 3).astype("<f4"), axis=0, return_inverse=True
    )
    faces = np.empty(len(triangles), dtype=[("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, corners.reshape(-1, 3)
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())


def to_sensor(zenith_deg, azimuth_deg):
    zenith, azimuth = np.radians([zenith_deg, azimuth_deg])
    sin = np.sin(zenith)
    return np.array([sin * np.cos(azimuth), sin * np.sin(azimuth), np.cos(zenith)])


def sensor(domain, top_um, bottom_um, to, job):
    """The rectangle across the line of sight that covers the domain's box: `Footprint` in
    src/field.rs."""
    low = np.array([*domain["min_um"], bottom_um])
    high = np.array([*domain["max_um"], top_um])
    level = np.cross([0, 0, 1], to)
    length = np.linalg.norm(level)
    right = level / length if length > 1e-9 else np.array([1.0, 0, 0])
    up = np.cross(to, right)

    def reach(axis):
        return np.dot(high - low, np.abs(axis)) / 2

    # Far enough off to be above all that stands beyond the domain.
    away = 4 * (np.linalg.norm(high - low) + top_um - bottom_um) / max(to[2], 0.1)
    columns = [reach(right) * right, reach(up) * up, -to, (low + high) / 2 + away * to]
    matrix = np.eye(4)
    matrix[:3] = np.array(columns).T
    return {
        "type": "orthographic",
        "near_clip": away * 1e-6,
        "far_clip": away * 100,
        "to_world": mi.ScalarTransform4f(matrix),
        "film": {
            "type": "hdrfilm",
            "width": job["pixels"],
            "height": job["pixels"],
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "independent", "sample_count": job["samples"]},
    }


def build(job, folder):
    path = Path(job["scene"])
    scene = json.loads(path.read_text())
    placed = scene["geometry"]["placed"]
    domain = placed["domain"]
    if domain["sides"] != "open":
        sys.exit(f"{path}: mirror sides have no equal in Mitsuba")
    world = {
        "type": "scene",
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
    }
    world["integrator"] = {"type": "path", "max_depth": MAX_DEPTH}
    world["integrator"]["rr_depth"] = job.get("rr_depth") or MAX_DEPTH
    for number, material in enumerate(scene["materials"]):
        # Each another, or Mitsuba makes one of them.
        reflectance = {"type": "rgb", "value": 0.5 / (number + 1)}
        world[f"material {material['name']}"] = {
            "type": "twosided",
            "bsdf": {"type": "diffuse", "reflectance": reflectance},
        }
    files, heights = {}, {}
    for number, prototype in enumerate(placed["prototypes"]):
        file = path.parent / prototype["file"]
        objects = files.setdefault(file, None) or read_obj(file)
        files[file] = objects
        name = prototype["name"]
        group = {"type": "shapegroup"}
        parts = objects[prototype["object"]]
        for part, (material, triangles) in enumerate(parts.items()):
            mesh = folder / f"{number}_{part}.ply"
            write_ply(mesh, triangles)
            group[f"part{part}"] = {
                "type": "ply",
                "filename": str(mesh),
                "face_normals": True,
                "bsdf": {"type": "ref", "id": f"material {material}"},
            }
        world[f"group {name}"] = group
        heights[name] = np.unique(np.concatenate(list(parts.values())).reshape(-1, 3), axis=0)
    top_um, bottom_um = -np.inf, np.inf
    for number, instance in enumerate(placed["instances"]):
        matrix = np.eye(4)
        matrix[:3] = np.array(instance["transform"]).reshape(3, 4)
        z_um = heights[instance["prototype"]] @ matrix[2, :3] + matrix[2, 3]
        top_um, bottom_um = max(top_um, z_um.max()), min(bottom_um, z_um.min())
        world[f"instance{number}"] = {
            "type": "instance",
            "to_world": mi.ScalarTransform4f(matrix),
            "group": {"type": "ref", "id": f"group {instance['prototype']}"},
        }
    floor = domain["floor"]
    place = mi.ScalarTransform4f().translate([0, 0, floor["z_um"]]).scale([FLOOR_UM, FLOOR_UM, 1])
    bsdf = {"type": "ref", "id": f"material {floor['material']}"}
    world["floor"] = {"type": "rectangle", "to_world": place, "bsdf": bsdf}
    to = to_sensor(job["zenith_deg"], job["azimuth_deg"])
    top_um, bottom_um = max(top_um, floor["z_um"]), min(bottom_um, floor["z_um"])
    sides_um = np.subtract(domain["max_um"], domain["min_um"])
    room_um = 1e-3 * max(top_um - bottom_um, *sides_um)  # as `domain` in src/ingest/mod.rs
    world["sensor"] = sensor(domain, top_um + room_um, bottom_um - room_um, to, job)
    return mi.load_dict(world), [material["name"] for material in scene["materials"]]


def cpu_s():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def main():
    job = json.load(sys.stdin)
    with tempfile.TemporaryDirectory() as folder:
        scene, materials = build(job, Path(folder))
    params = mi.traverse(scene)
    bands = job["reflectances"]
    for seed in job["seeds"]:
        means, spent_s = [], 0.0
        for first in range(0, len(bands), BANDS):
            # The last group is filled up with its last band.
            group = (bands[first : first + BANDS] + [bands[-1]] * BANDS)[:BANDS]
            for number, name in enumerate(materials):
                params[f"material {name}.brdf_0.reflectance.value"] = [
                    band[number] for band in group
                ]
            params.update()
            started_s = cpu_s()
            image = np.array(mi.render(scene, seed=seed * 1009 + first))
            spent_s += cpu_s() - started_s
            means += image.reshape(-1, 3).mean(axis=0, dtype=np.float64).tolist()
        print(json.dumps({"means": means[: len(bands)], "cpu_s": spent_s}), flush=True)
    peak_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(json.dumps({"peak_memory_mb": peak_kb / 1024, "mitsuba": mi.__version__}))


main()
