"""Angles and directions, the same to the last bit in every run.

numpy's cosine is not used: its last bit depends on where its arrays lie in memory.
"""

import math

import numpy as np

GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))


def cosine_and_sine(angles):
    """Of an array of angles (radians)."""
    flat = np.ravel(angles).tolist()
    shape = np.shape(angles)
    return (
        np.array([math.cos(angle) for angle in flat]).reshape(shape),
        np.array([math.sin(angle) for angle in flat]).reshape(shape),
    )


def fibonacci(count):
    """Directions spread evenly over the sphere."""
    height = 1 - (2 * np.arange(count) + 1) / count
    ring = np.sqrt(1 - height**2)
    cosine, sine = cosine_and_sine(GOLDEN_ANGLE * np.arange(count))
    return np.column_stack([ring * cosine, ring * sine, height])
