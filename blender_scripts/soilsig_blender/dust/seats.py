"""Where a fine can sit: on the grain's facets, and on the fines that are seated."""

from dataclasses import dataclass

import numpy as np

from ..common.arrays import Columns, padded
from ..common.directions import cosine_and_sine
from ..common.neighbours import ranges
from ..common.randomness import shuffled

# Side of a cell on a facet as a share of the fine's diameter. It is below 1, so that another seat
# is close to one that a neighbour takes away.
_CELL = 0.65
# Where no seat is left in any layer, the grain's facets are divided again into cells of half the
# side. There are at most this many divisions.
_LATTICES = 2
# A facet offers a seat if its area is at least this share of the area of the fine's base.
_SUPPORT = 0.2
# Outer facets of a fine are tilted by less than 72 degrees from the facet that it sits on (cosine).
_OUTER = 0.3
# Seats offered at a time. Most seats of a larger batch would be lost to its first few.
_BATCH = 256


@dataclass(frozen=True)
class Seats(Columns):
    """Places for fines of one class."""

    body: np.ndarray  # (N,) index of the shape within the class
    rotation: np.ndarray  # (N, 3, 3)
    position: np.ndarray  # (N, 3)
    layer: np.ndarray  # (N,) 1 on the grain itself


def frames(normals, spins):
    """Rotations that take z to each normal, after a turn about z: (N, 3, 3)."""
    smallest = np.argmin(np.abs(normals), axis=1)
    side = np.cross(normals, np.eye(3)[smallest])
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(normals, side)
    cosine, sine = (part[:, None] for part in cosine_and_sine(spins))
    return np.stack([cosine * side + sine * up, cosine * up - sine * side, normals], axis=2)


class Pool:
    """Seats for one class of fines, the lowest layer first, in random order within it."""

    def __init__(self, grain, fines, kind, rng, ground=None):
        self.ground = ground
        self.fine, self.kind, self.rng = fines[kind], kind, rng
        base_area = max(b.facet_areas_and_centroids[0].max() for b in self.fine.bodies)
        self.outer = _OuterFacets(fines, _SUPPORT * base_area)
        self.hosts_used = 0
        self.grain, self.least_area, self.lattices = grain, _SUPPORT * base_area, 0
        self._fill_from_grain()

    def _fill_from_grain(self):
        side = _CELL * self.fine.diameter_um / 2**self.lattices
        if self.ground:
            points, normals = self.ground.cells(
                side, self.fine.diameter_um, self.least_area, self.rng
            )
        else:
            points, normals = _cells(self.grain, side, self.least_area, self.rng)
        self._fill(points, normals, np.ones(len(points), int))
        self.lattices += 1

    def _fill(self, points, normals, layers):
        order = shuffled(self.rng, len(points))
        order = order[np.argsort(layers[order], kind="stable")]
        rotations = frames(normals[order], 2 * np.pi * self.rng.random(len(order)))
        bodies = (len(self.fine.bodies) * self.rng.random(len(order))).astype(int)
        self.seats = Seats(bodies, rotations, points[order], layers[order])
        self.count = len(order)
        self.at = self.offered = 0

    def take(self, clearance):
        """The index of the next clear seat, or None."""
        for at in range(self.at, self.count):
            if at == self.offered:
                batch = self.seats[at : at + _BATCH]
                self.first = clearance.offer(self.kind, batch) - at
                self.offered += len(batch)
            if clearance.take(self.first + at):
                self.at = at + 1
                return at
        self.at = self.count
        return None

    def refill(self, dust, most_layers):
        """Further seats, first on the fines seated since the last time; says whether there are."""
        hosts = np.arange(self.hosts_used, len(dust))
        hosts = hosts[dust.layer[hosts] < most_layers]
        self.hosts_used = len(dust)
        points, normals, of = self.outer.of(dust, hosts)
        self._fill(points, normals, dust.layer[hosts][of] + 1)
        if not self.count and self.lattices < _LATTICES:
            self._fill_from_grain()
        return self.count > 0


