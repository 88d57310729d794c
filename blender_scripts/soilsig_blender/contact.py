"""What of a dusty grain collides: its convex hull, its fines one by one, or its whole mesh."""

import math
from dataclasses import replace

import numpy as np

from .hull import Reach, reduced_hull
from .pieces import Pieces
from .rigid import World, mesh_of

# Fines collide one by one, and whole meshes, with this share of the margin, which stands between
# them. Their own corners are left where they are.
_FINE_MARGIN = 0.125
# In the contact phase those fines of a grain are parts of it that come this near to the hull of
# another grain or to the tray, as a share of the mean diameter. They are chosen anew when others
# have come to this share of it.
_NEAR = 0.08
_CLOSER = 0.25
_ROUNDS = 4
# Nothing moves fast without inertia, so that fewer steps do: this share of those of the fall.
_STEPS_SHARE = 1 / 3


def drop_hulls(prototypes, prototype_of, poses, tray, height, unit_um, settings):
    """Falls as convex hulls until rest."""
    world = World(tray, height, settings)
    meshes = [_hull_mesh(p, unit_um, settings["margin"]) for p in prototypes]
    _add(world, prototype_of, meshes, poses)
    masses = _masses(prototypes, prototype_of, unit_um)
    return world.run(masses, "CONVEX_HULL", settings["margin"], falling=True)


def drop_meshes(prototypes, prototype_of, poses, tray, height, unit_um, settings):
    """Falls as whole meshes until rest."""
    world = World(tray, height, settings)
    _add(world, prototype_of, [_whole_mesh(p, unit_um) for p in prototypes], poses)
    masses = _masses(prototypes, prototype_of, unit_um)
    return world.run(masses, "MESH", _FINE_MARGIN * settings["margin"], falling=True)


def sink_into_contact(prototypes, prototype_of, poses, tray, height, unit_um, settings):
    """From the rest of the hulls, without inertia, until fines rest on fines."""
    settings = {**settings, "substeps": math.ceil(settings["substeps"] * _STEPS_SHARE)}
    dusty = _Dusty(prototypes, prototype_of, tray, unit_um, _NEAR * settings["scale"])
    frames, history = 0, [poses]
    for _ in range(_ROUNDS):
        parts = dusty.near(poses, 1.0)
        rest = _sink(dusty, parts, poses, height, settings)
        frames += rest.frames
        history += rest.history[1:]
        poses = rest.poses
        closer = dusty.near(poses, _CLOSER) if rest.settled else parts
        if all(np.isin(new, old).all() for new, old in zip(closer, parts)):
            break
    return replace(rest, frames=frames, history=history)


def _sink(dusty, parts, poses, height, settings):
    prototypes, unit_um = dusty.prototypes, dusty.unit_um
    world = World(dusty.tray, height, settings)
    cores = [mesh_of(f"{p.name}_core", p.grain.vertices / unit_um) for p in prototypes]
    bodies = {
        (k, b): mesh_of(f"{fine.name}_{b}", body.vertices / unit_um)
        for k, fine in enumerate(prototypes[0].fines)
        for b, body in enumerate(fine.bodies)
    }
    _add(world, dusty.prototype_of, [mesh_of("grain", [(0, 0, 0)])] * len(prototypes), poses)
    for body, p, fines in zip(world.bodies, dusty.prototype_of, parts):
        dust = prototypes[p].dust
        world.add_part(body, cores[p], np.eye(4))
        for i in fines:
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = dust.rotation[i], dust.position[i] / unit_um
            world.add_part(body, bodies[dust.kind[i], dust.body[i]], pose)
    masses = _masses(prototypes, dusty.prototype_of, unit_um)
    return world.run(masses, "COMPOUND", _FINE_MARGIN * settings["margin"], falling=False)


def _add(world, prototype_of, meshes, poses):
    for i, (p, pose) in enumerate(zip(prototype_of, poses)):
        world.add(f"body_{i}", meshes[p], pose)


def _masses(prototypes, prototype_of, unit_um):
    return [prototypes[p].volume_um3 / unit_um**3 for p in prototype_of]


def _hull_mesh(prototype, unit_um, margin):
    """Half of the margin makes up for the points left out, the other half is taken off the hull."""
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
    """The grains with their fines, to find which of these are near to other grains."""

    def __init__(self, prototypes, prototype_of, tray, unit_um, reach):
        self.prototypes = prototypes
        self.prototype_of = prototype_of
        self.tray = tray
        self.unit_um = unit_um
        self._reach = reach
        pieces = [Pieces.of(prototype) for prototype in prototypes]
        self._centres = [piece.centre / unit_um for piece in pieces]
        self._outer = [piece.outer / unit_um for piece in pieces]
        self._radii = np.array([piece.radius for piece in pieces])[prototype_of] / unit_um
        self._hulls = [Reach(prototype.outline / unit_um) for prototype in prototypes]

    def near(self, poses, share):
        """For every grain its fines within a share of the reach of a grain's hull or the tray."""
        middle = poses[:, :3, 3]
        reach = share * self._reach
        chosen = []
        for i, p in enumerate(self.prototype_of):
            centre = self._centres[p] @ poses[i, :3, :3].T + middle[i]
            around = self._outer[p] + reach
            touching = np.hstack([centre, self.tray - centre[:, :2]]).min(axis=1) < around
            apart = np.linalg.norm(middle - middle[i], axis=1) - self._radii - self._radii[i]
            for j in np.flatnonzero(apart < reach):
                if j != i:
                    local = (centre - middle[j]) @ poses[j, :3, :3]
                    touching |= self._hulls[self.prototype_of[j]].away(local) < around
            chosen.append(np.flatnonzero(touching))
        return chosen
