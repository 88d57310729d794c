"""The five quartz shapes: crushed grains bounded by fracture facets, as under the microscope.

Quartz has no cleavage: it breaks along gently curved (conchoidal) surfaces that meet in sharp
edges. A fracture is modelled as a plane and its ribs: planes tilted a little further that follow
the curve of the shell. Larger grains have travelled more: they are more equant and their edges
are more rounded; the fines are fresh splinters.
"""

from dataclasses import dataclass

import numpy as np

from .polyhedron import Polyhedron, intersect


@dataclass(frozen=True)
class Shape:
    """Descriptors of a shape; lengths as shares of its volume-equivalent diameter."""

    elongation: float  # intermediate / longest side of the bounding box
    flatness: float  # shortest / intermediate side
    fractures: int  # fracture surfaces
    ribs: int  # further facets that curve each fracture
    edge_radius: float  # of the rounding that the chamfer of an edge is tangent to
    irregularity: float  # scatter of the fractures' distances from the centre


SHAPES = {
    "fine_35": Shape(0.74, 0.72, 12, 0, 0.0, 0.22),
    "fine_60": Shape(0.78, 0.76, 13, 0, 0.0, 0.20),
    "grain_500": Shape(0.76, 0.80, 15, 1, 0.05, 0.17),
    "grain_640": Shape(0.80, 0.82, 17, 1, 0.08, 0.15),
    "grain_853": Shape(0.84, 0.86, 19, 1, 0.12, 0.13),
}

# Random tilt of the fractures from the even spread of a Fibonacci sphere.
_SCATTER = 0.28
# A rib turns by this angle (radians) at this share of the fracture's distance from the centre.
_RIB_TURN = (0.16, 0.34)
_RIB_REACH = (0.08, 0.30)


def model(shape, diameter, rng) -> Polyhedron:
    """A grain of this shape about its centroid, its volume that of a sphere of `diameter`."""
    normals, offsets = _fractures(shape, rng)
    body = intersect(normals, offsets)
    sides = np.ptp(body.vertices, axis=0)
    wanted = np.array([1.0, shape.elongation, shape.elongation * shape.flatness])
    body = _to_volume(body.scaled(wanted / sides), 1.0)
    if shape.edge_radius > 0:
        body = _with_rounded_edges(body, shape.edge_radius)
    body = _to_volume(body, diameter)
    return body.moved(np.eye(3), -body.volume_and_centroid[1])


def equivalent_diameter(volume):
    """Diameter of the sphere of this volume."""
    return (6 * volume / np.pi) ** (1 / 3)


def bounding_sides(body):
    """Sides of the bounding box in the frame the shape was modelled in, longest first."""
    return np.sort(np.ptp(body.vertices, axis=0))[::-1]


def _fractures(shape, rng):
    count = shape.fractures
    height = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    ring = np.sqrt(1 - height**2)
    normals = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
    normals += _SCATTER * (2 * rng.random((count, 3)) - 1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    offsets = 1 + shape.irregularity * (2 * rng.random(count) - 1)
    planes, distances = [normals], [offsets]
    for _ in range(shape.ribs):
        aside = np.cross(normals, 2 * rng.random((count, 3)) - 1)
        aside /= np.linalg.norm(aside, axis=1)[:, None]
        angle = _between(_RIB_TURN, rng, count)[:, None]
        reach = _between(_RIB_REACH, rng, count)[:, None]
        rib = np.cos(angle) * normals + np.sin(angle) * aside
        crest = offsets[:, None] * (normals + reach * aside)
        planes.append(rib)
        distances.append(np.einsum("ij,ij->i", rib, crest))
    return np.vstack(planes), np.concatenate(distances)


def _between(limits, rng, count):
    return limits[0] + (limits[1] - limits[0]) * rng.random(count)


def _with_rounded_edges(body, radius):
    """Every edge cut by the plane tangent to a rounding of this radius."""
    first, second, vertex = body.edges.T
    bisector = body.normals[first] + body.normals[second]
    length = np.linalg.norm(bisector, axis=1)
    bisector /= length[:, None]
    cosine = length / 2  # of half the angle between the two normals
    depth = radius * (1 / cosine - 1)
    offsets = np.einsum("ij,ij->i", bisector, body.vertices[vertex]) - depth
    return intersect(np.vstack([body.normals, bisector]), np.concatenate([body.offsets, offsets]))


def _to_volume(body, diameter):
    return body.scaled(diameter / equivalent_diameter(body.volume_and_centroid[0]))
