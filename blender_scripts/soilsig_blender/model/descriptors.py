"""Shape descriptors of convex bodies, by the definitions of the sand-grain literature.

Elongation I/L and flatness S/I: L is the longest Feret (caliper) diameter in any direction, I the
longest across it, S the one across both (Krumbein, J. Sediment. Petrol. 11, 64, 1941; Sneed and
Folk, J. Geol. 66, 114, 1958; named as in Blott and Pye, Sedimentology 55, 31, 2008).

Sphericity: surface of the sphere of equal volume over that of the body (Wadell, J. Geol. 40, 443,
1932).

Roundness: mean radius of the corners of a silhouette over that of its largest inscribed circle
(Wadell, as before), the mean of three silhouettes across one another (Blott and Pye). A corner is
where the outline curves more than that circle (Zheng and Hryciw, Geotechnique 65, 494, 2015). A
polygon's corners are points: how round they are depends on the resolution at which the outline is
seen, here `RESOLUTION`. A square then has .077, a hexagon .100.
"""

import numpy as np

from .polyhedron import heights

# The outline's turning is averaged over a Gaussian along it: its standard deviation as a share of
# the perimeter. For corners of 30 to 60 degrees this equals the local quadratic smoothing of image
# analysis over a window of 6 % of the outline.
RESOLUTION = 0.006
# Places on the outline where its curvature is taken: six for each standard deviation.
_PLACES = 1000
# So many of them to either side of a corner show its turning.
_FELT = 50

# Lower limits of the classes of roundness (Powers, J. Sediment. Petrol. 23, 117, 1953).
POWERS = (
    (0.70, "well rounded"),
    (0.49, "rounded"),
    (0.35, "subrounded"),
    (0.25, "subangular"),
    (0.17, "angular"),
    (0.0, "very angular"),
)


def feret_axes(points):
    """Feret diameters L, I, S of the hull of points, and their directions as rows: right-handed."""
    longest = _farthest_apart(points)
    length = np.linalg.norm(longest)
    along = longest / length
    flat = points - np.outer(heights(points, along), along)
    across = _farthest_apart(flat)
    breadth = np.linalg.norm(across)
    across /= breadth
    through = np.cross(along, across)
    return np.array([length, breadth, np.ptp(heights(points, through))]), np.array(
        [along, across, through]
    )


def elongation_and_flatness(points):
    length, breadth, thickness = feret_axes(points)[0]
    return float(breadth / length), float(thickness / breadth)


def sphericity(body):
    volume = body.volume_and_centroid[0]
    surface = body.facet_areas_and_centroids[0].sum()
    return float(np.pi ** (1 / 3) * (6 * volume) ** (2 / 3) / surface)


def roundness(body):
    """Wadell's roundness, the mean of the silhouettes along the body's L, I and S."""
    if body.is_convex:
        return float(
            np.mean([roundness_of(outline(body.vertices @ view.T)) for view in views(body)])
        )
    from .hollow_outline import Outline

    outlines = [Outline(body, view) for view in views(body)]
    return float(np.mean([roundness_of(o.corners, o.inscribed_radius) for o in outlines]))


def views(body):
    """The two directions across each of the body's L, I and S, as rows."""
    axes = feret_axes(body.outermost)[1]
    return [np.roll(axes, -i - 1, axis=0)[:2] for i in range(3)]


def roundness_class(value):
    return next(name for limit, name in POWERS if value >= limit)


def roundness_of(corners, radius=None):
    """Wadell's roundness of a polygon, given counter-clockwise, at `RESOLUTION`.

    `radius` is that of its inscribed circle; without it the polygon has to be convex.
    """
    radius = radius or inscribed_radius(corners)
    curvature = _curvature(corners)
    sharp = curvature > 1 / radius
    if sharp.all() or not sharp.any():
        return 1.0
    # Begin where the outline is straight, so that no corner is cut in two.
    start = int(np.argmin(sharp))
    sharp, curvature = np.roll(sharp, -start), np.roll(curvature, -start)
    corner = np.cumsum(np.diff(sharp.astype(int), prepend=0) == 1)
    sharpest = np.zeros(corner[-1] + 1)
    np.maximum.at(sharpest, corner[sharp], curvature[sharp])
    return float(np.mean(1 / sharpest[1:]) / radius)


def outline(points):
    """The convex hull of points in a plane, counter-clockwise."""
    order = [tuple(p) for p in points[np.lexsort(points.T[::-1])].tolist()]
    lower, upper = _chain(order), _chain(order[::-1])
    return np.array(lower[:-1] + upper[:-1])


def inscribed_radius(corners):
    """Radius of the largest circle within a convex polygon, given counter-clockwise.

    Three sides hold the circle. As long as another side cuts into it, that side takes the place of
    the one of the three which gives way (the dual simplex method).
    """
    ahead = np.roll(corners, -1, axis=0) - corners
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    normals = np.column_stack([ahead[:, 1], -ahead[:, 0]])
    sides = np.column_stack([normals, np.ones(len(normals))])
    offsets = np.einsum("ij,ij->i", normals, corners)
    turned = np.arctan2(normals @ ahead[0], normals @ normals[0]) % (2 * np.pi)
    last = int(np.flatnonzero(turned[1:] < np.pi - 1e-9)[-1]) + 1
    held = [0, last, last + 1]
    for _ in range(10 * len(sides)):
        circle = np.linalg.solve(sides[held], offsets[held])
        room = offsets - sides @ circle
        cut = int(np.argmin(room))
        if room[cut] > -1e-9 * np.ptp(corners):
            break
        push = np.linalg.solve(sides[held].T, np.array([0, 0, 1.0]))
        share = np.linalg.solve(sides[held].T, sides[cut])
        ratio = np.where(share > 1e-12, push / np.where(share > 1e-12, share, 1), np.inf)
        held[int(np.argmin(ratio))] = cut
    return float(circle[2])


def _curvature(corners):
    """Curvature along a convex outline, its turning averaged at `RESOLUTION`."""
    ahead = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(ahead, axis=1)
    perimeter = lengths.sum()
    heading = np.arctan2(ahead[:, 1], ahead[:, 0])
    turn = (heading - np.roll(heading, 1) + np.pi) % (2 * np.pi) - np.pi
    place = (np.cumsum(lengths) - lengths) / perimeter
    # Further than eight standard deviations away a corner is not felt.
    at = np.round(place * _PLACES).astype(int)[:, None] + np.arange(-_FELT, _FELT + 1)
    weight = np.exp(-0.5 * ((at / _PLACES - place[:, None]) / RESOLUTION) ** 2)
    weight *= turn[:, None] / (np.sqrt(2 * np.pi) * RESOLUTION)
    return np.bincount((at % _PLACES).ravel(), weight.ravel(), _PLACES) / perimeter


def _farthest_apart(points):
    """The vector between the two points that are farthest apart."""
    squares = np.einsum("ij,ij->i", points, points)
    apart = squares[:, None] + squares - 2 * points @ points.T
    one, two = np.unravel_index(np.argmax(apart), apart.shape)
    return points[one] - points[two]


def _chain(points):
    chain = []
    for x, y in points:
        while len(chain) > 1:
            (ax, ay), (bx, by) = chain[-2:]
            if (bx - ax) * (y - by) - (by - ay) * (x - bx) > 0:
                break
            chain.pop()
        chain.append((x, y))
    return chain
