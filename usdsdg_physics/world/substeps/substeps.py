"""Substeps of a step: more where joints swing, where small bodies touch, near meshes, and of fast bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.substeps.fast_bodies import FastBodies
from usdsdg_physics.world.substeps.small_bodies import SmallBodies
from usdsdg_physics.world.substeps.swinging_joints import SwingingJoints
from usdsdg_physics.world.substeps.triangle_meshes import TriangleMeshes

if TYPE_CHECKING:
    import newton

# A step of 1/60 s takes two substeps, the 1/320 s steps of motion blur one.
SUBSTEPS_PER_SECOND = 120.0
# Joint coordinates are integrated with an error of first order, and what grippers hold needs short steps.
JOINT_FACTOR = 2


def ordinary_substeps(dt: float, *, rate: float = SUBSTEPS_PER_SECOND) -> int:
    """Return how many substeps a step of `dt` seconds has away from triangle meshes."""
    return max(1, math.ceil(dt * rate - 1e-6))


class Substeps:
    """How many substeps the steps of a world take."""

    def __init__(self, scene: Scene, model: newton.Model, shape_index: Mapping[str, int], *, jointed: bool) -> None:
        """`jointed` tells whether joints act in the world."""
        self._factor = JOINT_FACTOR if jointed else 1
        self._meshes = TriangleMeshes(scene, shape_index)
        self._small = SmallBodies(scene, model, SUBSTEPS_PER_SECOND)
        self._swinging = SwingingJoints(model, [scene.halves.get(path, path) for path in scene.bodies])
        self._fast = FastBodies(scene, model)
        self._any = bool(scene.bodies)

    @property
    def vary(self) -> bool:
        """Whether it matters where bodies are, and how fast."""
        return self._any and bool(self._meshes or self._small or self._swinging or self._fast)

    @property
    def triple_axes(self) -> np.ndarray:
        """Where the axes of joints with three axes of rotation are in `joint_qd`."""
        return self._swinging.triple_axes

    def least(self, dt: float) -> int:
        """Return how many substeps a step of `dt` seconds has at least."""
        return self._factor * ordinary_substeps(dt)

    def of_step(
        self,
        dt: float,
        poses: np.ndarray,
        velocities: np.ndarray,
        *,
        speeds: np.ndarray,
        targets: Mapping[int, np.ndarray],
        held: np.ndarray,
        is_pushed: bool,
    ) -> int:
        """Return how many substeps a step of `dt` seconds takes, with poses (N, 7) and velocities (N, 6) of all bodies.

        Args:
            speeds: (A,) of the `triple_axes` of joints [rad/s].
            targets: poses (7,) of kinematic bodies, by index, at the end of the step.
            held: (N,) which bodies are held at rest.
            is_pushed: whether a body moves by something else than its velocity and gravity.
        """
        count = ordinary_substeps(dt)
        if self._small:
            more = self._small.most if is_pushed else self._small.factor(dt, poses, velocities, held)
            count = ordinary_substeps(dt, rate=more * SUBSTEPS_PER_SECOND)
        if self._meshes:
            count = self._meshes.substeps(dt, poses, velocities, targets, count)
        least = self.least(dt)
        if self._swinging:
            least *= self._swinging.factor(dt, dt / least, poses, velocities, speeds)
        count = max(least, count)
        if self._fast:
            count = self._fast.substeps(dt, poses, _with_targets(velocities, poses, targets, dt), count)
        return count

    def set_static_poses(self, poses: Mapping[int, Sequence[float]]) -> None:
        """Note that static colliders were moved, by shape index (7 numbers, world)."""
        self._meshes.set_poses(poses)
        self._small.update_static()
        self._fast.update_static()

    def set_gravity(self, gravity: np.ndarray, enabled: np.ndarray) -> None:
        """Note the scene's gravity (3,) [m/s²], and on which bodies it acts (N,)."""
        self._small.set_gravity(gravity, enabled)

    def forget_rest(self) -> None:
        """Note that bodies are let go for another reason than their own motion."""
        self._small.forget_rest()


def _with_targets(
    velocities: np.ndarray, poses: np.ndarray, targets: Mapping[int, np.ndarray], dt: float
) -> np.ndarray:
    """Return velocities (N, 6) with those, linear, of kinematic bodies on their way to `targets`."""
    found = velocities.copy()
    for row, pose in targets.items():
        found[row, :3] = (pose[:3] - poses[row, :3]) / dt
    return found
