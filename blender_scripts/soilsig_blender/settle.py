"""The drop: dusty grains fall into a tray as rigid bodies until they rest.

Bullet is at home with lengths of a few units, so a mean grain diameter is made that long. The
choice of gravity is free: a bed of hard grains under friction looks the same at any length scale
once time is scaled with its square root, so only the clock differs from that of the real grains.
"""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Quaternion

from .errors import RecipeError
from .hull import reduced_hull
from .progress import progress
from .randomness import shuffled, stream

# Length of the mean grain diameter in Bullet's units, and gravity in units/s2: at 24 frames a
# second a grain falls its own diameter in 9 frames.
_DIAMETER = 6.5
_GRAVITY = 98.1
# Bullet keeps hulls this far apart (units); without a margin every contact is a penetration to
# solve, three times slower. Half of it makes up for the points left out of the reduced hull, the
# other half is taken off the hull beforehand.
_MARGIN = 0.04
_FRICTION = 0.6
_RESTITUTION = 0.05
# Damping while the grains fall and find their places.
_DAMPING = 0.1
# Then contacts go on jittering and grains on creeping. So once the grains have fallen and all but
# stopped (mean kinetic energy as a share of m g d, top speed as a share of sqrt(g d)), or half of
# the frames are spent, the drop goes on without inertia: Bullet forgets every velocity at each
# step, and a grain that nothing holds sinks by g dt2. Sooner, and the bed would be looser: it packs
# while it rattles.
_FALLING_ENERGY = 1e-3
_SLOW_ENERGY = 1e-4
_SLOW_SPEED = 0.3
_FULL_DAMPING = 1.0
# At rest: what a grain still moves, as a share of that sinking, is the share of its weight that no
# contact carries. It is to be below the first number on the mean and below the second for every
# grain, for some frames on end. So a grain that creeps alone does not hold the others up, one that
# falls does.
_REST_MEAN = 0.2
_REST_WORST = 0.9
_REST_FRAMES = 3


@dataclass(frozen=True)
class Drop:
    """Where the grains came to lie, and how they got there."""

    prototype_of: np.ndarray  # (N,) index of the prototype
    poses: np.ndarray  # (N, 4, 4) micrometres
    settled: bool
    frames: int
    top_speed: float  # sqrt(g d)
    mean_energy: float  # m g d


def drop(prototypes, packing) -> Drop:
    rng = stream(packing["seed"], "drop")
    prototype_of = _which(packing, rng)
    diameters = np.array([p.grain_class["diameter_um"] for p in prototypes])
    unit_um = diameters[prototype_of].mean() / _DIAMETER
    radii = np.array([np.linalg.norm(p.outline, axis=1).max() for p in prototypes])
    room = 2 * radii[prototype_of].max()
    if min(packing["tray_um"]) < room:
        raise RecipeError(
            "geometry.packing.tray_um",
            f"is {packing['tray_um'][0]:g} x {packing['tray_um'][1]:g}, but the longest dusty "
            f"grain needs {room:.0f} to turn in",
            "widen the tray",
        )
    starts = _start_grid(radii[prototype_of], packing["tray_um"], rng)
    meshes = [_hull_mesh(p, unit_um) for p in prototypes]
    bodies = []
    for i, (p, start) in enumerate(zip(prototype_of, starts)):
        body = bpy.data.objects.new(f"body_{i}", meshes[p])
        body.matrix_world = Matrix.Translation(start / unit_um) @ _random_turn(rng).to_4x4()
        bodies.append(body)
    walls = _walls(np.array(packing["tray_um"]) / unit_um, starts[:, 2].max() / unit_um)
    masses = [prototypes[p].volume_um3 / unit_um**3 for p in prototype_of]
    _make_rigid(bodies, walls, masses, packing["drop"])
    poses, *how = _run(bodies, packing["drop"])
    poses[:, :3, 3] *= unit_um
    return Drop(prototype_of, poses, *how)


def _which(packing, rng):
    """Prototype of every grain: the variants of a class in turn, the classes well mixed."""
    chosen, place = [], []
    first = 0
    for grain in packing["grains"]:
        count = grain["count"]
        variants = min(packing["variants"], count)
        chosen.append(first + np.arange(count) % max(variants, 1))
        # Spread evenly over the bed rather than at random: the classes on top decide what is seen.
        place.append((np.arange(count) + rng.random(count)) / max(count, 1))
        first += variants
    chosen, place = np.concatenate(chosen), np.concatenate(place)
    return chosen[np.argsort(place, kind="stable")]


