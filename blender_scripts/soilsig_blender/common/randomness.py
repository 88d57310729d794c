"""Random numbers that belong to a purpose, so that changing one part leaves the rest alone."""

import numpy as np


def stream(seed, *purpose):
    """A counter-based generator for one purpose, named by strings and integers.

    Every grain class draws from streams of its own: adding a class, or fines to a class, does not
    reshuffle the others.
    """
    key = "/".join(str(part) for part in purpose)
    return np.random.Generator(np.random.Philox(np.random.SeedSequence([seed, *key.encode()])))


def shuffled(rng, count):
    """The integers below `count` in random order."""
    return np.argsort(rng.random(count), kind="stable")
