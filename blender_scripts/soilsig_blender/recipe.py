"""Reading the scene file: what of it Blender needs, checked key by key."""

import json
import math
import os
import re

from .errors import BedError, RecipeError
from .library import NAME
from .shapes import MOST_RIBS, SHAPES

# Blender cuts longer names off; white space and '#' would break the .obj.
_NAME = re.compile(r"[^\s#]{1,40}")

# What of a dusty grain collides.
COLLISIONS = ("hull", "hull_then_fines", "mesh")


def load(path):
    """The whole scene and its packing, or an error that names the key."""
    try:
        with open(path, encoding="utf-8") as file:
            scene = json.load(file)
    except OSError as error:
        raise BedError(
            "scene", f"{path}: {error.strerror}", "give a scene file with --scene"
        ) from error
    except ValueError as error:
        raise BedError("scene", f"{path} is not JSON: {error}", "mend the file there") from error
    version = scene.get("soilsig_scene") if isinstance(scene, dict) else None
    if version != 1:
        raise RecipeError(
            "soilsig_scene", f"is {version!r}, not 1", "give a scene file of version 1"
        )
    geometry = scene.get("geometry")
    if not isinstance(geometry, dict) or set(geometry) != {"packing"}:
        raise RecipeError(
            "geometry", "holds no packing", "a placed scene needs no Blender: trace it as it is"
        )
    materials = {m.get("name") for m in scene.get("materials", []) if isinstance(m, dict)}
    packing = geometry["packing"]
    packing.setdefault("library", None)
    _check_packing(packing, materials)
    if packing["library"] is not None:
        packing["library"] = os.path.join(os.path.dirname(path), packing["library"])
    return scene, packing


