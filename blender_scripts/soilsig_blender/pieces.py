"""How far apart two dusty grains are, or how deep they overlap.

A dusty grain is a union of convex pieces: the grain and its fines. Two convex pieces are apart if
a facet plane of one, or a plane along an edge of each, has them on its two sides (separating
axes), so the true meshes are compared without rays or trees. Facet planes decide nearly all
pairs; the edges are asked only where those find an overlap, whose depth is then exact.
"""

import numpy as np

from .rows import padded

# This many pairs of fines are compared at a time, to bound the memory.
_BATCH = 4096


def distance(one, two, pose_one, pose_two, reach):
    """A distance (um) that the dusty grains keep at least, or minus the depth of their overlap.

    Pieces further apart than `reach` are not looked at.
    """
    turn = pose_one[:3, :3].T @ pose_two[:3, :3]
    shift = pose_one[:3, :3].T @ (pose_two[:3, 3] - pose_one[:3, 3])
    other = two.facing(-turn.T @ shift, one.radius + reach).moved(turn, shift)
    near = one.facing(shift, two.radius + reach)
    return min(
        _gaps(one.core, other.core).min(),
        _to_fines(one, other, reach),
        _to_fines(other, near, reach),
        _between_fines(near, other, reach),
    )


def near_fines(one, two, turn, shift, reach):
    """Which fines of either grain come within `reach` of a piece of the other, and some more.

    The second is turned and shifted. Few planes are tried to find fines apart: the facets of the
    other grain, and the plane across the line between the centres of two fines.
    """
    a = np.flatnonzero(_away(one.centre, shift) < one.outer + two.radius + reach)
    b = np.flatnonzero(_away(two.centre, -turn.T @ shift) < two.outer + one.radius + reach)
    near_one = _near_core(one, a, two.core, turn.T, -turn.T @ shift, reach)
    near_two = _near_core(two, b, one.core, turn, shift, reach)
    away = two.centre[b] @ turn.T + shift - one.centre[a][:, None]
    squared = np.einsum("ijk,ijk->ij", away, away)
    i, j = np.nonzero(squared < (one.outer[a][:, None] + two.outer[b] + reach) ** 2)
    across = (away[i, j] / np.sqrt(squared[i, j])[:, None])[:, :, None]
    theirs = (two.fines.corners[b[j]] @ (turn.T @ across)).min(axis=1)[:, 0]
    mine = (one.fines.corners[a[i]] @ across).max(axis=1)[:, 0]
    close = theirs + across[:, :, 0] @ shift - mine < reach
    near_one[i[close]] = near_two[j[close]] = True
    return a[near_one], b[near_two]


def _near_core(grain, which, core, turn, shift, reach):
    """Whether each of these fines of a grain has no facet of the other's core far below it."""
    normals, offsets = core.normals[0] @ turn, core.offsets[0] - core.normals[0] @ shift
    near = (grain.centre[which] @ normals.T - offsets).max(axis=1) < grain.outer[which] + reach
    heights = (grain.fines.corners[which[near]] @ normals.T).min(axis=1) - offsets
    near[near] = heights.max(axis=1) < reach
    return near


def _to_fines(host, other, reach):
    """The least gap between the one grain and the fines of the other."""
    core = host.core
    height = other.centre @ core.normals[0].T - core.offsets[0]
    near = np.flatnonzero(height.max(axis=1) < other.outer + reach)
    return _gaps(core, other.fines.take(near)).min(initial=np.inf)


def _between_fines(one, other, reach):
    """The least gap between a fine of the one grain and a fine of the other."""
    squared = ((one.centre[:, None] - other.centre) ** 2).sum(axis=2)
    i, j = np.nonzero(squared < (one.outer[:, None] + other.outer + reach) ** 2)
    least = np.inf
    for at in range(0, len(i), _BATCH):
        mine, theirs = i[at : at + _BATCH], j[at : at + _BATCH]
        least = min(least, _gaps(one.fines.take(mine), other.fines.take(theirs)).min())
    return least


def _away(points, centre):
    return np.linalg.norm(points - centre, axis=1)


def _gaps(one, two):
    """Gaps between solids pair by pair (a single solid is paired with all of the others)."""
    ahead = (two.corners @ one.normals.transpose(0, 2, 1)).min(axis=1) - one.offsets
    behind = (one.corners @ two.normals.transpose(0, 2, 1)).min(axis=1) - two.offsets
    gaps = np.maximum(ahead.max(axis=1), behind.max(axis=1))
    for i in np.flatnonzero(gaps < 0):
        gaps[i] = max(gaps[i], _gap_across_edges(one.at(i), two.at(i)))
    return gaps


