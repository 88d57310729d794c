"""Directions spread evenly over the sphere."""

import numpy as np

GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def fibonacci(count):
    height = 1 - (2 * np.arange(count) + 1) / count
    turn = GOLDEN_ANGLE * np.arange(count)
    ring = np.sqrt(1 - height**2)
    return np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
