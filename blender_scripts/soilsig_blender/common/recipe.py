"""Reading the recipe of a bed. `soilsig` has checked it before Blender starts."""

import json
import os


def load(path):
    """The whole scene and its packing, whose folder of own grains is made absolute."""
    with open(path, encoding="utf-8") as file:
        scene = json.load(file)
    packing = scene["geometry"]["packing"]
    if packing.get("library") is not None:
        packing["library"] = os.path.join(os.path.dirname(path), packing["library"])
    return scene, packing


def is_own(shape):
    """Whether a class's bodies are grains of the user's own."""
    return isinstance(shape, dict) and "library" in shape


def whole_rounds(number, shape):
    """The number of bodies of a class. Own grains are taken in turn, each of them as often."""
    names = len(shape["library"]) if is_own(shape) else 1
    return -(-number // names) * names


def variant_count(packing, grain):
    """How many different grains of a class are modelled, but no more than are dropped."""
    return min(whole_rounds(packing["variants"], grain["shape"]), grain["count"])
