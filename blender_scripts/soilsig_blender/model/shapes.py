"""The five quartz shapes: crushed grains bounded by fracture surfaces, as under the microscope.

Quartz has no cleavage: it breaks along gently curved (conchoidal) surfaces that spread like a fan
from the point where the blow fell and meet one another in sharp arrises. A fracture is modelled as
a fan of planes: a middle one and ribs at its sides, each hinged a few degrees further on a line
through the point of the blow. Few fractures make a body angular, wear of its arrises rounds it.

The wanted descriptors are those of crushed and little-travelled quartz:

- Form: quartz grains of sediments have sphericities of .5 to 1, .75 on average, by their three
  diameters (Geol. Soc. Am. Bull. 66, 1075, 1955); (I S / L^2)^(1/3) is .70 to .83 here. They grow
  flatter with decreasing size, below 100 um above all (Krinsley and Smalley, Science 180, 1277,
  1973).
- Roundness: most sand has .3 to .4 (Folk, Petrology of Sedimentary Rocks, 1980), crushed sands the
  least of all (Zheng and Hryciw, J. Comput. Civ. Eng., doi 10.1061/(ASCE)CP.1943-5487.0000578,
  2016). Asked are Powers' "angular" (.17 to .25) and the lower half of "subangular" (.25 to .35).
- Sphericity: what convex bodies of this form and roundness have. Measured in three dimensions that
  of wind-blown sand is .85 (Minerals 12, 581, 2022).

Every body is convex, so its convexity (volume over that of its hull) is 1. Outlines of sand have .9
to .98 (Altuhafi and others, J. Geotech. Geoenviron. Eng. 139, 1290, 2013): hollows are left out.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from ..common.directions import fibonacci
from ..common.errors import BedError
from . import body_check
from .descriptors import elongation_and_flatness, feret_axes, roundness, sphericity
from .polyhedron import Polyhedron, intersect


@dataclass(frozen=True)
class Shape:
    """What a shape is to measure, and what it is modelled from."""

    scene_class: str  # of the shipped scenes: the seed of its bodies goes by this name
    diameter_um: float  # of that class; a scene gives its own
    elongation: float  # I/L
    flatness: float  # S/I
    sphericity: float  # Wadell
    roundness: float  # Wadell
    fractures: int  # fracture surfaces
    ribs: int  # at the sides of each, 0 to 2
    edge_radius: float  # of worn arrises, as a share of the volume-equivalent diameter

    @property
    def asked(self):
        """The descriptors that are asked for. A stretched shape may leave some of them open."""
        wanted = {name: getattr(self, name) for name in TOLERANCE}
        return {name: value for name, value in wanted.items() if value is not None}

    def with_ribs(self, ribs):
        """The same asked of bodies with so many ribs; None for the shape's own number."""
        return self if ribs is None else replace(self, ribs=ribs)


SHAPES = {
    "flake": Shape("fine_35", 35, 0.72, 0.66, 0.79, 0.23, 8, 1, 0.0),
    "chip": Shape("fine_60", 60, 0.74, 0.70, 0.80, 0.22, 8, 1, 0.0),
    "angular": Shape("grain_500", 500, 0.76, 0.76, 0.83, 0.24, 8, 2, 0.0),
    "subangular": Shape("grain_640", 640, 0.78, 0.80, 0.87, 0.27, 9, 2, 0.05),
    "worn": Shape("grain_853", 853, 0.82, 0.84, 0.90, 0.30, 10, 2, 0.10),
}

_EARLIER_NAMES = {shape.scene_class: name for name, shape in SHAPES.items()}


def known(name):
    """The name of a shape, which may be given by an earlier one; None if there is no such shape."""
    name = _EARLIER_NAMES.get(name, name)
    return name if name in SHAPES else None


def shape_of(entry):
    """The shape that a recipe names or, by elongation and flatness, stretches."""
    if isinstance(entry, str):
        return SHAPES[known(entry)]
    return replace(
        SHAPES[known(entry["like"])],
        elongation=entry["elongation"],
        flatness=entry["flatness"],
        sphericity=entry.get("sphericity"),
        roundness=None,
    )


# A body that misses a target by more than this is modelled anew.
TOLERANCE = {"elongation": 0.01, "flatness": 0.01, "sphericity": 0.03, "roundness": 0.05}
_ATTEMPTS = 100

