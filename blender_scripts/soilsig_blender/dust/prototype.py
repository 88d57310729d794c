"""Dusty grains ready to be instanced: a grain and its fines about their common centre of mass."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..common.randomness import stream
from ..common.recipe import is_own, variant_count, whole_rounds
from ..model.own_grains import load, normalised
from ..model.polyhedron import volume_and_centroid
from ..model.shapes import model, shape_of
from .cover import Cover
from .dressing import Dust, FineClass, dress, seated_on_base
from .reduced_hull import reduced_hull
from .solids import DustySolids

# Different bodies of a class of fines. Each is seated many times, turned at random.
_FINE_BODIES = 4
# Tolerance of the outline's reach in every direction, as a share of the diameter.
_OUTLINE_SHARE = 1e-3


@dataclass(frozen=True)
class Surface:
    """Triangles of one material."""

    material: str
    vertices: np.ndarray
    triangles: np.ndarray


@dataclass(frozen=True)
class Prototype:
    """A dusty grain, micrometres, its centre of mass at the origin."""

    name: str
    grain_class: dict
    grain: object  # a Polyhedron or a HollowBody
    dust: Dust
    fines: tuple
    core: Surface
    coats: tuple  # Surfaces of the fines, one for each material
    volume_um3: float
    cover: Cover
    outline: np.ndarray  # (N, 3) the points its convex hull needs

    @property
    def surfaces(self):
        return (self.core, *self.coats)

    @cached_property
    def solids(self):
        return DustySolids.of(self)

    @property
    def triangle_count(self):
        return sum(len(surface.triangles) for surface in self.surfaces)


def model_fines(packing):
    """The fine classes of a recipe with their shapes."""
    return tuple(
        FineClass(
            fine["name"],
            fine["diameter_um"],
            fine["material"],
            fine["share"],
            *zip(
                *(
                    seated_on_base(_body(fine, i, packing))
                    for i in range(whole_rounds(_FINE_BODIES, fine["shape"]))
                )
            ),
        )
        for fine in packing["fines"]
    )


def _body(entry, variant, packing):
    """A variant of a class of grains or fines: modelled, or one of the user's own."""
    name = own_grain(entry, variant)
    if name is not None:
        return normalised(load(packing["library"], name), entry["diameter_um"])
    rng = stream(packing["seed"], "shape", entry["name"], variant)
    shape = shape_of(entry["shape"]).with_ribs(entry.get("ribs"))
    return model(shape, entry["diameter_um"], rng)


def own_grain(entry, variant):
    """The name of the user's own grain that a variant of a class is, or None."""
    shape = entry["shape"]
    return shape["library"][variant % len(shape["library"])] if is_own(shape) else None


def variants(packing):
    """Grain class and variant of every prototype; a class has no more variants than grains."""
    return [
        (grain, variant)
        for grain in packing["grains"]
        for variant in range(variant_count(packing, grain))
    ]


def build(grain_class, variant, fines, packing) -> Prototype:
    """Models one variant of a grain class and dresses it."""
    name, seed = f"{grain_class['name']}_{variant}", packing["seed"]
    grain = _body(grain_class, variant, packing)
    shares = grain_class.get("fine_shares")
    if shares:
        fines = tuple(replace(fine, share=shares.get(fine.name, 0.0)) for fine in fines)
    dust, cover = dress(grain, fines, grain_class["fines"], packing["dust"], seed, name)
    core = Surface(grain_class["material"], grain.vertices, grain.triangles)
    coats = coats_of(fines, dust)
    parts = [volume_and_centroid(s.vertices, s.triangles) for s in (core, *coats)]
    volume = sum(v for v, _ in parts)
    centre = sum(v * c for v, c in parts) / volume

    def centred(surface):
        return Surface(surface.material, surface.vertices - centre, surface.triangles)

    moved = Dust(dust.kind, dust.body, dust.rotation, dust.position - centre, dust.layer)
    surfaces = (centred(core), *map(centred, coats))
    points = np.vstack([surface.vertices for surface in surfaces])
    return Prototype(
        name,
        grain_class,
        grain.moved(np.eye(3), -centre),
        moved,
        fines,
        surfaces[0],
        surfaces[1:],
        volume,
        cover,
        reduced_hull(points, _OUTLINE_SHARE * grain_class["diameter_um"]),
    )


def coats_of(fines, dust):
    """The surfaces of a grain's fines, one for each material."""
    coats = []
    for material in dict.fromkeys(fine.material for fine in fines):
        vertices, triangles, count = [], [], 0
        for i in range(len(dust)):
            fine = fines[dust.kind[i]]
            if fine.material != material:
                continue
            body = fine.meshes[dust.body[i]]
            vertices.append(body.vertices @ dust.rotation[i].T + dust.position[i])
            triangles.append(body.triangles + count)
            count += len(body.vertices)
        if count:
            coats.append(Surface(material, np.vstack(vertices), np.vstack(triangles)))
    return tuple(coats)
