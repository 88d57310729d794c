"""Drop and check; a bed that fails is dropped once more with safer settings."""

from ..common.errors import BedError
from ..common.events import warning
from ..drop.settle import drop
from . import bed_check

# What a second try may cure. Anything else is wrong with the scene or with Blender.
_CURABLE = ("nan", "escaped", "not_settled", "overlap", "sunk", "floating")
# Length, gravity and margin that Bullet works best with. Steps become finer, and more.
_SAFE = {"scale": 6.5, "gravity": 98.1, "margin": 0.04}
_LEAST_SUBSTEPS = 12
_LEAST_ITERATIONS = 50


def settled_bed(prototypes, packing):
    """The drop, what the checks found, and every try with its settings and its outcome.

    Raises the `BedError` of the last try, with the reasons of all.
    """
    attempts = []
    for settings in (packing["drop"], safer(packing["drop"])):
        tried = {**packing, "drop": settings}
        try:
            dropped = drop(prototypes, tried, bool(attempts))
            found = bed_check.check(prototypes, dropped, tried)
        except BedError as error:
            if error.kind not in _CURABLE:
                raise
            attempts.append({"settings": settings, "outcome": error.kind, "reason": str(error)})
            if len(attempts) == 1:
                warning(f"the first drop failed: {error}; dropped again with safer settings")
            last = error
        else:
            attempts.append({"settings": settings, "outcome": "settled", "reason": None})
            return dropped, found, attempts
    first, second = attempts
    raise BedError(
        last.kind,
        f"{first['reason']}; dropped again with {_words(second['settings'])}: {second['reason']}",
        last.hint,
    )


def safer(settings):
    """The settings of the second try; what collides stays as in the recipe."""
    return {
        **settings,
        **_SAFE,
        "substeps": max(_LEAST_SUBSTEPS, 2 * settings["substeps"]),
        "iterations": max(_LEAST_ITERATIONS, settings["iterations"]),
        "max_frames": 2 * settings["max_frames"],
    }


def _words(settings):
    return ", ".join(f"{key} {value}" for key, value in settings.items() if key != "collision")
