"""Dressing a grain with fines: facet on facet, none sinking into another.

The grain's facets are subdivided into cells of about the fine's size, and every cell is a seat.
A fine sits on its largest facet, flush with its host's facet, normal against normal, turned at
random. Where the grain has no free seat left for a fine, it is seated in the next layer, on an
outer facet of a fine that sits already.

Fines are seated one after another, each looking only at those before it. So the fines of a
smaller count are the first of those of a larger one, and dust can be taken off step by step.
"""

from dataclasses import dataclass

import numpy as np

from .clearance import Clearance
from .errors import BedError
from .polyhedron import Polyhedron
from .randomness import stream
from .seats import Pool, frames

# No more layers than this.
_MOST_LAYERS = 8


@dataclass(frozen=True)
class FineClass:
    """Fines of one size class: a few shapes, each with its base at z = 0 and the rest above."""

    name: str
    diameter_um: float
    material: str
    share: float
    bodies: tuple


@dataclass(frozen=True)
class Dust:
    """The fines of one grain in the order of seating."""

    kind: np.ndarray  # (N,) index of the fine class
    body: np.ndarray  # (N,) index of the shape within its class
    rotation: np.ndarray  # (N, 3, 3)
    position: np.ndarray  # (N, 3)
    layer: np.ndarray  # (N,) 1 on the grain itself

    def __len__(self):
        return len(self.kind)

    def put(self, i, kind, seats, seat):
        """Seats fine `i`."""
        self.kind[i], self.body[i], self.layer[i] = kind, seats.body[seat], seats.layer[seat]
        self.rotation[i], self.position[i] = seats.rotation[seat], seats.position[seat]


def seated_on_base(body: Polyhedron) -> Polyhedron:
    """The body with its largest facet down, that facet's centroid at the origin."""
    areas, centroids = body.facet_areas_and_centroids
    base = int(np.argmax(areas))
    rotation = frames(-body.normals[base][None], np.zeros(1))[0].T
    return body.moved(rotation, -rotation @ centroids[base])


def share_out(shares, count):
    """Classes of the first `count` fines; each prefix is as near the shares as can be."""
    given = np.zeros(len(shares))
    order = np.empty(count, int)
    for i in range(count):
        order[i] = np.argmax(shares * (i + 1) - given)
        given[order[i]] += 1
    return order


def dress(grain: Polyhedron, fines, count, seed, label) -> Dust:
    """Seats `count` fines on the grain."""
    dust = _empty(count)
    if not count:
        return dust
    clearance = Clearance(grain, fines)
    pools = [
        Pool(grain, fines, kind, stream(seed, "dust", label, fine.name))
        for kind, fine in enumerate(fines)
    ]
    for done, kind in enumerate(share_out(np.array([fine.share for fine in fines]), count)):
        pool = pools[kind]
        while (seat := pool.take(clearance)) is None:
            if not pool.refill(dust, done, _MOST_LAYERS):
                raise BedError(
                    "scene",
                    f"only {done} of the {count} fines find a seat on {label} in "
                    f"{_MOST_LAYERS} layers: a {pool.fine.name} has none",
                    "ask for fewer or smaller fines",
                )
        dust.put(done, kind, pool.seats, seat)
    return dust


def _empty(count):
    return Dust(
        np.empty(count, int),
        np.empty(count, int),
        np.empty((count, 3, 3)),
        np.empty((count, 3)),
        np.empty(count, int),
    )
