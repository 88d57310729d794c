"""How far apart two dusty grains are, or how deep they overlap.

Two convex solids are apart if a facet plane of one, or a plane along an edge of each, has them on
its two sides (separating axes). So the true meshes are compared without rays or trees. Facet planes
decide nearly all pairs. The edges are asked only where those find an overlap, whose depth is then
exact.
"""

import numpy as np

from .hollow_distance import between_cores, to_fines

# This many pairs of fines are compared at a time, to bound the memory.
_BATCH = 4096


def distance(one, two, pose_one, pose_two, reach):
    """A distance (um) that the dusty grains keep at least, or minus the depth of their overlap.

    Solids further apart than `reach` are not looked at.
    """
    turn = pose_one[:3, :3].T @ pose_two[:3, :3]
    shift = pose_one[:3, :3].T @ (pose_two[:3, 3] - pose_one[:3, 3])
    other = two.facing(-turn.T @ shift, one.radius + reach).moved(turn, shift)
    near = one.facing(shift, two.radius + reach)
    if one.hollow or other.hollow:
        cores = between_cores(one, other, _gaps_across_planes(one.core, other.core).min(), reach)
    else:
        cores = gaps(one.core, other.core).min()
    return min(
        cores,
        _to_fines(one, other, reach),
        _to_fines(other, near, reach),
        _between_fines(near, other, reach),
    )


def _to_fines(host, other, reach):
    """The least gap between the one grain and the fines of the other."""
    if host.hollow:
        return to_fines(host, other, reach)
    core = host.core
    height = other.centre @ core.normals[0].T - core.offsets[0]
    near = np.flatnonzero(height.max(axis=1) < other.outer + reach)
    return gaps(core, other.fines.take(near)).min(initial=np.inf)


def _between_fines(one, other, reach):
    """The least gap between a fine of the one grain and a fine of the other."""
    squared = ((one.centre[:, None] - other.centre) ** 2).sum(axis=2)
    i, j = np.nonzero(squared < (one.outer[:, None] + other.outer + reach) ** 2)
    least = np.inf
    for at in range(0, len(i), _BATCH):
        mine, theirs = i[at : at + _BATCH], j[at : at + _BATCH]
        least = min(least, gaps(one.fines.take(mine), other.fines.take(theirs)).min())
    return least


def gaps(one, two):
    """Gaps between solids pair by pair (a single solid is paired with all of the others)."""
    gap = _gaps_across_planes(one, two)
    for i in np.flatnonzero(gap < 0):
        gap[i] = max(gap[i], _gap_across_edges(one.edges_of(i), two.edges_of(i)))
    return gap


def _gaps_across_planes(one, two):
    """The largest gap across a facet's plane of either: no more than the gap between the solids."""
    ahead = (two.corners @ one.normals.transpose(0, 2, 1)).min(axis=1) - one.offsets
    behind = (one.corners @ two.normals.transpose(0, 2, 1)).min(axis=1) - two.offsets
    return np.maximum(ahead.max(axis=1), behind.max(axis=1))


def _gap_across_edges(one, two):
    """The largest gap across planes along an edge of each solid, of which the edges are given.

    Only pairs of edges whose arcs of normals cross on the sphere of directions can hold such a
    plane between the solids (the facets of their Minkowski difference).
    """
    (a, b, at_one), (c, d, at_two) = one, two
    along_one, along_two = np.cross(a, b), np.cross(c, d)
    c_side, d_side = along_one @ c.T, along_one @ d.T
    a_side, b_side = a @ along_two.T, b @ along_two.T
    i, j = np.nonzero((c_side * d_side < 0) & (a_side * b_side < 0) & (c_side * b_side < 0))
    axes = np.cross(along_one[i], along_two[j])
    length = np.linalg.norm(axes, axis=1)
    crossing = length > 1e-9
    i, j, axes = i[crossing], j[crossing], axes[crossing] / length[crossing, None]
    outward = np.sign(np.einsum("ij,ij->i", axes, a[i] + b[i]))
    between = at_two[j] - at_one[i]
    return (outward * np.einsum("ij,ij->i", axes, between)).max(initial=-np.inf)
