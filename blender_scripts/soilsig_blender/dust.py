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

from .errors import BedError
from .polyhedron import Polyhedron
from .randomness import shuffled, stream

# Side of a cell on a facet as a share of the fine's diameter: below 1 so that a seat lost to a
# neighbour leaves another one close by.
_CELL = 0.65
# A facet offers a seat if its area is at least this share of the area of the fine's base.
_SUPPORT = 0.2
# Outer facets of a fine: those tilted by less than 72 degrees (cosine) from the facet it sits on.
_OUTER = 0.3
# No more layers than this.
_MOST_LAYERS = 8
# Bodies that touch in a plane are apart; this share of the fine's diameter absorbs the rounding.
_TOUCH = 1e-7


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


def seated_on_base(body: Polyhedron) -> Polyhedron:
    """The body with its largest facet down, that facet's centroid at the origin."""
    areas, centroids = body.facet_areas_and_centroids
    base = int(np.argmax(areas))
    rotation = frames(-body.normals[base][None], np.zeros(1))[0].T
    return body.moved(rotation, -rotation @ centroids[base])


def frames(normals, spins):
    """Rotations that take z to each normal, after a turn about z: (N, 3, 3)."""
    smallest = np.argmin(np.abs(normals), axis=1)
    side = np.cross(normals, np.eye(3)[smallest])
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(normals, side)
    cosine, sine = np.cos(spins)[:, None], np.sin(spins)[:, None]
    return np.stack([cosine * side + sine * up, cosine * up - sine * side, normals], axis=2)


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
    seated = _Seated(grain, fines, count)
    pools = [_Pool(grain, fine, stream(seed, "dust", label, fine.name)) for fine in fines if count]
    for kind in share_out(np.array([fine.share for fine in fines]), count):
        pool = pools[kind]
        while True:
            if pool.empty() and not pool.refill(seated, fines):
                raise BedError(
                    "scene",
                    f"only {seated.count} of the {count} fines find a seat on {label} in "
                    f"{_MOST_LAYERS} layers: a {pool.fine.name} has none",
                    "ask for fewer or smaller fines",
                )
            if seated.take(kind, pool.next()):
                break
    return Dust(*(array[:count] for array in seated.poses()))


class _Pool:
    """Seats for one class of fines, the lowest layer first, in random order within it."""

    def __init__(self, grain, fine, rng):
        self.fine = fine
        self.rng = rng
        self.hosts_used = 0
        self.base_area = max(body.facet_areas_and_centroids[0].max() for body in fine.bodies)
        points, normals = _cells(grain, _CELL * fine.diameter_um, _SUPPORT * self.base_area, rng)
        self._fill(points, normals, np.ones(len(points), int))

    def _fill(self, points, normals, layers):
        order = shuffled(self.rng, len(points))
        order = order[np.argsort(layers[order], kind="stable")]
        self.points, self.normals, self.layers = points[order], normals[order], layers[order]
        self.rotations = frames(self.normals, 2 * np.pi * self.rng.random(len(order)))
        self.bodies = (len(self.fine.bodies) * self.rng.random(len(order))).astype(int)
        self.at = 0

    def empty(self):
        return self.at == len(self.points)

    def next(self):
        i = self.at
        self.at += 1
        return self.bodies[i], self.rotations[i], self.points[i], self.layers[i]

    def refill(self, seated, fines):
        """Seats on the outer facets of the fines seated since the last time."""
        points, normals, layers = [], [], []
        for host in range(self.hosts_used, seated.count):
            if seated.layer[host] == _MOST_LAYERS:
                continue
            body = fines[seated.kind[host]].bodies[seated.body[host]]
            areas, centroids = body.facet_areas_and_centroids
            outer = (body.normals[:, 2] > _OUTER) & (areas > _SUPPORT * self.base_area)
            rotation = seated.rotation[host]
            points.append(centroids[outer] @ rotation.T + seated.position[host])
            normals.append(body.normals[outer] @ rotation.T)
            layers.append(np.full(outer.sum(), seated.layer[host] + 1))
        self.hosts_used = seated.count
        if not any(len(p) for p in points):
            return False
        self._fill(np.vstack(points), np.vstack(normals), np.concatenate(layers))
        return True


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
        ahead = np.roll(corners, -1, axis=0) - corners
        inside = np.ones(len(x), bool)
        for (cx, cy), (dx, dy) in zip(corners, ahead):
            inside &= dx * (y - cy) - dy * (x - cx) > 0
        flat = np.column_stack([x[inside], y[inside]])
        if len(flat) == 0:
            flat = np.zeros((1, 2))
        points.append(flat @ rotations[i][:, :2].T + centroids[i])
        normals.append(np.repeat(body.normals[i][None], len(flat), axis=0))
    return np.vstack(points), np.vstack(normals)


