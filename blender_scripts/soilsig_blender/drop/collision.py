"""What of a dusty grain collides: its convex hull, its fines one by one, or its whole mesh."""

import math
from dataclasses import replace

import numpy as np

from ..dust.reduced_hull import reduced_hull
from .near_fines import near_fines
from .rigid_bodies import World, mesh_of

# Share of the margin with which single fines and whole meshes collide. It is kept between them, and
# their corners stay in place.
_FINE_MARGIN = 0.125
# The rounds of the contact phase. First: how far an unsupported grain sinks in a frame. Second: how
# near to another grain or to the tray a fine must be to become a part of its grain's body. Both are
# shares of the mean diameter. Each fine costs time in every frame, and as much as a dozen frames
# when it becomes a part. So the first round has the fines that most grains may come upon on their
# way, the second those near their places. A second try has all that any grain may come upon.
_ROUNDS = ((0.075, 0.11), (0.012, 0.04))
_SECOND_TRY = ((0.05, 0.16), (0.012, 0.08))
# Without inertia nothing moves fast, so fewer steps are enough: this share of those of the fall.
_STEPS_SHARE = 1 / 2


def drop_hulls(prototypes, prototype_of, poses, tray, height, unit_um, settings):
    """Falls as convex hulls until rest."""
    world = World(tray, height, settings)
    meshes = [_hull_mesh(p, unit_um, settings["margin"]) for p in prototypes]
    _add(world, prototype_of, meshes, poses)
    masses = _masses(prototypes, prototype_of, unit_um)
    return world.run(masses, "CONVEX_HULL", settings["margin"])


def drop_meshes(prototypes, prototype_of, poses, tray, height, unit_um, settings):
    """Falls as whole meshes until rest."""
    world = World(tray, height, settings)
    _add(world, prototype_of, [_whole_mesh(p, unit_um) for p in prototypes], poses)
    masses = _masses(prototypes, prototype_of, unit_um)
    return world.run(masses, "MESH", _FINE_MARGIN * settings["margin"])


def sink_into_contact(
    prototypes, prototype_of, poses, tray, height, unit_um, settings, is_second_try
):
    """From the rest of the hulls, without inertia, until fines rest on fines."""
    settings = {**settings, "substeps": math.ceil(settings["substeps"] * _STEPS_SHARE)}
    dusty = _Dusty(prototypes, prototype_of, tray, unit_um)
    frames, history = 0, [poses]
    for sinking, reach in _SECOND_TRY if is_second_try else _ROUNDS:
        world = World(tray, height, settings)
        dusty.add_near(world, poses, reach * settings["scale"] * unit_um)
        margin = _FINE_MARGIN * settings["margin"]
        masses = _masses(prototypes, prototype_of, unit_um)
        rest = world.run(masses, "COMPOUND", margin, sinking * settings["scale"])
        frames += rest.frames
        history += rest.history[1:]
        poses = rest.poses
        if not rest.settled:
            break
    return replace(rest, frames=frames, history=history)


def _add(world, prototype_of, meshes, poses):
    for i, (p, pose) in enumerate(zip(prototype_of, poses)):
        world.add(f"body_{i}", meshes[p], pose)


def _masses(prototypes, prototype_of, unit_um):
    return [prototypes[p].volume_um3 / unit_um**3 for p in prototype_of]


def _hull_mesh(prototype, unit_um, margin):
    """Half of the margin makes up for the points left out. The other half is taken off the hull."""
    points = reduced_hull(prototype.outline / unit_um, margin / 2)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    return mesh_of(prototype.name, points * (1 - np.minimum(margin / 2 / length, 0.5)))


def _whole_mesh(prototype, unit_um):
    vertices, triangles, count = [], [], 0
    for surface in prototype.surfaces:
        vertices.append(surface.vertices / unit_um)
        triangles.append(surface.triangles + count)
        count += len(surface.vertices)
    return mesh_of(prototype.name, np.vstack(vertices), np.vstack(triangles))


class _Dusty:
    """The grains with their fines, to find which fines are near other grains."""

    def __init__(self, prototypes, prototype_of, tray, unit_um):
        self._prototypes = [prototypes[p] for p in prototype_of]
        self._tray_um = tray * unit_um
        self._unit_um = unit_um
        pieces = [prototype.solids for prototype in prototypes]
        self._pieces = [pieces[p] for p in prototype_of]
        self._radii = np.array([piece.radius for piece in self._pieces])

    def add_near(self, world, poses, reach_um):
        """Adds every grain as a body with its near fines as parts."""
        empty, meshes = mesh_of("grain", [(0, 0, 0)]), {}

        def mesh(body):
            if id(body) not in meshes:
                meshes[id(body)] = mesh_of("part", body.vertices / self._unit_um)
            return meshes[id(body)]

        near = self._near(poses, reach_um)
        for i, (prototype, pose, fines) in enumerate(zip(self._prototypes, poses, near)):
            grain = world.add(f"body_{i}", empty, pose)
            world.add_part(grain, mesh(prototype.grain.envelope), np.eye(4))
            dust = prototype.dust
            for k in fines:
                part = np.eye(4)
                part[:3, :3], part[:3, 3] = dust.rotation[k], dust.position[k] / self._unit_um
                world.add_part(
                    grain, mesh(prototype.fines[dust.kind[k]].bodies[dust.body[k]]), part
                )

    def _near(self, poses, reach_um):
        """For every grain its fines within reach of a piece of another grain or of the tray."""
        turns, middle = poses[:, :3, :3], poses[:, :3, 3] * self._unit_um
        found = []
        for one, turn, at in zip(self._pieces, turns, middle):
            corners = one.fines.corners @ turn.T + at
            inward = np.concatenate([corners, self._tray_um - corners[:, :, :2]], axis=2)
            found.append([np.flatnonzero(inward.min(axis=(1, 2)) < reach_um)])
        for i, one in enumerate(self._pieces):
            apart = np.linalg.norm(middle[:i] - middle[i], axis=1) - self._radii[:i] - one.radius
            for j in np.flatnonzero(apart < reach_um):
                turn, shift = turns[i].T @ turns[j], turns[i].T @ (middle[j] - middle[i])
                of_one, of_two = near_fines(one, self._pieces[j], turn, shift, reach_um)
                found[i].append(of_one)
                found[j].append(of_two)
        return [np.unique(np.concatenate(fines)) for fines in found]
