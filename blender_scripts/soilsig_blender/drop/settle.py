"""The drop: dusty grains fall into a tray as rigid bodies until they rest.

Bullet works best with lengths of a few units, so the mean grain diameter is made a few units long
(`scale`). Gravity is free to choose: a bed of hard grains with friction looks the same at any
length scale if time is scaled with its square root. Only the clock differs from that of the real
grains.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..common.errors import BedError
from ..common.randomness import shuffled, stream
from ..common.recipe import variant_count
from . import collision

_FRAME_RATE = 24  # Blender's own
_EARTH_M_S2 = 9.81
_RECORDED = 24


@dataclass(frozen=True)
class Drop:
    """Where the grains came to lie, and how they got there."""

    prototype_of: np.ndarray  # (N,) index of the prototype
    poses: np.ndarray  # (N, 4, 4) micrometres
    settled: bool
    frames: int  # of all phases
    top_speed: float  # sqrt(g d)
    mean_energy: float  # m g d
    unsupported: tuple  # mean and greatest movement over the sinking of an unsupported grain
    ceiling_um: float  # start of the highest grain: none can rise above it
    history: list  # (seconds since the release, (N, 4, 4) micrometres)
    hulls: np.ndarray | None  # poses at the rest of the hulls, before fines touched; else None


def drop(prototypes, packing, is_second_try=False) -> Drop:
    rng = stream(packing["seed"], "drop")
    prototype_of = _which(packing, rng)
    settings = packing["drop"]
    diameters = np.array([p.grain_class["diameter_um"] for p in prototypes])
    unit_um = diameters[prototype_of].mean() / settings["scale"]
    radii = np.array([np.linalg.norm(p.outline, axis=1).max() for p in prototypes])
    room = 2 * radii[prototype_of].max()
    if min(packing["tray_um"]) < room:
        x, y = packing["tray_um"]
        raise BedError(
            "scene",
            f"geometry.packing.tray_um: {x:g} x {y:g} is too narrow: the longest dusty grain needs "
            f"{room:.0f} um to turn in",
            "widen the tray",
        )
    places = _start_grid(radii[prototype_of], packing["tray_um"], rng)
    ceiling_um = places[:, 2].max() + radii.max()
    poses = np.zeros((len(places), 4, 4))
    poses[:, 3, 3] = 1
    for pose, place in zip(poses, places):
        pose[:3, :3], pose[:3, 3] = _random_turn(rng), place / unit_um
    tray = np.array(packing["tray_um"]) / unit_um
    height = 2 * ceiling_um / unit_um + tray.max()
    bed = (tray, height, unit_um, settings)
    fall = collision.drop_meshes if settings["collision"] == "mesh" else collision.drop_hulls
    rest = fall(prototypes, prototype_of, poses, *bed)
    frames, history, hulls = rest.frames, rest.history, None
    if rest.settled and settings["collision"] == "hull_then_fines":
        hulls = _in_um(rest.poses, unit_um)
        rest = collision.sink_into_contact(
            prototypes, prototype_of, rest.poses, *bed, is_second_try
        )
        frames += rest.frames
        history = history + rest.history[1:]
    return Drop(
        prototype_of,
        _in_um(rest.poses, unit_um),
        rest.settled,
        frames,
        rest.top_speed,
        rest.mean_energy,
        rest.unsupported,
        float(ceiling_um),
        _recorded(history, unit_um, settings["gravity"]),
        hulls,
    )


def _in_um(poses, unit_um):
    poses = poses.copy()
    poses[:, :3, 3] *= unit_um
    return poses


def _recorded(history, unit_um, gravity):
    """Some frames for pictures, even in the root of time: most of them while the grains fall."""
    seconds = 1 / _FRAME_RATE * np.sqrt(gravity * unit_um * 1e-6 / _EARTH_M_S2)
    last = len(history) - 1
    chosen = np.round(np.linspace(0, 1, _RECORDED) ** 2 * last).astype(int)
    record = []
    for frame in np.unique(chosen).tolist():
        record.append((frame * seconds, _in_um(history[frame], unit_um)))
    return record


def _which(packing, rng):
    """Prototype of every grain: the variants of a class in turn, the classes well mixed."""
    chosen, place = [], []
    first = 0
    for grain in packing["grains"]:
        count = grain["count"]
        variants = variant_count(packing, grain)
        chosen.append(first + np.arange(count) % max(variants, 1))
        # Each class is spread evenly, not at random: the classes on top are what is seen.
        place.append((np.arange(count) + rng.random(count)) / max(count, 1))
        first += variants
    chosen, place = np.concatenate(chosen), np.concatenate(place)
    return chosen[np.argsort(place, kind="stable")]


def _start_grid(radii, tray_um, rng):
    """Places on a jittered grid over the whole tray, level above level, spheres apart."""
    cell = 2.0 * radii.max()
    columns = np.maximum(1, np.floor(np.array(tray_um) / cell)).astype(int)
    sides = np.array(tray_um) / columns
    starts = np.empty((len(radii), 3))
    per_level = columns.prod()
    for first in range(0, len(radii), per_level):
        members = np.arange(first, min(first + per_level, len(radii)))
        cells = shuffled(rng, per_level)[: len(members)]
        corner = np.column_stack([cells % columns[0], cells // columns[0]]) * sides
        room = np.maximum(sides - 2 * radii[members, None], 0)
        low = corner + (sides - room) / 2
        starts[members, :2] = low + room * rng.random((len(members), 2))
        starts[members, 2] = cell * (first // per_level) + radii[members]
    return starts


def _random_turn(rng):
    """A rotation drawn evenly from all rotations."""
    a, b, c = rng.random(3)
    w, x, y, z = (
        np.sqrt(1 - a) * math.sin(2 * math.pi * b),
        np.sqrt(1 - a) * math.cos(2 * math.pi * b),
        np.sqrt(a) * math.sin(2 * math.pi * c),
        np.sqrt(a) * math.cos(2 * math.pi * c),
    )
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
