"""Dressing a grain with fines: facet on facet, no fine inside the grain.

The grain's facets are divided into cells of about the fine's size. Every cell is a seat.
A fine sits on its largest facet, flush with its host's facet, normal against normal, turned at
random. Where the grain has no free seat left for a fine, the fine goes into the next layer: on an
outer facet of a fine that has its seat.

Fines are seated one after another, and each depends only on those before it. So the fines of a
smaller count are the first of those of a larger count, and dust can be taken off step by step.
"""

from dataclasses import dataclass

import numpy as np

from ..common.arrays import Columns
from ..common.errors import BedError
from ..common.randomness import stream
from .clearance import Clearance
from .cover import measure
from .ground import Ground
from .seats import Pool, frames

# Where a cover is asked for, it is measured after this many fines, then after twice as many, and
# so on up to the most.
_FIRST_LOOK = 256
_MOST = 100_000
# Parallel lines from each side that measure a cover asked for.
_LINES = 128


@dataclass(frozen=True)
class FineClass:
    """Fines of one size class: a few shapes, each with its base at z = 0 and the rest above."""

    name: str
    diameter_um: float
    material: str
    share: float
    bodies: tuple
    meshes: tuple  # what is traced of each body: itself, or the hollow body in this envelope


@dataclass(frozen=True)
class Dust(Columns):
    """The fines of one grain in the order of seating."""

    kind: np.ndarray  # (N,) index of the fine class
    body: np.ndarray  # (N,) index of the shape within its class
    rotation: np.ndarray  # (N, 3, 3)
    position: np.ndarray  # (N, 3)
    layer: np.ndarray  # (N,) 1 on the grain itself


def seated_on_base(body):
    """The convex body of a fine and its mesh, the largest facet down, its centroid at the origin.

    A hollow fine sits on its envelope, and keeps others out of it.
    """
    around = body if body.is_convex else body.tight_envelope
    areas, centroids = around.facet_areas_and_centroids
    base = int(np.argmax(areas))
    rotation = frames(-around.normals[base][None], np.zeros(1))[0].T
    moved = around.moved(rotation, -rotation @ centroids[base])
    return moved, moved if around is body else body.moved(rotation, -rotation @ centroids[base])


def dress(grain, fines, wanted, settings, seed, label):
    """The dust of a grain and its cover.

    `wanted` is a number of fines, or `{"silhouette": share}` for the fewest that cover so much.
    """
    dressing = _Dressing(grain, fines, settings, seed, label)
    if not isinstance(wanted, dict):
        if not dressing.seat(wanted):
            raise dressing.refusal(
                f"of the {wanted} fines on {label} only {dressing.count} find a seat"
            )
        return dressing.dust, measure(grain, fines, dressing.dust)
    share, looked, more = wanted["silhouette"], 0, True
    while True:
        dust = dressing.dust
        cover = measure(grain, fines, dust, _LINES)
        count = cover.count_for(share)
        if count is not None:
            return dust[:count], cover
        if not more:
            raise dressing.refusal(
                f"of the silhouette of {label} no more than {cover.silhouette(len(dust)):.3f} "
                f"can be fines ({len(dust)} of them), not {share:g}"
            )
        looked = min(max(2 * looked, _FIRST_LOOK), _MOST)
        more = dressing.seat(looked) and looked < _MOST


class _Dressing:
    """Fines being seated on a grain, as many of each class as its share."""

    def __init__(self, grain, fines, settings, seed, label):
        self.layers = settings["layers"]
        self.shares = np.array([fine.share for fine in fines])
        self.given = np.zeros(len(fines))
        self.rows = []
        self.lacking = None
        self.pools = []
        if fines:
            ground = None if grain.is_convex else Ground(grain)
            self.clearance = Clearance(grain, fines, settings["overlap"], ground)
            self.pools = [
                Pool(grain, fines, kind, stream(seed, "dust", label, fine.name), ground)
                if fine.share > 0
                else None
                for kind, fine in enumerate(fines)
            ]

    @property
    def count(self):
        return len(self.rows)

    @property
    def dust(self):
        kind, body, rotation, position, layer = zip(*self.rows) if self.rows else [()] * 5
        return Dust(
            np.array(kind, int),
            np.array(body, int),
            np.array(rotation).reshape(-1, 3, 3),
            np.array(position).reshape(-1, 3),
            np.array(layer, int),
        )

    def seat(self, count):
        """Seats fines until there are so many; says whether that many found a seat."""
        while len(self.rows) < count:
            kind = int(np.argmax(self.shares * (len(self.rows) + 1) - self.given))
            pool = self.pools[kind]
            while (at := pool.take(self.clearance)) is None:
                if not pool.refill(self.dust, self.layers):
                    self.lacking = pool.fine.name
                    return False
            self.given[kind] += 1
            seats = pool.seats
            self.rows.append(
                (kind, seats.body[at], seats.rotation[at], seats.position[at], seats.layer[at])
            )
        return True

    def refusal(self, message):
        if self.lacking is None:
            hint = "ask for a smaller share, or for larger fines"
            return BedError("scene", f"{message}: {_MOST} fines are the most on a grain", hint)
        layers = "1 layer" if self.layers == 1 else f"{self.layers} layers"
        return BedError(
            "scene",
            f"{message}: no seat is left for a {self.lacking} in {layers}",
            "raise geometry.packing.dust.layers or overlap, or ask for fewer or smaller fines",
        )
