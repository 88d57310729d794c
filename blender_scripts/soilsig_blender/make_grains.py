"""The bodies of every shape without dust, and what they measure beside their targets."""

from .common.events import emit, progress
from .common.files import whole
from .common.randomness import stream
from .export import json_files, obj_files
from .export.report import versions
from .model import body_check
from .model.descriptors import RESOLUTION, feret_axes, roundness_class
from .model.shapes import SHAPES, TOLERANCE, measure, model


def make_grains(seed, variants, folder):
    bodies = {}
    shapes = []
    for name, shape in SHAPES.items():
        progress("model", len(shapes), len(SHAPES))
        entries = []
        for variant in range(variants):
            # As in the shipped scenes: the bodies are the same.
            purpose = "shape", shape.scene_class, variant
            body = model(shape, shape.diameter_um, stream(seed, *purpose))
            bodies[f"{name}_{variant}"] = body
            entries.append(_describe(f"{name}_{variant}", body))
        shapes.append(
            {
                "name": name,
                "diameter_um": shape.diameter_um,
                "asked": shape.asked,
                "bodies": entries,
            }
        )
    report = {
        "soilsig_grains": 1,
        "seed": seed,
        "versions": versions(),
        "tolerance": TOLERANCE,
        "roundness_resolution": RESOLUTION,
        "shapes": shapes,
    }
    with whole(folder, "grains.obj") as path:
        obj_files.write_bodies(path, bodies)
    with whole(folder, "grains.json") as path:
        json_files.write(path, report)
    emit("done", files=["grains.obj", "grains.json"])


def _describe(name, body):
    body_check.check(body, name)
    reached = measure(body)
    return {
        "name": name,
        "reached": reached,
        "roundness_class": roundness_class(reached["roundness"]),
        "feret_um": feret_axes(body.vertices)[0].tolist(),
        "volume_um3": body.volume_and_centroid[0],
        "facets": len(body.facets),
        "triangles": len(body.triangles),
        # `body_check` has refused all others.
        "checks": ["closed", "outward", "convex"],
    }
