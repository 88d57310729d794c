"""Which seats are clear of the grain and of the fines that sit already.

Seats are offered in batches. Those that a fine in place leaves no room for are struck out at once;
which of the others exclude each other is noted, so that to take one is to strike out its rivals.
"""

from dataclasses import dataclass

import numpy as np

from .neighbours import near
from .rows import Rows, padded

# Bodies that touch in a plane are apart; this share of the fine's diameter absorbs the rounding.
_TOUCH = 1e-7


@dataclass(frozen=True)
class _Placed(Rows):
    """Fines where they sit, or would."""

    shape: np.ndarray  # (N,)
    rotation: np.ndarray  # (N, 3, 3)
    position: np.ndarray  # (N, 3)
    centre: np.ndarray  # (N, 3) of mass


class Clearance:
    """The seats offered so far, by number: taken, struck out, or neither yet."""

    def __init__(self, grain, fines):
        self.grain = grain
        self.touch = _TOUCH * max((fine.diameter_um for fine in fines), default=0)
        self.first = np.cumsum([0] + [len(fine.bodies) for fine in fines])
        self.shapes = _Shapes([body for fine in fines for body in fine.bodies])
        self.placed = _Placed(np.empty(0, int), np.empty((0, 3, 3)), *np.empty((2, 0, 3)))
        self.struck = np.empty(0, bool)
        self.taken = np.empty(0, bool)
        self.rivals = []

    def offer(self, kind, seats):
        """The number of the first of these seats; the others follow."""
        old = len(self.placed)
        shape = self.first[kind] + seats.body
        centre = _turned(seats.rotation, self.shapes.centre[shape]) + seats.position
        self.placed += _Placed(shape, seats.rotation, seats.position, centre)
        self.struck = np.concatenate([self.struck, np.zeros(len(seats), bool)])
        self.taken = np.concatenate([self.taken, np.zeros(len(seats), bool)])
        self.rivals += [[] for _ in range(len(seats))]
        numbers = np.arange(old, len(self.placed))
        # The spheres within decide most seats.
        i, _ = self._meeting(numbers, np.flatnonzero(self.taken), self.shapes.inner)
        self.struck[i] = True
        upper = numbers[(seats.layer > 1) & ~self.struck[numbers]]
        self.struck[upper[self._sunk(upper)]] = True
        there = np.flatnonzero(~self.struck)
        i, j = self._meeting(there[there >= old], there, self.shapes.outer)
        self._note_rivals(*self._through(i[j < i], j[j < i]))
        return old

    def take(self, number):
        """Takes a seat unless it is struck out; says whether it did."""
        if self.struck[number]:
            return False
        self.taken[number] = True
        self.struck[self.rivals[number]] = True
        return True

    def _meeting(self, new, there, radius):
        """Pairs of seats whose spheres about their centres overlap."""
        centre, radius = self.placed.centre, radius[self.placed.shape]
        i, j = near(centre[new], centre[there], 2 * radius.max(initial=0))
        i, j = new[i], there[j]
        away = centre[i] - centre[j]
        meet = np.einsum("ij,ij->i", away, away) < (radius[i] + radius[j]) ** 2
        return i[meet], j[meet]

    def _sunk(self, numbers):
        """Whether no facet of the grain has all of the fine on its outer side."""
        new, normals, offsets = self.placed[numbers], self.grain.normals, self.grain.offsets
        return ~self.shapes.beyond(
            np.broadcast_to(normals, (len(new), *normals.shape)),
            np.broadcast_to(offsets, (len(new), *offsets.shape)),
            new.shape,
            new.rotation,
            new.position,
            self.touch,
        )

    def _through(self, i, j):
        """The pairs without a facet of one that has all of the other on its outer side."""
        kept = ~self._apart(i, j)
        i, j = i[kept], j[kept]
        kept = ~self._apart(j, i)
        return i[kept], j[kept]

    def _note_rivals(self, i, j):
        sits = self.taken[j]
        self.struck[i[sits]] = True
        for a, b in zip(i[~sits].tolist(), j[~sits].tolist()):
            self.rivals[a].append(b)
            self.rivals[b].append(a)

    def _apart(self, i, j):
        """Whether fine j lies wholly outside one of the facets of fine i."""
        one, two = self.placed[i], self.placed[j]
        back = one.rotation.transpose(0, 2, 1)
        return self.shapes.beyond(
            self.shapes.normals[one.shape],
            self.shapes.offsets[one.shape],
            two.shape,
            back @ two.rotation,
            _turned(back, two.position - one.position),
            self.touch,
        )


class _Shapes:
    """The fines' shapes, their arrays padded to one size by repetition."""

    def __init__(self, bodies):
        self.vertices = padded([body.vertices for body in bodies])
        self.normals = padded([body.normals for body in bodies])
        self.offsets = padded([body.offsets for body in bodies])
        self.centre = np.array([body.volume_and_centroid[1] for body in bodies]).reshape(-1, 3)
        # Radii of the spheres about the centre that lie within the body, and around it.
        heights = self.offsets - (self.normals @ self.centre[..., None])[..., 0]
        spokes = np.linalg.norm(self.vertices - self.centre[:, None], axis=2)
        self.inner, self.outer = heights.min(axis=1), spokes.max(axis=1)

    def beyond(self, normals, offsets, shape, rotation, position, touch):
        """Whether the fine lies wholly outside one of the planes: pair by pair."""
        centre = _turned(rotation, self.centre[shape]) + position
        heights = _turned(normals, centre) - offsets
        # The sphere within has to lie outside as well: that leaves few planes.
        pair, plane = np.nonzero(heights > self.inner[shape, None] - touch)
        normal = normals[pair, plane]
        lowest = _turned(
            self.vertices[shape[pair]], _turned(rotation[pair].transpose(0, 2, 1), normal)
        ).min(axis=1)
        lowest += (normal * position[pair]).sum(axis=1) - offsets[pair, plane]
        found = np.zeros(len(shape), bool)
        found[pair[lowest >= -touch]] = True
        return found


def _turned(matrices, vectors):
    return (matrices @ vectors[..., None])[..., 0]
