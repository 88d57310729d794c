"""Where a fine can sit: on the grain's facets, and on the fines that sit already."""

from dataclasses import dataclass

import numpy as np

from .randomness import shuffled
from .rows import Rows, padded

# Side of a cell on a facet as a share of the fine's diameter: below 1 so that a seat lost to a
# neighbour leaves another one close by.
_CELL = 0.65
# A facet offers a seat if its area is at least this share of the area of the fine's base.
_SUPPORT = 0.2
# Outer facets of a fine: those tilted by less than 72 degrees (cosine) from the facet it sits on.
_OUTER = 0.3
# Seats are offered so many at a time: most of a larger batch would be lost to its own first few.
_BATCH = 128


@dataclass(frozen=True)
class Seats(Rows):
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
    cosine, sine = np.cos(spins)[:, None], np.sin(spins)[:, None]
    return np.stack([cosine * side + sine * up, cosine * up - sine * side, normals], axis=2)


class Pool:
    """Seats for one class of fines, the lowest layer first, in random order within it."""

    def __init__(self, grain, fines, kind, rng):
        self.fine, self.kind, self.rng = fines[kind], kind, rng
        base_area = max(b.facet_areas_and_centroids[0].max() for b in self.fine.bodies)
        self.outer = _OuterFacets(fines, _SUPPORT * base_area)
        self.hosts_used = 0
        points, normals = _cells(grain, _CELL * self.fine.diameter_um, _SUPPORT * base_area, rng)
        self._fill(points, normals, np.ones(len(points), int))

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

    def refill(self, dust, count, most_layers):
        """Seats on the fines seated since the last time; says whether there are any."""
        hosts = np.arange(self.hosts_used, count)
        hosts = hosts[dust.layer[hosts] < most_layers]
        self.hosts_used = count
        points, normals, of = self.outer.of(dust, hosts)
        self._fill(points, normals, dust.layer[hosts][of] + 1)
        return len(points) > 0


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
    points, normals = [np.empty((0, 3))], [np.empty((0, 3))]
    for i, loop in enumerate(body.facets):
        if areas[i] < least_area:
            continue
        corners = (body.vertices[list(loop)] - centroids[i]) @ rotations[i][:, :2]
        reach = int(np.ceil(np.abs(corners).max() / side)) + 1
        row, column = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1)
        y = (row + offsets[i, 1]) * side * np.sqrt(3) / 2
        x = (column + 0.5 * (row % 2) + offsets[i, 0]) * side
        ahead = (np.roll(corners, -1, axis=0) - corners)[..., None]
        corners = corners[..., None]
        left = ahead[:, 0] * (y - corners[:, 1]) - ahead[:, 1] * (x - corners[:, 0])
        inside = (left > 0).all(axis=0)
        flat = np.column_stack([x[inside], y[inside]])
        if len(flat) == 0:
            flat = np.zeros((1, 2))
        points.append(flat @ rotations[i][:, :2].T + centroids[i])
        normals.append(np.repeat(body.normals[i][None], len(flat), axis=0))
    return np.vstack(points), np.vstack(normals)
