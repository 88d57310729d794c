"""Is the bed to be trusted? Grains that escaped, still move, or overlap."""

import numpy as np

from ..common.errors import BedError
from ..common.events import progress
from ..drop.rigid_bodies import REST_FRAMES, REST_MEAN, REST_WORST
from .distance import distance

# Grains whose dusty surfaces come closer than this share of the mean diameter are in contact.
CONTACT_SHARE = 0.03
# An overlap deeper than this share of the mean diameter is refused.
OVERLAP_SHARE = 0.02
# A bed floats if its lowest grain is higher above the floor than this share of the mean diameter.
FLOAT_SHARE = 0.03


def check(prototypes, drop, packing):
    """Raises `BedError` for a bed that is not to be trusted; returns what was found."""
    if not np.isfinite(drop.poses).all():
        lost = int((~np.isfinite(drop.poses)).any(axis=(1, 2)).sum())
        raise BedError(
            "nan",
            f"{lost} of {len(drop.poses)} grains have no finite position after frame {drop.frames}",
            "raise geometry.packing.drop.substeps",
        )
    escaped = _escaped(drop, packing["tray_um"])
    if len(escaped):
        i = escaped[0]
        x, y, z = drop.poses[i, :3, 3]
        raise BedError(
            "escaped",
            f"{len(escaped)} of {len(drop.poses)} grains left the tray by frame {drop.frames}, the "
            f"first of them a {prototypes[drop.prototype_of[i]].name} to "
            f"({x:.4g}, {y:.4g}, {z:.4g}) um",
            "raise geometry.packing.drop.substeps; scale 6.5, gravity 98.1 and margin 0.04 are "
            "known to work",
        )
    if not drop.settled:
        mean, worst = drop.unsupported
        raise BedError(
            "not_settled",
            f"after {drop.frames} frames grains still move, by {mean:.2f} (mean) and "
            f"{worst:.2f} (greatest) of what an unsupported grain sinks in a frame; "
            f"allowed are {REST_MEAN} and {REST_WORST}, for up to {REST_FRAMES} frames in a row",
            "raise geometry.packing.drop.max_frames",
        )
    found = _overlaps(prototypes, drop)
    lowest, found["wall_depth_um"] = _tray_depths(prototypes, drop, packing)
    found["floor_depth_um"], found["floor_gap_um"] = max(-lowest, 0.0), max(lowest, 0.0)
    mean_diameter = mean_diameter_um(prototypes, drop)
    limit = OVERLAP_SHARE * mean_diameter
    found["depth_limit_um"] = limit
    if found["max_depth_um"] > limit:
        raise BedError(
            "overlap",
            f"{found['overlapping']} of {found['contacts']} contacts overlap, by up to "
            f"{found['max_depth_um']:.1f} um; allowed are {limit:.1f} um",
            "raise geometry.packing.drop.substeps or iterations",
        )
    if max(found["floor_depth_um"], found["wall_depth_um"]) > limit:
        raise BedError(
            "sunk",
            f"grains sank {found['floor_depth_um']:.1f} um into the floor and "
            f"{found['wall_depth_um']:.1f} um into the walls; allowed are {limit:.1f} um",
            "raise geometry.packing.drop.substeps",
        )
    if lowest > FLOAT_SHARE * mean_diameter:
        raise BedError(
            "floating",
            f"the lowest grain stands {lowest:.1f} um off the floor; allowed are "
            f"{FLOAT_SHARE * mean_diameter:.1f} um",
            "lower geometry.packing.drop.margin or raise scale; 0.04 and 6.5 are known to work",
        )
    return {"escaped": 0, "overlaps": found}


def mean_diameter_um(prototypes, drop):
    return float(np.mean([prototypes[p].grain_class["diameter_um"] for p in drop.prototype_of]))


def _escaped(drop, tray_um):
    middle = drop.poses[:, :3, 3]
    out = (middle < 0).any(axis=1) | (middle[:, :2] > tray_um).any(axis=1)
    out |= middle[:, 2] > drop.ceiling_um
    return np.flatnonzero(out)


def _tray_depths(prototypes, drop, packing):
    """Height of the lowest point of all grains, and how far any of them is in a wall."""
    lowest, wall = np.inf, 0.0
    for p, pose in zip(drop.prototype_of, drop.poses):
        points = prototypes[p].outline @ pose[:3, :3].T + pose[:3, 3]
        low, high = points.min(axis=0), points.max(axis=0)
        lowest = min(lowest, low[2])
        wall = max(wall, -low[0], -low[1], *(high[:2] - packing["tray_um"]))
    return float(lowest), float(wall)


def _overlaps(prototypes, drop):
    reach = CONTACT_SHARE * mean_diameter_um(prototypes, drop)
    pieces = [prototype.solids for prototype in prototypes]
    pairs = _close_pairs(prototypes, drop, reach)
    contacts = overlapping = deep = 0
    deepest = 0.0
    gaps = []
    for done, (a, b) in enumerate(pairs):
        gap = distance(
            pieces[drop.prototype_of[a]], pieces[drop.prototype_of[b]], *drop.poses[[a, b]], reach
        )
        if gap < reach:
            contacts += 1
            gaps.append(max(gap, 0.0))
        if gap < 0:
            overlapping += 1
            deep += gap < -1
            deepest = max(deepest, -gap)
        if done % 50 == 0:
            progress("check", done, len(pairs))
    progress("check", len(pairs), len(pairs))
    return {
        "contacts": contacts,
        "contact_reach_um": reach,
        "median_gap_um": float(np.median(gaps)) if gaps else None,
        "overlapping": overlapping,
        "deeper_than_1_um": int(deep),
        "max_depth_um": float(deepest),
    }


def _close_pairs(prototypes, drop, reach):
    radii = np.array(
        [np.linalg.norm(prototypes[p].outline, axis=1).max() for p in drop.prototype_of]
    )
    middle = drop.poses[:, :3, 3]
    pairs = []
    for a in range(len(radii)):
        away = np.linalg.norm(middle[a + 1 :] - middle[a], axis=1)
        pairs += [
            (a, a + 1 + int(b)) for b in np.flatnonzero(away < radii[a] + radii[a + 1 :] + reach)
        ]
    return [(a, b) for a, b in pairs if not _outlines_apart(prototypes, drop, a, b, reach)]


def _outlines_apart(prototypes, drop, a, b, reach):
    """Whether a plane across one of a few directions keeps the outlines `reach` apart."""
    first, second = (
        prototypes[drop.prototype_of[i]].outline @ drop.poses[i, :3, :3].T + drop.poses[i, :3, 3]
        for i in (a, b)
    )
    towards = drop.poses[b, :3, 3] - drop.poses[a, :3, 3]
    towards /= np.linalg.norm(towards)
    for _ in range(8):
        ahead, behind = first @ towards, second @ towards
        if behind.min() - ahead.max() > reach:
            return True
        # The nearest points along this direction suggest a better one.
        better = second[np.argmin(behind)] - first[np.argmax(ahead)]
        towards = towards + 0.5 * better / max(np.linalg.norm(better), 1e-9)
        towards /= max(np.linalg.norm(towards), 1e-9)
    return False
