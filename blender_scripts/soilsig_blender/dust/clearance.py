"""Which seats are clear of the grain and of the fines that are seated.

Seats are offered in batches. A seat without room beside a seated fine is struck out at once. Of the
other seats it is noted which exclude each other: taking a seat strikes out its rivals.
"""

import numpy as np

from ..common.neighbours import near
from .bodies import Bodies, turned

# Bodies that touch in a plane are apart. This share of the fine's diameter allows for rounding.
_TOUCH = 1e-7


class Clearance:
    """The seats offered so far, by number: taken, struck out, or neither yet."""

    def __init__(self, grain, fines, overlap, ground=None):
        self.grain = grain
        self.ground = ground
        self.diameters = [fine.diameter_um for fine in fines]
        self.overlap = overlap
        self.touch = _TOUCH * max(fine.diameter_um for fine in fines)
        self.first = np.cumsum([0] + [len(fine.bodies) for fine in fines])
        self.shapes = Bodies([body for fine in fines for body in fine.bodies])
        # How deep other fines may overlap a fine of this shape.
        self.slack = np.repeat(
            [overlap * fine.diameter_um + self.touch for fine in fines],
            [len(fine.bodies) for fine in fines],
        )
        self.placed = self.shapes.placed(np.empty(0, int), np.empty((0, 3, 3)), np.empty((0, 3)))
        self.struck = np.empty(0, bool)
        self.taken = np.empty(0, bool)
        self.rivals = []

    def offer(self, kind, seats):
        """The number of the first of these seats; the others follow."""
        old = len(self.placed)
        shape = self.first[kind] + seats.body
        room = np.ones(len(seats), bool)
        if self.ground:
            # In place: the pool takes its seats from here.
            seats.position[:], room = self.ground.lifted(
                seats, shape, self.shapes, self.diameters[kind], self.touch
            )
        self.placed += self.shapes.placed(shape, seats.rotation, seats.position)
        self.struck = np.concatenate([self.struck, ~room])
        self.taken = np.concatenate([self.taken, np.zeros(len(seats), bool)])
        self.rivals += [[] for _ in range(len(seats))]
        numbers = np.arange(old, len(self.placed))
        if self.overlap < 1:
            # The inscribed spheres decide most seats.
            i, _ = self._meeting(numbers, np.flatnonzero(self.taken), self.shapes.inner)
            self.struck[i] = True
        if not self.ground:
            upper = numbers[(seats.layer > 1) & ~self.struck[numbers]]
            self.struck[upper[self._sunk(upper)]] = True
        if self.overlap < 1:
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
        """Pairs of seats whose spheres about their centres overlap too deep."""
        centre, radius, slack = (
            self.placed.centre,
            radius[self.placed.shape],
            self.slack[self.placed.shape],
        )
        i, j = near(centre[new], centre[there], 2 * radius.max(initial=0))
        i, j = new[i], there[j]
        away = centre[i] - centre[j]
        reach = np.maximum(radius[i] + radius[j] - np.minimum(slack[i], slack[j]), 0)
        meet = np.einsum("ij,ij->i", away, away) < reach**2
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
            np.full(len(new), self.touch),
        )

    def _through(self, i, j):
        """The pairs without a facet of one that has enough of the other on its outer side."""
        kept = ~self._apart(i, j)
        i, j = i[kept], j[kept]
        kept = ~self._apart(j, i)
        return i[kept], j[kept]

    def _apart(self, i, j):
        """Whether fine j lies outside one of the facets of fine i, but for the slack."""
        one, two = self.placed[i], self.placed[j]
        back = one.rotation.transpose(0, 2, 1)
        return self.shapes.beyond(
            self.shapes.normals[one.shape],
            self.shapes.offsets[one.shape],
            two.shape,
            back @ two.rotation,
            turned(back, two.position - one.position),
            np.minimum(self.slack[one.shape], self.slack[two.shape]),
        )

    def _note_rivals(self, i, j):
        sits = self.taken[j]
        self.struck[i[sits]] = True
        for a, b in zip(i[~sits].tolist(), j[~sits].tolist()):
            self.rivals[a].append(b)
            self.rivals[b].append(a)
