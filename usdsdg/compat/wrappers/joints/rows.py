"""Joint positions, velocities, limits and efforts of articulations, as arrays with one row per robot.

Angles are in rad, distances in stage units. `JointDrives` and `JointProperties` have what else joints have.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from usdsdg.articulations.articulation import Articulation, limits_of
from usdsdg.articulations.articulations import get_articulations
from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.errors import BadValue
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.physics.joints import Joint

WHY = (
    "there are no tendons, and what else a solver knows is not told; positions, velocities, limits, drives, efforts, "
    "forces in joints, Jacobians and mass matrices are available"
)


class JointRows:
    """The articulations at some paths, which have the same joints."""

    def __init__(self, paths: Sequence[str]) -> None:
        """Take the robots at `paths`.

        Raises:
            BadPrim: one has no joint between two bodies.
            BadValue: they have different numbers of joints.
        """
        self.robots: list[Articulation] = [get_articulations().at(path) for path in paths]
        counts = {len(robot.dofs) for robot in self.robots}
        if len(counts) > 1:
            raise BadValue(f"{', '.join(paths)}: these articulations have {sorted(counts)} joints; wrap them apart")
        shape = (len(self.robots), counts.pop() if counts else 0)
        self.efforts = np.zeros(shape)  # that were set last
        self._pushes = np.zeros(shape)  # of the step that is next
        self._steps = -1  # that the simulation had taken when efforts were set last

    @property
    def names(self) -> list[str]:
        """The names of the joints that have a position, in order."""
        return [joint.path.rsplit("/", 1)[1] for joint in self.robots[0].dofs]

    @property
    def branch_paths(self) -> list[list[str]]:
        """The paths of all joints between links of each robot, breadth first from the base."""
        return [[branch.joint.path for branch in robot.tree.branches] for robot in self.robots]

    def is_angular(self) -> list[bool]:
        """Return which joints turn."""
        return [joint.kind == "Revolute" for joint in self.robots[0].dofs]

    def of_joints(self, read: Callable[[Joint], float]) -> np.ndarray:
        """Return a number of each joint (N, D) float32."""
        return np.array([[read(joint) for joint in robot.dofs] for robot in self.robots], np.float32)

    def chosen(
        self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray
    ) -> Iterator[tuple[int, int, Joint, float]]:
        """Yield row, column, joint and number of each of the values (n, d)."""
        for row, value in zip(rows, values, strict=True):
            for column, number in zip(columns, value.tolist(), strict=True):
                yield row, column, self.robots[row].dofs[column], number

    # --- state ---
    def positions(self) -> np.ndarray:
        """Return (N, D) float32."""
        return np.array([robot.positions for robot in self.robots], np.float32)

    def velocities(self) -> np.ndarray:
        """Return (N, D) float32."""
        return np.array([robot.velocities for robot in self.robots], np.float32)

    def set_positions(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Move joints at once: values (n, d)."""
        for row, value in zip(rows, values, strict=True):
            positions = self.robots[row].positions.copy()
            positions[list(columns)] = value
            self.robots[row].set_positions(positions)

    def set_velocities(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set velocities (n, d)."""
        for row, value in zip(rows, values, strict=True):
            velocities = self.robots[row].velocities.copy()
            velocities[list(columns)] = value
            self.robots[row].set_velocities(velocities)

    # --- forces ---
    def forces(self) -> np.ndarray:
        """Return the forces and torques (N, 1 + J, 6) float32 in joints, those of the base first: zeros.

        They are what body 0 exerts on body 1, along the joint's frame at body 1, in stage units.

        Raises:
            PhysicsError: physics does not play.
        """
        return np.array([robot.joint_forces() for robot in self.robots], np.float32)

    def projected_forces(self) -> np.ndarray:
        """Return the parts (N, D) float32 of `forces` along the axes of joints with a position.

        Raises:
            PhysicsError: physics does not play.
        """
        forces = self.forces()
        found = np.zeros((len(self.robots), len(self.robots[0].dofs)), np.float32)
        for row, (robot, paths) in enumerate(zip(self.robots, self.branch_paths)):
            for column, joint in enumerate(robot.dofs):
                axis = joint.axis + 3 * (joint.kind == "Revolute")
                found[row, column] = forces[row, 1 + paths.index(joint.path), axis]
        return found

    def limits(self) -> np.ndarray:
        """Return lower and upper limits (N, D, 2) float32."""
        stage = current_stage()
        found = [[limits_of(stage, joint) for joint in robot.dofs] for robot in self.robots]
        return np.array(found, np.float32).reshape(len(self.robots), -1, 2)

    # --- efforts ---
    def set_efforts(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Push joints during the next physics step with torques and forces (n, d), instead of what was set since.

        Raises:
            PhysicsError: physics does not play.
        """
        steps = simulation().steps
        if steps != self._steps:
            self._pushes[:], self._steps = 0.0, steps
        for row, value in zip(rows, values, strict=True):
            pushed = np.zeros(self.efforts.shape[1])
            pushed[list(columns)] = value - self._pushes[row, list(columns)]
            self.robots[row].apply_efforts(pushed)
            self._pushes[row, list(columns)] = self.efforts[row, list(columns)] = value
