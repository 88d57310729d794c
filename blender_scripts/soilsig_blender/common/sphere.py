"""The unit sphere as triangles."""

import numpy as np


def sphere(halvings):
    """8 x 4^halvings triangles on the unit sphere: corners and triangles."""
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array([(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2)])
    faces = np.vstack([faces, np.where(faces == 2, 5, faces)[:, [1, 0, 2]]])
    for _ in range(halvings):
        sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        ends, number = np.unique(sides, axis=0, return_inverse=True)
        middle = vertices[ends].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1)[:, None]
        p, q, r = number.reshape(-1, 3).T + len(vertices)
        a, b, c = faces.T
        parts = ((a, p, r), (p, b, q), (r, q, c), (p, q, r))
        faces = np.vstack([np.column_stack(part) for part in parts])
        vertices = np.vstack([vertices, middle])
    return vertices, faces
