"""The velocity of static colliders that are moved while playing."""

from collections.abc import Mapping

import numpy as np

from usdsdg_physics.scene.extents import length
from usdsdg_physics.scene.records import STATIC, Scene
from usdsdg_physics.world.kinematic_motion import constant_velocity_motion

# What is moved by more in one step is put somewhere else.
MAX_SHIFT = 0.5  # times its length
MAX_TURN = np.radians(45.0)


class StaticMotion:
    """Finds out which static colliders move, step by step, and which are put somewhere once, as a camera may be."""

    def __init__(self, scene: Scene, shape_index: Mapping[str, int]) -> None:
        self._length = {
            shape_index[collider.path]: length(collider.shape)
            for collider in scene.colliders.values()
            if collider.body == STATIC and not collider.trigger
        }
        self._start: dict[int, np.ndarray] = {}
        self._end: dict[int, np.ndarray] = {}
        self._before: set[int] = set()  # that were moved in the step before

    def note(self, shape: int, start: np.ndarray, end: np.ndarray) -> None:
        """Note that a shape is moved from one pose (7,) [m] to another before the next step."""
        if shape in self._length:
            self._start.setdefault(shape, start.astype(np.float64))
            self._end[shape] = end.astype(np.float64)

    def take(self, dt: float) -> dict[int, np.ndarray]:
        """Return the motion (6,) of shapes, by index, in the next step of `dt` seconds.

        It is the velocity of the point at the world's origin [m/s], and the angular velocity [rad/s].
        """
        found = {}
        for shape, start in self._start.items():
            if shape not in self._before:
                continue
            _, velocity = constant_velocity_motion(start, self._end[shape], np.zeros(3), dt)
            linear, angular = velocity[:3], velocity[3:]
            within = np.linalg.norm(linear) * dt <= MAX_SHIFT * self._length[shape]
            if within and np.linalg.norm(angular) * dt <= MAX_TURN:
                found[shape] = np.concatenate([linear - np.cross(angular, start[:3]), angular])
        self._before = set(self._start)
        self._start, self._end = {}, {}
        return found
