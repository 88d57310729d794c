"""The placed scene and the report of the drop."""

import json


def write_scene(path, scene, packing, prototypes, prototype_of, poses):
    """The scene as read, with the places of all grains instead of its packing."""
    crop = packing["crop_um"]
    placed = {
        "prototypes": [
            {"name": p.name, "file": "prototypes.obj", "object": p.name} for p in prototypes
        ],
        "instances": [
            {"prototype": prototypes[p].name, "transform": pose[:3].ravel().tolist()}
            for p, pose in zip(prototype_of, poses)
        ],
        "domain": {
            "min_um": [crop, crop],
            "max_um": [side - crop for side in packing["tray_um"]],
            "sides": "mirror",
            "floor": {"z_um": 0.0, "material": packing["floor_material"]},
        },
    }
    write(path, {**scene, "geometry": {"placed": placed}})


def write_frames(path, packing, prototypes, drop):
    """Where the grains were at some times of the drop, in the scene's order."""
    digits = (6, 6, 6, 2)  # the turn's decimals, and a hundredth of a micrometre
    frames = [
        {
            "time_s": time_s,
            "transforms": [
                [round(x, d) for row in pose[:3].tolist() for x, d in zip(row, digits)]
                for pose in poses
            ],
        }
        for time_s, poses in drop.history
    ]
    names = [prototypes[p].name for p in drop.prototype_of]
    content = {
        "soilsig_frames": 1,
        "tray_um": packing["tray_um"],
        "prototypes": names,
        "frames": frames,
    }
    with open(path, "w", encoding="utf-8", newline="\n") as out:
        json.dump(content, out, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
        out.write("\n")


def write(path, content):
    with open(path, "w", encoding="utf-8", newline="\n") as out:
        json.dump(content, out, indent=1, ensure_ascii=False, allow_nan=False)
        out.write("\n")
