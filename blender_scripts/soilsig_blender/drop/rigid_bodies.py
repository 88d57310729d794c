"""Rigid bodies in a tray, stepped by Bullet until they rest."""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix

from ..common.events import progress

# Friction of every body. Bullet multiplies the two of a contact: 0.36 between grains.
_FRICTION = 0.6
_RESTITUTION = 0.05
# Damping while the grains fall and find their places.
_DAMPING = 0.1
# Afterwards contacts still jitter and grains still creep. So inertia is taken away once the grains
# have fallen and nearly stopped, or once half of the frames are spent: Bullet then forgets every
# velocity at each step, and an unsupported grain sinks by g dt2. Earlier would give a looser bed: a
# bed packs while it rattles. Energies are means as a share of m g d, speeds shares of sqrt(g d).
_FALLING_ENERGY = 1e-3
_SLOW_ENERGY = 1e-4
_SLOW_SPEED = 0.3
_FULL_DAMPING = 1.0
# A grain's movement as a share of that sinking is the share of its weight that no contact carries.
# The bed rests when the mean is below the first number and every grain is below the second, for
# several frames in a row. A single grain that creeps does not delay this; one that falls does.
REST_MEAN = 0.2
REST_WORST = 0.9
REST_FRAMES = 3


@dataclass(frozen=True)
class Rest:
    """How the grains came to rest, or did not."""

    poses: np.ndarray  # (N, 4, 4) units
    settled: bool
    frames: int
    top_speed: float  # sqrt(g d)
    mean_energy: float  # m g d
    history: list  # poses at the start and after each frame
    # Mean and greatest movement in the last frame, as shares of the sinking of an unsupported grain
    unsupported: tuple


