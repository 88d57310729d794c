"""The convex hull of points as a polyhedron, its nearly coplanar triangles joined into facets.

The triangles are found for points displaced by a millionth of the extent, so that no four of them
lie in one plane. The corners of the hull are the points as given.
"""

from collections import Counter

import numpy as np

from .polyhedron import Polyhedron, heights

# Shares of the extent: the displacement, and how far corners may lie off the plane of their facet.
# The rounding of modelling programs, single precision, is less than either.
_DISPLACEMENT = 1e-6
FLATNESS = 1e-5
# Triangles of one facet face the same way to this cosine, except slivers.
_SAME_WAY = 0.9


def hull_of(points) -> Polyhedron:
    """The convex hull of points, or `ValueError` if they lie in a plane."""
    points = np.unique(np.asarray(points, float), axis=0)
    if len(points) < 4:
        raise ValueError("there are fewer than four points")
    size = np.ptp(points, axis=0).max()
    while True:
        triangles = _triangles(points + _DISPLACEMENT * size * _displacements(len(points)), size)
        loops = _joined(points, triangles, FLATNESS * size)
        needless = _needless(points, loops, FLATNESS * size)
        if not needless:
            return _polyhedron(points, loops)
        points = np.delete(points, needless, axis=0)


def _displacements(count):
    """Even over a cube. They go by squares: equal steps would displace points in a row alike."""
    steps = np.array([0.8191725133961645, 0.6710436067037893, 0.5497004779019703])
    return (np.arange(count)[:, None] ** 2 * steps) % 1 - 0.5


def _needless(points, loops, flat):
    """Corners within an edge of two facets, and of facets without breadth all but the ends."""
    facets = Counter(corner for loop in loops for corner in loop)
    found = {corner for corner, count in facets.items() if count < 3}
    for loop in loops:
        corners = points[list(loop)]
        apart = np.linalg.norm(corners[:, None] - corners, axis=2)
        one, two = np.unravel_index(np.argmax(apart), apart.shape)
        along = (corners[two] - corners[one]) / apart[one, two]
        off = corners - corners[one]
        off = off - np.outer(heights(off, along), along)
        if np.linalg.norm(off, axis=1).max() <= flat:
            found.update(c for i, c in enumerate(loop) if i not in (one, two))
    return sorted(found)


def depth_below(body, points):
    """How far each point lies below the surface of a convex body (negative outside)."""
    least = np.full(len(points), np.inf)
    for normal, offset in zip(body.normals, body.offsets):
        np.minimum(least, offset - points @ normal, out=least)
    return least


def _triangles(points, size):
    """Outward triangles of the hull of points no four of which lie in one plane."""
    first = _simplex(points)
    if abs(np.linalg.det(points[first[1:]] - points[first[0]])) < 1e-6 * size**3:
        raise ValueError("the points lie in a plane")
    a, b, c, d = first
    faces = np.array([(a, b, c), (a, c, d), (a, d, b), (b, d, c)])
    if np.linalg.det(points[first[1:]] - points[first[0]]) > 0:
        faces = faces[:, ::-1]
    normals, offsets = _planes(points, faces)
    for p in range(len(points)):
        if p in first:
            continue
        seen = heights(normals, points[p]) > offsets
        if not seen.any():
            continue
        lost = {(f[i - 1], f[i]) for f in faces[seen].tolist() for i in range(3)}
        rim = sorted(edge for edge in lost if edge[::-1] not in lost)
        new = np.array([(u, v, p) for u, v in rim])
        new_normals, new_offsets = _planes(points, new)
        faces = np.vstack([faces[~seen], new])
        normals = np.vstack([normals[~seen], new_normals])
        offsets = np.concatenate([offsets[~seen], new_offsets])
    return faces


def _simplex(points):
    """Four points far from one another."""
    a = int(np.argmin(points[:, 0]))
    b = int(np.argmax(np.linalg.norm(points - points[a], axis=1)))
    along = (points[b] - points[a]) / np.linalg.norm(points[b] - points[a])
    off = points - points[a]
    off = off - np.outer(heights(off, along), along)
    c = int(np.argmax(np.linalg.norm(off, axis=1)))
    normal = np.cross(points[b] - points[a], points[c] - points[a])
    d = int(np.argmax(np.abs(heights(points - points[a], normal))))
    return [a, b, c, d]


def _planes(points, faces):
    a, b, c = (points[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return normals, np.einsum("ij,ij->i", normals, a)


def _joined(points, triangles, flat):
    """The facets: triangles that lie flat with a larger one are of its facet."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    crosses = np.cross(b - a, c - a)
    areas = np.linalg.norm(crosses, axis=1)
    longest = np.max([np.linalg.norm(x, axis=1) for x in (b - a, c - b, a - c)], axis=0)
    sliver = areas < flat * longest
    across = {
        (t[i - 1], t[i]): number for number, t in enumerate(triangles.tolist()) for i in range(3)
    }
    free = np.ones(len(triangles), bool)
    loops = []
    for seed in np.argsort(-areas, kind="stable").tolist():
        if not free[seed]:
            continue
        normal = crosses[seed] / max(areas[seed], 1e-300)
        off = np.abs(heights(points, normal) - heights(points[triangles[seed][:1]], normal))
        facing = sliver | (heights(crosses, normal) > _SAME_WAY * areas)
        lies = free & facing & (off[triangles] <= flat).all(axis=1)
        region, todo = {seed}, [seed]
        while todo:
            corners = triangles[todo.pop()].tolist()
            for i in range(3):
                beside = across[corners[i], corners[i - 1]]
                if lies[beside] and beside not in region:
                    region.add(beside)
                    todo.append(beside)
        loop = _rim(triangles, region)
        if loop is None:
            region, loop = {seed}, triangles[seed].tolist()
        free[list(region)] = False
        loops.append(loop)
    return sorted(_from_least(loop) for loop in loops)


def _rim(triangles, region):
    """The outline of a region as one loop of vertices, or None if it is not one."""
    sides = {(t[i - 1], t[i]) for t in triangles[sorted(region)].tolist() for i in range(3)}
    following = {u: v for u, v in sides if (v, u) not in sides}
    rim = sum((v, u) not in sides for u, v in sides)
    loop = [min(following)]
    while (after := following[loop[-1]]) != loop[0]:
        loop.append(after)
    return loop if len(loop) == rim == len(following) else None


def _from_least(loop):
    at = loop.index(min(loop))
    return tuple(loop[at:] + loop[:at])


def _polyhedron(points, loops):
    used = sorted({corner for loop in loops for corner in loop})
    number = {corner: i for i, corner in enumerate(used)}
    facets = tuple(tuple(number[corner] for corner in loop) for loop in loops)
    vertices = points[used]
    normals, offsets = [], []
    side_of = {}
    for facet, loop in enumerate(facets):
        corners = vertices[list(loop)]
        middle = corners.mean(axis=0)
        normal = np.cross(corners - middle, np.roll(corners, -1, axis=0) - middle).sum(axis=0)
        normal /= np.linalg.norm(normal)
        normals.append(normal)
        offsets.append(heights(corners, normal).max())
        side_of.update({(loop[i - 1], loop[i]): facet for i in range(len(loop))})
    edges = [
        (facet, side_of[v, u], u) for (u, v), facet in side_of.items() if facet < side_of[v, u]
    ]
    return Polyhedron(
        np.array(normals), np.array(offsets), vertices, facets, np.array(sorted(edges))
    )