def _gap_across_edges(one, two):
    """The largest gap across planes along an edge of each solid.

    Only pairs of edges whose arcs of normals cross on the sphere of directions can hold such a
    plane between the solids (the facets of their Minkowski difference).
    """
    (a, b), (c, d) = one.edge_normals[0].swapaxes(0, 1), two.edge_normals[0].swapaxes(0, 1)
    along_one, along_two = np.cross(a, b), np.cross(c, d)
    c_side, d_side = along_one @ c.T, along_one @ d.T
    a_side, b_side = a @ along_two.T, b @ along_two.T
    i, j = np.nonzero((c_side * d_side < 0) & (a_side * b_side < 0) & (c_side * b_side < 0))
    axes = np.cross(along_one[i], along_two[j])
    length = np.linalg.norm(axes, axis=1)
    keep = length > 1e-9
    i, j, axes = i[keep], j[keep], axes[keep] / length[keep, None]
    outward = np.sign(np.einsum("ij,ij->i", axes, a[i] + b[i]))
    between = two.edge_points[0][j] - one.edge_points[0][i]
    return (outward * np.einsum("ij,ij->i", axes, between)).max(initial=-np.inf)


class Solids:
    """Convex solids side by side, their arrays padded to one size by repetition."""

    def __init__(self, corners, normals, offsets, edge_normals, edge_points):
        self.corners = corners  # (N, V, 3)
        self.normals = normals  # (N, F, 3)
        self.offsets = offsets  # (N, F)
        self.edge_normals = edge_normals  # (N, E, 2, 3) of the facets that meet
        self.edge_points = edge_points  # (N, E, 3)

    @classmethod
    def of(cls, bodies):
        return cls(
            padded([body.vertices for body in bodies]),
            padded([body.normals for body in bodies]),
            padded([body.offsets for body in bodies], ()),
            padded([body.normals[body.edges[:, :2]] for body in bodies], (2, 3)),
            padded([body.vertices[body.edges[:, 2]] for body in bodies]),
        )

    def take(self, which):
        return Solids(
            self.corners[which],
            self.normals[which],
            self.offsets[which],
            self.edge_normals[which],
            self.edge_points[which],
        )

    def at(self, i):
        """Solid i alone; a single solid stands for every i."""
        return self.take([min(i, len(self.corners) - 1)])

    def moved(self, turn, shift):
        """Turned and shifted; one pose for all, or one for each."""
        back = np.swapaxes(turn, -1, -2)
        normals = self.normals @ back
        offsets = self.offsets + (normals @ shift[..., :, None])[..., 0]
        shift = shift[..., None, :]
        return Solids(
            self.corners @ back + shift,
            normals,
            offsets,
            self.edge_normals @ back[..., None, :, :],
            self.edge_points @ back + shift,
        )


class Pieces:
    """The solids of one dusty grain: the grain itself and its fines with their outer spheres."""

    def __init__(self, core, fines, centre, outer, radius):
        self.core = core
        self.fines = fines
        self.centre = centre  # (N, 3)
        self.outer = outer  # (N,)
        self.radius = radius  # of the whole about its centre of mass

    @classmethod
    def of(cls, prototype):
        bodies = [body for fine in prototype.fines for body in fine.bodies]
        first = np.cumsum([0] + [len(fine.bodies) for fine in prototype.fines])
        dust = prototype.dust
        which = first[dust.kind] + dust.body
        centres = np.array([body.volume_and_centroid[1] for body in bodies]).reshape(-1, 3)
        radii = np.array([_away(b.vertices, c).max() for b, c in zip(bodies, centres)])
        return cls(
            Solids.of([prototype.grain]),
            Solids.of(bodies).take(which).moved(dust.rotation, dust.position),
            (dust.rotation @ centres[which][..., None])[..., 0] + dust.position,
            radii[which],
            _away(prototype.outline, np.zeros(3)).max(),
        )

    def facing(self, point, distance):
        """The grain with those of its fines that come within the distance of a point."""
        near = np.flatnonzero(_away(self.centre, point) < self.outer + distance)
        return Pieces(
            self.core, self.fines.take(near), self.centre[near], self.outer[near], self.radius
        )

    def contain(self, points):
        """Whether each point is inside the grain or one of its fines."""
        inside = (points @ self.core.normals[0].T <= self.core.offsets[0]).all(axis=1)
        outside = np.flatnonzero(~inside)
        squared = ((points[outside, None] - self.centre) ** 2).sum(axis=2)
        point, fine = np.nonzero(squared < self.outer**2)
        heights = np.einsum("nfi,ni->nf", self.fines.normals[fine], points[outside[point]])
        within = (heights <= self.fines.offsets[fine]).all(axis=1)
        inside[outside[point[within]]] = True
        return inside

    def moved(self, turn, shift):
        return Pieces(
            self.core.moved(turn, shift),
            self.fines.moved(turn, shift),
            self.centre @ turn.T + shift,
            self.outer,
            self.radius,
        )
