"""Convex bodies side by side: which planes they lie beyond, and where lines cross them.

Arrays of different lengths are padded by repetition, so that all bodies are handled at once.
"""

from dataclasses import dataclass

import numpy as np

from ..common.arrays import Columns, padded


@dataclass(frozen=True)
class PlacedBodies(Columns):
    """Bodies by the index of their shape, in their places."""

    shape: np.ndarray  # (N,)
    rotation: np.ndarray  # (N, 3, 3)
    position: np.ndarray  # (N, 3)
    centre: np.ndarray  # (N, 3) of mass


class Bodies:
    """Convex bodies about their own origins."""

    def __init__(self, bodies):
        self.vertices = padded([body.vertices for body in bodies])
        self.normals = padded([body.normals for body in bodies])
        self.offsets = padded([body.offsets for body in bodies], ())
        self.centre = np.array([body.volume_and_centroid[1] for body in bodies]).reshape(-1, 3)
        # Radii of the inner and the outer sphere about the centre.
        heights = self.offsets - turned(self.normals, self.centre)
        spokes = np.linalg.norm(self.vertices - self.centre[:, None], axis=2)
        self.inner, self.outer = heights.min(axis=1), spokes.max(axis=1)

    def placed(self, shape, rotation, position):
        return PlacedBodies(
            shape, rotation, position, turned(rotation, self.centre[shape]) + position
        )

    def at_origin(self, count):
        """The first shape unmoved, so many times."""
        unmoved = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))
        return self.placed(np.zeros(count, int), *unmoved)

    def beyond(self, normals, offsets, shape, rotation, position, slack):
        """Whether all of a body but a depth of `slack` lies outside one of its planes.

        The planes (N, F, 3), (N, F) and the pose of the body are in one frame; pair by pair.
        """
        centre = turned(rotation, self.centre[shape]) + position
        heights = turned(normals, centre) - offsets
        # The inner sphere has to lie outside as well, which leaves few planes.
        pair, plane = np.nonzero(heights > (self.inner[shape] - slack)[:, None])
        normal = normals[pair, plane]
        towards = turned(rotation[pair].transpose(0, 2, 1), normal)
        lowest = turned(self.vertices[shape[pair]], towards).min(axis=1)
        lowest += (normal * position[pair]).sum(axis=1) - offsets[pair, plane]
        found = np.zeros(len(shape), bool)
        found[pair[lowest >= -slack[pair]]] = True
        return found

    def crossings(self, origins, directions, placed):
        """Where lines enter and leave bodies, pair by pair; past the leaving if they miss."""
        back = placed.rotation.transpose(0, 2, 1)
        normals = self.normals[placed.shape]
        inward = -turned(normals, turned(back, directions))
        depth = turned(normals, turned(back, origins - placed.position))
        depth -= self.offsets[placed.shape]
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = depth / inward
        enter = np.where(inward > 0, crossing, -np.inf).max(axis=1)
        leave = np.where(inward < 0, crossing, np.inf).min(axis=1)
        outside = ((inward == 0) & (depth > 0)).any(axis=1)
        return np.where(outside, np.inf, enter), leave


def turned(matrices, vectors):
    return (matrices @ vectors[..., None])[..., 0]
