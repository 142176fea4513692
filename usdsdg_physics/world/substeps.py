"""Substeps of a step: more where joints are and swing, where small bodies touch something, and near triangle meshes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.extents import half_thickness, world_box
from usdsdg_physics.scene.records import STATIC, Scene
from usdsdg_physics.world.small_bodies import SmallBodies
from usdsdg_physics.world.swinging_joints import SwingingJoints

if TYPE_CHECKING:
    import newton

# A step of 1/60 s takes two substeps, the 1/320 s steps of motion blur one.
SUBSTEPS_PER_SECOND = 120.0
# Joint coordinates are integrated with an error of first order, and what grippers hold needs short steps.
JOINT_FACTOR = 2
# A triangle mesh has no inside that would push a body back out, so near one no body may travel farther in a substep
# than this fraction of its half thickness, at up to this many substeps for each ordinary one.
MAX_TRAVEL = 0.5
MAX_SUBSTEP_FACTOR = 4
NEAR_DISTANCE = 0.5  # m


def ordinary_substeps(dt: float, *, rate: float = SUBSTEPS_PER_SECOND) -> int:
    """Return how many substeps a step of `dt` seconds has away from triangle meshes."""
    return max(1, math.ceil(dt * rate - 1e-6))


class Substeps:
    """How many substeps the steps of a world take."""

    def __init__(self, scene: Scene, model: newton.Model, shape_index: Mapping[str, int], *, jointed: bool) -> None:
        """`jointed` tells whether joints act in the world."""
        self._factor = JOINT_FACTOR if jointed else 1
        self._meshes = StaticMeshes(scene, shape_index)
        self._small = SmallBodies(scene, model, SUBSTEPS_PER_SECOND)
        self._swinging = SwingingJoints(model)
        # Whether it matters where bodies are, and how fast.
        self.vary = bool(scene.bodies) and bool(self._meshes or self._small or self._swinging)

    def least(self, dt: float) -> int:
        """Return how many substeps a step of `dt` seconds has at least."""
        return self._factor * ordinary_substeps(dt)

    def of_step(
        self, dt: float, poses: np.ndarray, velocities: np.ndarray, *, held: np.ndarray, is_pushed: bool
    ) -> int:
        """Return how many substeps a step of `dt` seconds takes, with poses (N, 7) and velocities (N, 6) of all bodies.

        Args:
            held: (N,) which bodies are held at rest.
            is_pushed: whether a body moves by something else than its velocity and gravity.
        """
        count = ordinary_substeps(dt)
        if self._small:
            more = self._small.most if is_pushed else self._small.factor(dt, poses, velocities, held)
            count = ordinary_substeps(dt, rate=more * SUBSTEPS_PER_SECOND)
        if self._meshes:
            count = self._meshes.substeps(dt, poses[:, :3], velocities[:, :3], count)
        least = self.least(dt)
        if self._swinging:
            least *= self._swinging.factor(dt / least, poses, velocities)
        return max(least, count)

    def set_static_poses(self, poses: Mapping[int, Sequence[float]]) -> None:
        """Note that static colliders were moved, by shape index (7 numbers, world)."""
        self._meshes.set_poses(poses)
        self._small.update_static()

    def forget_rest(self) -> None:
        """Note that bodies are let go for another reason than their own motion."""
        self._small.forget_rest()


class StaticMeshes:
    """The boxes of static triangle meshes, and how thin the bodies are that could tunnel through them."""

    def __init__(self, scene: Scene, shape_index: Mapping[str, int]) -> None:
        self._shapes = {
            shape_index[c.path]: c.shape
            for c in scene.colliders.values()
            if c.shape.kind == "mesh" and c.body == STATIC
        }
        thickness = dict.fromkeys(scene.bodies, np.inf)
        for collider in scene.colliders.values():
            if collider.body:
                thickness[collider.body] = min(thickness[collider.body], half_thickness(collider.shape))
        self._half_thickness = np.array(list(thickness.values()))
        self._update_boxes()

    def __len__(self) -> int:
        return len(self._shapes)

    def set_poses(self, poses: Mapping[int, Sequence[float]]) -> None:
        """Move those of the shapes that are meshes, by shape index (7 numbers, world)."""
        for index in poses.keys() & self._shapes.keys():
            x, y, z, *rotation = poses[index]
            self._shapes[index] = replace(self._shapes[index], position=(x, y, z), rotation=tuple(rotation))
        self._update_boxes()

    def substeps(self, dt: float, positions: np.ndarray, velocities: np.ndarray, count: int) -> int:
        """Return how many substeps bodies need at `positions` (N, 3) [m] with linear `velocities` (N, 3) [m/s].

        That is at least `count`, which they need away from meshes.
        """
        at = positions[:, None]
        near = ((at > self._boxes[:, 0] - NEAR_DISTANCE) & (at < self._boxes[:, 1] + NEAR_DISTANCE)).all(axis=2)
        travel = np.linalg.norm(velocities, axis=1) * dt
        needed = np.where(np.any(near, axis=1), np.nan_to_num(travel / (MAX_TRAVEL * self._half_thickness)), 0.0).max()
        return int(np.clip(np.ceil(needed), count, count * MAX_SUBSTEP_FACTOR))

    def _update_boxes(self) -> None:
        """Compute lower and upper corners (M, 2, 3)."""
        self._boxes = np.array([world_box(shape) for shape in self._shapes.values()]).reshape(-1, 2, 3)