def whole_rounds(number, shape):
    """So many bodies of a class, of a library so many more that each of its grains is as often
    among them."""
    names = len(shape["library"]) if isinstance(shape, dict) else 1
    return -(-number // names) * names


def variant_count(packing, grain):
    """How many different grains of a class are modelled, but no more than are dropped."""
    return min(whole_rounds(packing["variants"], grain["shape"]), grain["count"])


def _check_packing(packing, materials):
    where = "geometry.packing"
    keys = "seed library grains fines dust variants tray_um crop_um floor_material drop"
    _keys(packing, where, keys)
    _integer(packing, where, "seed", 0)
    _integer(packing, where, "variants", 1, 1000)
    _number(packing, where, "crop_um", 0)
    _one_of(packing, where, "floor_material", materials)
    if not isinstance(packing["library"], (str, type(None))):
        raise RecipeError(f"{where}.library", "is not a folder", "name a folder of grains")
    for i, grain in enumerate(_list(packing, where, "grains")):
        at = f"{where}.grains[{i}]"
        _keys(grain, at, "name shape diameter_um material count fines", "ribs")
        _common(grain, at, materials, packing)
        _integer(grain, at, "count", 0, 100_000)
        _check_fines_of(grain, at)
        if wants_fines(grain) and not packing["fines"]:
            raise RecipeError(
                f"{at}.fines",
                f"is {grain['fines']}, but there is no class of fines",
                f"describe them in {where}.fines, or ask for 0",
            )
    if sum(grain["count"] for grain in packing["grains"]) == 0:
        raise RecipeError(f"{where}.grains", "has no grain to drop", "raise a count")
    for i, fine in enumerate(_list(packing, where, "fines")):
        at = f"{where}.fines[{i}]"
        _keys(fine, at, "name shape diameter_um material share", "ribs")
        _common(fine, at, materials, packing)
        _number(fine, at, "share", 0)
    shares = sum(fine["share"] for fine in packing["fines"])
    if packing["fines"] and abs(shares - 1) > 1e-6:
        raise RecipeError(
            f"{where}.fines", f"has shares that add up to {shares:g}", "make them add up to 1"
        )
    _check_names(packing, where)
    _check_tray(packing, where)
    _keys(packing["dust"], f"{where}.dust", "layers overlap")
    _integer(packing["dust"], f"{where}.dust", "layers", 1, 100)
    _number(packing["dust"], f"{where}.dust", "overlap", 0, 1)
    _check_drop(packing["drop"], f"{where}.drop")


def _check_drop(drop, at):
    _keys(drop, at, "collision substeps iterations max_frames scale gravity margin")
    _one_of(drop, at, "collision", COLLISIONS)
    for key, most in (("substeps", 32767), ("iterations", 1000), ("max_frames", 100000)):
        _integer(drop, at, key, 1, most)
    for key in ("scale", "gravity", "margin"):
        _number(drop, at, key, 0)
    for key in ("scale", "gravity"):
        if drop[key] == 0:
            raise RecipeError(f"{at}.{key}", "is 0", "give a number above 0")


def wants_fines(grain):
    """Whether a class of grains asks for any."""
    fines = grain["fines"]
    return bool(fines["silhouette"] if isinstance(fines, dict) else fines)


def _check_fines_of(grain, at):
    if isinstance(grain["fines"], dict):
        _keys(grain["fines"], f"{at}.fines", "silhouette")
        _number(grain["fines"], f"{at}.fines", "silhouette", 0, 1)
    else:
        _integer(grain, at, "fines", 0, 100_000)


def _check_names(packing, where):
    seen = {}
    names = [
        (f"{where}.{kind}[{i}].name", c["name"])
        for kind in ("grains", "fines")
        for i, c in enumerate(packing[kind])
    ]
    variants = [
        (at, f"{name}_{v}")
        for (at, name), grain in zip(names, packing["grains"])
        for v in range(variant_count(packing, grain))
    ]
    for at, name in names + variants:
        if seen.setdefault(name, at) != at:
            raise RecipeError(
                at, f"makes the name {name!r}, as {seen[name]} does", "rename one of them"
            )


def _check_tray(packing, where):
    tray = packing["tray_um"]
    if not (isinstance(tray, list) and len(tray) == 2 and all(map(_is_number, tray))):
        raise RecipeError(
            f"{where}.tray_um", "is not a pair of lengths", "give [x, y] in micrometres"
        )
    widest = max(grain["diameter_um"] for grain in packing["grains"] if grain["count"])
    if min(tray) < widest:
        raise RecipeError(
            f"{where}.tray_um",
            f"is {tray[0]:g} x {tray[1]:g}, smaller than a grain of {widest:g}",
            "widen the tray",
        )
    if 2 * packing["crop_um"] >= min(tray):
        raise RecipeError(
            f"{where}.crop_um",
            f"of {packing['crop_um']:g} on both sides leaves nothing of the tray",
            "crop less",
        )


def _common(entry, at, materials, packing):
    name = entry["name"]
    if not (isinstance(name, str) and _NAME.fullmatch(name)):
        raise RecipeError(
            f"{at}.name", f"is {name!r}", "give up to 40 characters without white space or '#'"
        )
    if isinstance(entry["shape"], dict):
        _check_library(entry["shape"], f"{at}.shape", packing)
        if "ribs" in entry:
            raise RecipeError(f"{at}.ribs", "is asked of grains of the library", "leave it out")
    else:
        _one_of(entry, at, "shape", SHAPES)
        if "ribs" in entry:
            _integer(entry, at, "ribs", 0, MOST_RIBS)
    _one_of(entry, at, "material", materials)
    _number(entry, at, "diameter_um", 0)
    if entry["diameter_um"] == 0:
        raise RecipeError(f"{at}.diameter_um", "is 0", "give a length above 0")


def _check_library(shape, at, packing):
    _keys(shape, at, "library")
    if not _list(shape, at, "library"):
        raise RecipeError(f"{at}.library", "names no grain", "name those that the class has")
    for i, name in enumerate(shape["library"]):
        if not (isinstance(name, str) and NAME.fullmatch(name)):
            raise RecipeError(
                f"{at}.library[{i}]",
                f"is {name!r}",
                "give the name of a grain: up to 40 letters, digits, _ and -",
            )
    if packing["library"] is None:
        raise RecipeError(at, "is of a library, but there is none", "name its folder in library")


def _keys(entry, at, expected, optional=""):
    if not isinstance(entry, dict):
        raise RecipeError(at, "is not an object", "see `soilsig schema scene`")
    expected, optional = expected.split(), optional.split()
    known = expected + optional
    for key in sorted(set(entry) - set(known)):
        raise RecipeError(f"{at}.{key}", "is not a known key", f"known are {', '.join(known)}")
    for key in expected:
        if key not in entry:
            raise RecipeError(f"{at}.{key}", "is missing", "see `soilsig schema scene`")


def _list(entry, at, key):
    if not isinstance(entry[key], list):
        raise RecipeError(f"{at}.{key}", "is not a list", "see `soilsig schema scene`")
    return entry[key]


def _one_of(entry, at, key, known):
    if not (isinstance(entry[key], str) and entry[key] in known):
        raise RecipeError(
            f"{at}.{key}", f"is {entry[key]!r}", f"known are {', '.join(sorted(map(str, known)))}"
        )


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _number(entry, at, key, least, most=math.inf):
    if not _is_number(entry[key]) or not least <= entry[key] <= most:
        wanted = f"of at least {least}" if most == math.inf else f"from {least} to {most}"
        raise RecipeError(f"{at}.{key}", f"is {entry[key]!r}", f"give a number {wanted}")


def _integer(entry, at, key, least, most=2**53):
    value = entry[key]
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
        raise RecipeError(
            f"{at}.{key}", f"is {value!r}", f"give a whole number from {least} to {most}"
        )