class _Seated:
    """The fines that sit already, and whether one more is clear of them and of the grain."""

    def __init__(self, grain, fines, capacity):
        bodies = [body for fine in fines for body in fine.bodies]
        self.first = np.cumsum([0] + [len(fine.bodies) for fine in fines])
        self.local = [_Solid(body) for body in bodies]
        most_vertices = max((len(b.vertices) for b in bodies), default=0)
        most_facets = max((len(b.normals) for b in bodies), default=0)
        for solid in self.local:
            solid.pad(most_vertices, most_facets)
        self.grain = grain
        self.touch = _TOUCH * max((fine.diameter_um for fine in fines), default=0)
        self.count = 0
        self.kind = np.empty(capacity, int)
        self.body = np.empty(capacity, int)
        self.rotation = np.empty((capacity, 3, 3))
        self.position = np.empty((capacity, 3))
        self.layer = np.empty(capacity, int)
        self.centre = np.empty((capacity, 3))
        self.inner = np.empty(capacity)
        self.outer = np.empty(capacity)
        self.vertices = np.empty((capacity, most_vertices, 3))
        self.normals = np.empty((capacity, most_facets, 3))
        self.offsets = np.empty((capacity, most_facets))

    def poses(self):
        return self.kind, self.body, self.rotation, self.position, self.layer

    def take(self, kind, seat):
        """Seats a fine if it is clear of everything; says whether it was."""
        body, rotation, position, layer = seat
        solid = self.local[self.first[kind] + body]
        centre = rotation @ solid.centre + position
        away = self.centre[: self.count] - centre
        squared = np.einsum("ij,ij->i", away, away)
        if (squared < (self.inner[: self.count] + solid.inner) ** 2).any():
            return False
        vertices = solid.vertices @ rotation.T + position
        normals = solid.normals @ rotation.T
        offsets = solid.offsets + normals @ position
        if layer > 1:
            beyond = (vertices @ self.grain.normals.T).min(axis=0) - self.grain.offsets
            if beyond.max() < -self.touch:
                return False
        near = np.flatnonzero(squared < (self.outer[: self.count] + solid.outer) ** 2)
        if len(near):
            theirs = (vertices @ self.normals[near].transpose(0, 2, 1)).min(axis=1)
            apart = (theirs - self.offsets[near]).max(axis=1)
            ours = (self.vertices[near] @ normals.T).min(axis=1)
            apart = np.maximum(apart, (ours - offsets).max(axis=1))
            if apart.min() < -self.touch:
                return False
        i = self.count
        self.kind[i], self.body[i], self.layer[i] = kind, body, layer
        self.rotation[i], self.position[i] = rotation, position
        self.centre[i], self.inner[i], self.outer[i] = centre, solid.inner, solid.outer
        self.vertices[i], self.normals[i], self.offsets[i] = vertices, normals, offsets
        self.count += 1
        return True


class _Solid:
    """A fine's shape with its inner and outer sphere, padded to the size of the largest."""

    def __init__(self, body):
        self.centre = body.volume_and_centroid[1]
        self.inner = (body.offsets - body.normals @ self.centre).min()
        self.outer = np.linalg.norm(body.vertices - self.centre, axis=1).max()
        self.vertices, self.normals, self.offsets = body.vertices, body.normals, body.offsets

    def pad(self, vertices, facets):
        def fill(array, size):
            return np.concatenate([array, np.repeat(array[:1], size - len(array), axis=0)])

        self.vertices = fill(self.vertices, vertices)
        self.normals = fill(self.normals, facets)
        self.offsets = fill(self.offsets, facets)