class _OuterFacets:
    """Centres and normals of the facets of fines that another fine can sit on."""

    def __init__(self, fines, least_area):
        bodies = [body for fine in fines for body in fine.bodies]
        self.first = np.cumsum([0] + [len(fine.bodies) for fine in fines])
        areas, centroids = zip(*(body.facet_areas_and_centroids for body in bodies))
        normals = [body.normals for body in bodies]
        wide = [(n[:, 2] > _OUTER) & (a > least_area) for n, a in zip(normals, areas)]
        self.centroids = padded([c[w] for c, w in zip(centroids, wide)])
        self.normals = padded([n[w] for n, w in zip(normals, wide)])
        self.count = np.array([w.sum() for w in wide])

    def of(self, dust, hosts):
        """Points and normals of all of them on these fines, and which of the fines each is on."""
        shape = self.first[dust.kind[hosts]] + dust.body[hosts]
        back = dust.rotation[hosts].transpose(0, 2, 1)
        there = np.arange(self.centroids.shape[1]) < self.count[shape][:, None]
        points = self.centroids[shape] @ back + dust.position[hosts][:, None]
        normals = self.normals[shape] @ back
        return points[there], normals[there], np.nonzero(there)[0]


def _cells(body, side, least_area, rng):
    """Centres of the cells of a triangular lattice laid at random over each facet."""
    areas, centroids = body.facet_areas_and_centroids
    rotations = frames(body.normals, 2 * np.pi * rng.random(len(areas)))
    offsets = rng.random((len(areas), 2))
    wide = np.flatnonzero(areas >= least_area)
    rotations, offsets, centroids = rotations[wide, :, :2], offsets[wide], centroids[wide]
    corners = padded([body.vertices[list(body.facets[i])] for i in wide])
    corners = (corners - centroids[:, None]) @ rotations
    height = side * np.sqrt(3) / 2
    facet, row, column = _lattice(corners, side, height, offsets)
    y = (row + offsets[facet, 1]) * height
    x = (column + 0.5 * (row % 2) + offsets[facet, 0]) * side
    # A facet without a point of the lattice offers its middle.
    missed = np.setdiff1d(np.arange(len(wide)), facet)
    facet = np.concatenate([facet, missed])
    order = np.argsort(facet, kind="stable")
    facet = facet[order]
    flat = np.vstack([np.column_stack([x, y]), np.zeros((len(missed), 2))])[order]
    points = (rotations[facet] @ flat[:, :, None])[..., 0] + centroids[facet]
    return points, body.normals[wide][facet]


def _lattice(corners, side, height, offsets):
    """Facet, row and column of every point of the lattice inside a facet, row by row."""
    low, high = corners[..., 1].min(axis=1), corners[..., 1].max(axis=1)
    first = np.ceil(low / height - offsets[:, 1]).astype(int)
    end = np.floor(high / height - offsets[:, 1]).astype(int) + 1
    facet, row = np.repeat(np.arange(len(corners)), end - first), ranges(first, end)
    y = ((row + offsets[facet, 1]) * height)[:, None]
    # Where the row enters and leaves the facet. Edges along the row do not bound it.
    ahead = np.roll(corners, -1, axis=1) - corners
    level = ahead[..., 1] == 0
    slope = ahead[..., 0] / np.where(level, 1, ahead[..., 1])
    x = corners[facet, :, 0] + slope[facet] * (y - corners[facet, :, 1])
    left = np.where((ahead[..., 1] < 0)[facet], x, -np.inf).max(axis=1)
    right = np.where((ahead[..., 1] > 0)[facet], x, np.inf).min(axis=1)
    shift = 0.5 * (row % 2) + offsets[facet, 0]
    first = np.ceil(left / side - shift).astype(int)
    end = np.maximum(np.floor(right / side - shift).astype(int) + 1, first)
    return np.repeat(facet, end - first), np.repeat(row, end - first), ranges(first, end)
