"""How deep the bed is and how much of it is void.

The porosity below the surface includes the gaps at the walls and the floor and the hollows of the
surface. The interior porosity is what a soil's porosity means.
"""

import numpy as np

from ..common.randomness import stream
from .bed_check import mean_diameter_um

_POINTS = 4000  # on the surface of a prototype
_COLUMNS_PER_DIAMETER = 8
_PROBES = 10000  # points drawn in the bed's interior


def measure(prototypes, drop, packing):
    """Mean height of the bed's surface over the whole tray, and the void share below and inside."""
    tray = np.array(packing["tray_um"])
    columns = np.ceil(tray * _COLUMNS_PER_DIAMETER / mean_diameter_um(prototypes, drop)).astype(int)
    clouds = [_surface_points(p, stream(packing["seed"], "surface", p.name)) for p in prototypes]
    top = np.zeros(columns)
    for p, pose in zip(drop.prototype_of, drop.poses):
        points = clouds[p] @ pose[:3, :3].T + pose[:3, 3]
        cell = np.clip((points[:, :2] / tray * columns).astype(int), 0, columns - 1)
        np.maximum.at(top, (cell[:, 0], cell[:, 1]), points[:, 2])
    depth = float(top.mean())
    solid = sum(prototypes[p].volume_um3 for p in drop.prototype_of)
    return {
        "depth_um": depth,
        "depth_mean_diameters": depth / mean_diameter_um(prototypes, drop),
        "porosity": 1 - solid / (float(tray.prod()) * depth),
        "interior_porosity": _interior_porosity(prototypes, drop, packing, depth),
        "floor_seen": float((top == 0).mean()),
    }


def _interior_porosity(prototypes, drop, packing, depth):
    """Void share half a mean diameter from the walls and the floor, and one below the surface.

    None if the bed has no such place. Grains line up along a wall for half a diameter, and the
    surface undulates by as much.
    """
    diameter = mean_diameter_um(prototypes, drop)
    low = np.full(3, diameter / 2)
    high = np.array([*(np.array(packing["tray_um"]) - diameter / 2), depth - diameter])
    if (high <= low).any():
        return None
    points = low + (high - low) * stream(packing["seed"], "porosity").random((_PROBES, 3))
    solid = np.zeros(len(points), bool)
    pieces = [prototype.solids for prototype in prototypes]
    for p, pose in zip(drop.prototype_of, drop.poses):
        near = np.flatnonzero(
            np.linalg.norm(points - pose[:3, 3], axis=1) < pieces[p].radius,
        )
        solid[near] |= pieces[p].contain((points[near] - pose[:3, 3]) @ pose[:3, :3])
    return float(1 - solid.mean())


def _surface_points(prototype, rng):
    """Points drawn evenly over the surface."""
    corners = np.vstack([s.vertices[s.triangles] for s in prototype.surfaces])
    a, b, c = corners.transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1).cumsum()
    chosen = np.searchsorted(areas, rng.random(_POINTS) * areas[-1], side="right")
    chosen = np.minimum(chosen, len(areas) - 1)
    u, v = rng.random((2, _POINTS, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]