def _start_grid(radii, tray_um, rng):
    """Places on a jittered grid over the whole tray, level above level, spheres apart."""
    cell = 2.0 * radii.max()
    columns = np.maximum(1, np.floor(np.array(tray_um) / cell)).astype(int)
    sides = np.array(tray_um) / columns
    starts = np.empty((len(radii), 3))
    per_level = columns.prod()
    for first in range(0, len(radii), per_level):
        members = np.arange(first, min(first + per_level, len(radii)))
        cells = shuffled(rng, per_level)[: len(members)]
        corner = np.column_stack([cells % columns[0], cells // columns[0]]) * sides
        room = np.maximum(sides - 2 * radii[members, None], 0)
        low = corner + (sides - room) / 2
        starts[members, :2] = low + room * rng.random((len(members), 2))
        starts[members, 2] = cell * (first // per_level) + radii[members]
    return starts


def _hull_mesh(prototype, unit_um):
    points = reduced_hull(prototype.outline / unit_um, _MARGIN / 2)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    mesh = bpy.data.meshes.new(prototype.name)
    mesh.from_pydata((points * (1 - _MARGIN / 2 / length)).tolist(), [], [])
    return mesh


def _make_rigid(bodies, walls, masses, settings):
    scene = bpy.context.scene
    scene.gravity = (0, 0, -_GRAVITY)
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection = bpy.data.collections.new("drop")
    world.substeps_per_frame = settings["substeps"]
    world.solver_iterations = settings["iterations"]
    world.point_cache.frame_end = settings["max_frames"]
    for o in bodies + walls:
        scene.collection.objects.link(o)
        world.collection.objects.link(o)
    # Members of the world's collection become rigid bodies here, without an operator for each.
    bpy.context.view_layer.update()
    for body, mass in zip(bodies, masses):
        body.rigid_body.type = "ACTIVE"
        body.rigid_body.collision_shape = "CONVEX_HULL"
        body.rigid_body.mesh_source = "BASE"
        body.rigid_body.mass = mass
        body.rigid_body.use_margin = True
        body.rigid_body.collision_margin = _MARGIN
    for wall in walls:
        wall.rigid_body.type = "PASSIVE"
        wall.rigid_body.collision_shape = "BOX"
    for o in bodies + walls:
        o.rigid_body.friction = _FRICTION
        o.rigid_body.restitution = _RESTITUTION
    _damp(bodies, _DAMPING)


def _damp(bodies, damping):
    for body in bodies:
        body.rigid_body.linear_damping = body.rigid_body.angular_damping = damping


def _walls(tray, top):
    """Floor and four walls, as thick as the tray is wide so that nothing tunnels through."""
    thick = float(tray.max())
    high = 2 * top + thick
    x, y = map(float, tray)
    boxes = [
        ("floor", (-thick, -thick, -thick), (x + thick, y + thick, 0)),
        ("west", (-thick, -thick, 0), (0, y + thick, high)),
        ("east", (x, -thick, 0), (x + thick, y + thick, high)),
        ("south", (0, -thick, 0), (x, 0, high)),
        ("north", (0, y, 0), (x, y + thick, high)),
    ]
    walls = []
    for name, low, up in boxes:
        middle, half = (np.array(low) + up) / 2, (np.array(up) - low) / 2
        mesh = bpy.data.meshes.new(name)
        corners = [half * (a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
        mesh.from_pydata([tuple(c) for c in corners], [], [])
        wall = bpy.data.objects.new(name, mesh)
        wall.location = middle
        walls.append(wall)
    return walls


def _random_turn(rng):
    """A rotation drawn evenly from all rotations."""
    a, b, c = rng.random(3)
    q = (
        np.sqrt(1 - a) * np.sin(2 * np.pi * b),
        np.sqrt(1 - a) * np.cos(2 * np.pi * b),
        np.sqrt(a) * np.sin(2 * np.pi * c),
        np.sqrt(a) * np.cos(2 * np.pi * c),
    )
    return Quaternion(q).to_matrix()


def _run(bodies, settings):
    """Steps until rest: poses, settled, frames, top speed and mean energy."""
    scene = bpy.context.scene
    seconds = scene.render.fps_base / scene.render.fps
    unit_energy = _GRAVITY * _DIAMETER
    sinking = _GRAVITY * seconds / settings["substeps"] / np.sqrt(unit_energy)
    poses = np.array([body.matrix_world for body in bodies])
    fell, damped, calm = False, False, 0
    for frame in range(1, settings["max_frames"] + 1):
        scene.frame_set(frame)
        before, poses = poses, np.array([body.matrix_world for body in bodies])
        moved = np.linalg.norm(poses[:, :3, 3] - before[:, :3, 3], axis=1)
        speeds = moved / seconds / np.sqrt(unit_energy)
        energy = (speeds**2).mean() / 2
        if damped:
            at_rest = speeds.mean() < _REST_MEAN * sinking and speeds.max() < _REST_WORST * sinking
            calm = calm + 1 if at_rest else 0
        elif fell:
            slow = energy < _SLOW_ENERGY and speeds.max() < _SLOW_SPEED
            if slow or frame > settings["max_frames"] / 2:
                _damp(bodies, _FULL_DAMPING)
                damped = True
        # The first frames are still: Bullet has not begun to step.
        fell = fell or energy > _FALLING_ENERGY
        if frame % 5 == 0:
            progress("drop", frame, settings["max_frames"])
        if calm >= _REST_FRAMES or not np.isfinite(poses).all():
            break
    return poses, calm >= _REST_FRAMES, frame, float(speeds.max()), float(energy)