class World:
    """An empty Blender scene with a tray; lengths in Bullet's units."""

    def __init__(self, tray, height, settings):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.tray = np.array(tray)
        self.height = height
        self.settings = settings
        self.bodies = []
        # The bodies once more, in the same order: Blender gives their poses all at once.
        self.grains = bpy.data.collections.new("grains")
        self.parts = []

    def add(self, name, mesh, pose):
        """A grain: a mesh in a pose."""
        body = bpy.data.objects.new(name, mesh)
        body.matrix_world = Matrix(pose.tolist())
        self.bodies.append(body)
        self.grains.objects.link(body)
        return body

    def add_part(self, body, mesh, pose):
        """A part of a grain, in the grain's own coordinates."""
        part = bpy.data.objects.new(f"{body.name}_part", mesh)
        part.parent = body
        part.matrix_local = Matrix(pose.tolist())
        self.parts.append(part)

    def run(self, masses, collision_shape, margin, sinking=None) -> Rest:
        """Steps until rest for several frames.

        With `sinking` the grains lie already and have no inertia: an unsupported grain goes down by
        that much in a frame, and rest for one frame is enough.
        """
        self._make_rigid(masses, collision_shape, margin)
        self._damp(_FULL_DAMPING if sinking else _DAMPING)
        return self._step(sinking)

    def _make_rigid(self, masses, collision_shape, margin):
        scene = bpy.context.scene
        scene.gravity = (0, 0, -self.settings["gravity"])
        bpy.ops.rigidbody.world_add()
        world = scene.rigidbody_world
        world.collection = bpy.data.collections.new("drop")
        scene.collection.children.link(world.collection)
        world.substeps_per_frame = self.settings["substeps"]
        world.solver_iterations = self.settings["iterations"]
        world.point_cache.frame_end = self.settings["max_frames"]
        walls = self._walls()
        _join(world, self.bodies + walls)
        for body, mass in zip(self.bodies, masses):
            _shape(body, collision_shape, margin)
            body.rigid_body.mass = mass
        for wall in walls:
            wall.rigid_body.type = "PASSIVE"
            wall.rigid_body.collision_shape = "BOX"
        # Parts follow their bodies: otherwise Blender warns of a cycle for each.
        _join(world, self.parts)
        for part in self.parts:
            _shape(part, "CONVEX_HULL", margin)
        for o in self.bodies + walls:
            o.rigid_body.friction = _FRICTION
            o.rigid_body.restitution = _RESTITUTION

    def _damp(self, damping):
        for body in self.bodies:
            body.rigid_body.linear_damping = body.rigid_body.angular_damping = damping

    def _walls(self):
        """Floor and four walls, as thick as the tray is wide so that nothing tunnels through."""
        thick = float(self.tray.max())
        high = self.height
        x, y = map(float, self.tray)
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
            corners = [half * (a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
            wall = bpy.data.objects.new(name, mesh_of(name, corners))
            wall.location = middle
            walls.append(wall)
        return walls

    def _step(self, sinking):
        scene = bpy.context.scene
        most = self.settings["max_frames"]
        seconds = scene.render.fps_base / scene.render.fps
        gravity, diameter = self.settings["gravity"], self.settings["scale"]
        free_fall = np.sqrt(gravity * diameter)
        calm_frames = 1 if sinking else REST_FRAMES
        fell, calm, without_inertia = bool(sinking), 0, bool(sinking)
        if sinking:
            scene.gravity = (0, 0, -sinking * self.settings["substeps"] / seconds**2)
        else:
            sinking = gravity * seconds**2 / self.settings["substeps"]
        poses = self._poses()
        history = [poses]
        for frame in range(1, most + 1):
            scene.frame_set(frame)
            before, poses = poses, self._poses()
            history.append(poses)
            moved = np.linalg.norm(poses[:, :3, 3] - before[:, :3, 3], axis=1)
            speeds = moved / seconds / free_fall
            energy = (speeds**2).mean() / 2
            # The first frames are still: Bullet has not begun to step.
            fell = fell or energy > _FALLING_ENERGY
            if without_inertia:
                share = moved / sinking
                at_rest = frame > 3 and share.mean() < REST_MEAN and share.max() < REST_WORST
                calm = calm + 1 if at_rest else 0
            elif fell or frame > most / 2:
                slow = energy < _SLOW_ENERGY and speeds.max() < _SLOW_SPEED
                if slow or frame > most / 2:
                    self._damp(_FULL_DAMPING)
                    without_inertia = True
            if frame % 5 == 0:
                progress("drop", frame, most)
            if calm >= calm_frames or self._lost(poses):
                break
        settled = calm >= calm_frames
        unsupported = float((moved / sinking).mean()), float((moved / sinking).max())
        speed, energy = float(speeds.max()), float(energy)
        return Rest(poses, settled, frame, speed, energy, history, unsupported)

    def _poses(self):
        flat = np.empty(16 * len(self.bodies), np.float32)
        self.grains.objects.foreach_get("matrix_world", flat)
        # Blender's matrices lie column by column.
        return flat.reshape(-1, 4, 4).transpose(0, 2, 1).astype(float)

    def _lost(self, poses):
        """Whether a grain has no finite place or is far outside: to go on would be of no use."""
        middle = poses[:, :3, 3]
        far = np.append(2 * self.tray, 2 * self.height)
        return not np.isfinite(poses).all() or bool(((middle < -far) | (middle > 2 * far)).any())


def _join(world, objects):
    """Makes objects rigid bodies through the world's collection, without an operator for each.

    They are added all at once, because every change to a collection visits all objects.
    """
    members = bpy.data.collections.new("members")
    for o in objects:
        members.objects.link(o)
    world.collection.children.link(members)
    world.collection = world.collection


def mesh_of(name, vertices, triangles=()):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices).tolist(), [], np.asarray(triangles).tolist())
    return mesh


def _shape(o, collision_shape, margin):
    o.rigid_body.type = "ACTIVE"
    o.rigid_body.collision_shape = collision_shape
    o.rigid_body.mesh_source = "BASE"
    o.rigid_body.use_margin = True
    o.rigid_body.collision_margin = margin