# Random tilt of the fractures from an even spread over the sphere, and scatter of their distances
# from the centre (as shares).
_SCATTER = 0.28
_IRREGULARITY = 0.2
# The blow falls this far from the middle of the fracture (as a share of the distance from the
# centre). A rib's hinge leaves it this far (slope) from the line to the middle; the rib falls off
# by that slope.
_BLOW = (0.45, 0.75)
_SPREAD = (0.2, 0.5)
_TURN = (0.05, 0.10)
# Arrises wear where they turn by more than this (radians); ribs meet more gently.
_ARRIS = 0.4


def model(shape, diameter, rng) -> Polyhedron:
    """A body of this shape about its centroid, its volume that of a sphere of `diameter`.

    Its L, I and S lie along x, y and z.
    """
    for _ in range(_ATTEMPTS):
        body = _formed(intersect(*fractures(shape, rng)), shape)
        if shape.edge_radius > 0:
            body = _formed(_with_worn_arrises(body, shape.edge_radius), shape)
        reached = measure(body)
        if all(abs(reached[k] - v) <= TOLERANCE[k] for k, v in shape.asked.items()):
            body = body.scaled(diameter)
            body = body.moved(np.eye(3), -body.volume_and_centroid[1])
            body_check.check(body, "a modelled body")
            return body
    raise BedError(
        "scene",
        f"none of {_ATTEMPTS} bodies has the descriptors {shape.asked}; the last has {reached}",
        "ask for others in shapes.py: fewer fractures make a body less spherical and less round",
    )


def measure(body):
    """The descriptors of a body, by the names of what is asked, to six decimals."""
    elongation, flatness = elongation_and_flatness(body.outermost)
    return {
        "elongation": round(elongation, 6),
        "flatness": round(flatness, 6),
        "sphericity": round(sphericity(body), 6),
        "roundness": round(roundness(body), 6),
    }


def fractures(shape, rng):
    """Planes of the fans: normals and distances from the centre."""
    count = shape.fractures
    normals = fibonacci(count) + _SCATTER * (2 * rng.random((count, 3)) - 1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    distances = 1 + _IRREGULARITY * (2 * rng.random(count) - 1)
    along = np.cross(normals, 2 * rng.random((count, 3)) - 1)  # from the blow to the middle
    along /= np.linalg.norm(along, axis=1)[:, None]
    aside = np.cross(normals, along)
    blow = distances[:, None] * normals - _between(_BLOW, rng, count) * along
    planes = [normals]
    for side in (1, -1)[: shape.ribs]:
        spread, turn = _between(_SPREAD, rng, count), _between(_TURN, rng, count)
        across = side * aside - spread * along
        across /= np.linalg.norm(across, axis=1)[:, None]
        rib = normals + turn * across
        rib /= np.linalg.norm(rib, axis=1)[:, None]
        planes.append(rib)
        distances = np.concatenate([distances, np.einsum("ij,ij->i", rib, blow)])
    return np.vstack(planes), distances


def _between(limits, rng, count):
    return (limits[0] + (limits[1] - limits[0]) * rng.random(count))[:, None]


def _formed(body, shape):
    """The body stretched along its L, I and S to the form asked for, its volume that of a unit
    sphere's diameter."""
    wanted = np.array([1, shape.elongation, shape.elongation * shape.flatness])
    # Stretching changes which corners are farthest apart: the second time little is left to do.
    for _ in range(2):
        lengths, axes = feret_axes(body.vertices)
        body = body.moved(axes, np.zeros(3)).scaled(wanted * lengths[0] / lengths)
    return body.scaled(1 / equivalent_diameter(body.volume_and_centroid[0]))


def equivalent_diameter(volume):
    """Diameter of the sphere of this volume."""
    return (6 * volume / np.pi) ** (1 / 3)


def _with_worn_arrises(body, radius):
    """Every arris cut by the plane tangent to a rounding of this radius."""
    first, second, vertex = body.edges.T
    bisector = body.normals[first] + body.normals[second]
    length = np.linalg.norm(bisector, axis=1)
    bisector /= length[:, None]
    cosine = length / 2  # of half the angle between the two normals
    depth = radius * (1 / cosine - 1)
    offsets = np.einsum("ij,ij->i", bisector, body.vertices[vertex]) - depth
    worn = cosine < math.cos(_ARRIS / 2)
    return intersect(
        np.vstack([body.normals, bisector[worn]]), np.concatenate([body.offsets, offsets[worn]])
    )
