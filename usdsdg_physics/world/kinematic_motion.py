"""Motion of kinematic bodies to the poses that users set."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp


class KinematicMotion:
    """Where the kinematic bodies are during the step that brings them to their targets."""

    def __init__(self, model: newton.Model, center: np.ndarray, coordinate: np.ndarray) -> None:
        """`center` (N, 3) is each body's center of mass in its frame [m], `coordinate` (N,) its place in joint_q."""
        import warp as wp

        self._coordinate = wp.array(coordinate, dtype=wp.int32, device=model.device)
        self._model, self._center = model, center
        self._targets: dict[int, np.ndarray] = {}
        self._moving: set[int] = set()  # that have the velocity with which they moved in the latest step
        self._row = wp.full(model.body_count, -1, dtype=wp.int32, device=model.device)
        self._poses: dict[int, wp.array] = {}  # (substeps, N), by the number of substeps

    def add_targets(self, targets: Mapping[int, np.ndarray]) -> None:
        """Set the poses (7,) that bodies, by index, reach by the end of the next step."""
        self._targets |= targets

    def note_velocities(self, bodies: Iterable[int]) -> None:
        """Note that bodies have got other velocities than that of their motion, which they keep."""
        self._moving -= set(bodies)

    def resume(self, bodies: Iterable[int]) -> None:
        """Note that bodies have the velocity with which they moved in a step before this world was built."""
        self._moving |= set(bodies)

    def finish(self) -> None:
        """Forget the targets, at the end of the step.

        What was moved keeps its velocity until the next step: what is jointed to it moves as fast, and so it is if its
        joint is gone then.
        """
        self._moving = set(self._targets)
        self._targets = {}

    @property
    def targets(self) -> Mapping[int, np.ndarray]:
        """The poses (7,) at the end of the next step, by index of the bodies that move in it."""
        return self._targets

    @property
    def bodies(self) -> list[int]:
        """The indices of the bodies that move in the next step."""
        return sorted(self._targets)

    @property
    def stopping(self) -> list[int]:
        """The indices of those that moved in the latest step, and do not in the next."""
        return sorted(self._moving - self._targets.keys())

    @property
    def moving(self) -> list[int]:
        """The indices of the bodies that have the velocity with which they moved in the latest step."""
        return sorted(self._moving)

    def begin(self, poses: np.ndarray, dt: float, substeps: int) -> tuple[np.ndarray, np.ndarray]:
        """Compute the motion from `poses` (N, 7) of all bodies, for a step of `dt` seconds.

        Returns:
            The poses (n, 7) of the moving bodies at the end of the step, and their velocities (n, 6) [m/s, rad/s].
        """
        import warp as wp

        count = self._model.body_count
        row, path = np.full(count, -1, np.int32), np.zeros((substeps, count, 7), np.float32)
        last, velocities = np.zeros((len(self._targets), 7)), np.zeros((len(self._targets), 6))
        for index, body in enumerate(self.bodies):
            row[body] = index
            pose, velocities[index] = constant_velocity_motion(
                poses[body].astype(np.float64), self._targets[body], self._center[body], dt
            )
            last[index] = pose(1.0)
            for substep in range(substeps):
                path[substep, index] = pose(substep / substeps)
        if substeps not in self._poses:
            self._poses[substeps] = wp.zeros((substeps, count), dtype=wp.transform, device=self._model.device)
        self._row.assign(row)
        self._poses[substeps].assign(path)
        return last, velocities

    def place(self, state: newton.State, teleported: wp.array, substep: int, substeps: int) -> None:
        """Place the moving bodies where they are at the begin of a substep, and mark them `teleported` (N,)."""
        import warp as wp

        from usdsdg_physics.world.kinematic_kernels import place_bodies

        wp.launch(
            place_bodies,
            dim=self._model.body_count,
            inputs=[self._row, self._poses[substeps], substep, self._coordinate],
            outputs=[state.joint_q, state.body_q, teleported],
            device=self._model.device,
        )


def constant_velocity_motion(
    start: np.ndarray, end: np.ndarray, center: np.ndarray, dt: float
) -> tuple[Callable[[float], np.ndarray], np.ndarray]:
    """Return the motion from one pose (7,) to another at constant linear and angular velocity.

    Args:
        center: center of mass in the body's frame [m]; it moves along a straight line.
        dt: duration [s].

    Returns:
        A function from a fraction of the duration to the pose then, and the velocity (6,) [m/s, rad/s].
    """
    from scipy.spatial.transform import Rotation

    first, last = Rotation.from_quat(start[3:]), Rotation.from_quat(end[3:])
    rotation_vector = (last * first.inv()).as_rotvec()
    from_center, to_center = start[:3] + first.apply(center), end[:3] + last.apply(center)

    def pose(fraction: float) -> np.ndarray:
        rotation = Rotation.from_rotvec(fraction * rotation_vector) * first
        at = from_center + fraction * (to_center - from_center) - rotation.apply(center)
        return np.concatenate([at, rotation.as_quat()])

    return pose, np.concatenate([(to_center - from_center) / dt, rotation_vector / dt])
