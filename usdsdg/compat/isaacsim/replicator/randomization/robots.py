"""The attributes of articulations as rows of numbers, one row per robot."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdPhysics

from usdsdg.articulations.articulation import Articulation, limits_of, read_drive
from usdsdg.articulations.articulations import get_articulations
from usdsdg.compat.isaacsim.replicator.randomization import prim_values
from usdsdg.errors import Unsupported
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.physics.joints import Joint
from usdsdg.stage.schemas import physx

Array = NDArray[np.float64]


class Robots:
    """Articulations of a view. Joints follow what is set; what acts on them by forces cannot be randomized.

    Rows are float64, in rad and stage units; stiffness and damping per rad. NaN is a value that nobody has authored.
    """

    SUPPORTED = (
        "position", "orientation", "joint_positions", "joint_velocities", "stiffness", "damping", "lower_dof_limits",
        "upper_dof_limits", "joint_max_velocities",
    )  # fmt: skip

    def __init__(self, paths: Sequence[str]) -> None:
        """Take the robots at `paths`.

        Raises:
            BadPrim: one has no joint between two bodies.
        """
        self.paths = tuple(paths)
        for path in self.paths:
            get_articulations().at(path)

    def read(self, attribute: str) -> Array:
        """Return the present values (N, K) of an attribute.

        Raises:
            Unsupported: the attribute belongs to forces, masses or tendons of joints, which are not simulated.
        """
        self._check(attribute)
        prims = prim_values.prims_at(self.paths)
        if attribute == "position":
            return prim_values.positions(prims)
        if attribute == "orientation":
            return prim_values.orientations(prims)
        return np.array([self._row(attribute, robot) for robot in self._robots()]).reshape(len(prims), -1)

    def write(self, attribute: str, rows: Sequence[int], values: Array) -> None:
        """Set an attribute of the robots in `rows` to values (n, K).

        Raises:
            Unsupported: as in `read`.
        """
        self._check(attribute)
        prims = prim_values.prims_at([self.paths[row] for row in rows])
        robots = [robot for row, robot in enumerate(self._robots()) if row in set(rows)]
        if attribute == "position":
            prim_values.set_positions(prims, values)
        elif attribute == "orientation":
            prim_values.set_orientations(prims, values)
        else:
            by_path = {robot.root: robot for robot in robots}
            for row, value in zip(rows, values, strict=True):
                _set_row(attribute, by_path[self.paths[row]], value)

    def _row(self, attribute: str, robot: Articulation) -> Array:
        if attribute == "joint_positions":
            return robot.positions
        if attribute == "joint_velocities":
            return robot.velocities
        return np.array([_READ[attribute](joint) for joint in robot.dofs])

    def _robots(self) -> list[Articulation]:
        return [get_articulations().at(path) for path in self.paths]

    def _check(self, attribute: str) -> None:
        if attribute not in self.SUPPORTED:
            raise Unsupported(
                f"{self.paths[0]}: {attribute} of an articulation cannot be randomized: its joints follow positions, "
                f"velocities and drives, and no forces act on them. There are {', '.join(self.SUPPORTED)}"
            )


def _set_row(attribute: str, robot: Articulation, value: Array) -> None:
    if attribute == "joint_positions":
        robot.set_positions(value)
    elif attribute == "joint_velocities":
        robot.set_velocities(value)
    else:
        for joint, number in zip(robot.dofs, value.tolist(), strict=True):
            _WRITE[attribute](joint, number)


def _prim(joint: Joint) -> Usd.Prim:
    return current_stage().GetPrimAtPath(joint.path)


def _max_velocity(joint: Joint) -> float:
    attribute = _prim(joint).GetAttribute("physxJoint:maxJointVelocity")
    return attribute.Get() * joint.unit if attribute and attribute.HasAuthoredValue() else np.nan


def _set_max_velocity(joint: Joint, value: float) -> None:
    api = physx.PhysxJointAPI.Apply(_prim(joint))  # pyright: ignore[reportAttributeAccessIssue]
    api.CreateMaxJointVelocityAttr().Set(value / joint.unit)


def _set_stiffness(joint: Joint, value: float) -> None:
    UsdPhysics.DriveAPI.Apply(_prim(joint), joint.drive).CreateStiffnessAttr().Set(value * joint.unit)


def _set_damping(joint: Joint, value: float) -> None:
    UsdPhysics.DriveAPI.Apply(_prim(joint), joint.drive).CreateDampingAttr().Set(value * joint.unit)


def _set_limit(end: str) -> Callable[[Joint, float], None]:
    return lambda joint, value: _prim(joint).GetAttribute(f"physics:{end}Limit").Set(value / joint.unit)


_READ: dict[str, Callable[[Joint], float]] = {
    "stiffness": lambda joint: read_drive(current_stage(), joint).stiffness,
    "damping": lambda joint: read_drive(current_stage(), joint).damping,
    "lower_dof_limits": lambda joint: limits_of(current_stage(), joint)[0],
    "upper_dof_limits": lambda joint: limits_of(current_stage(), joint)[1],
    "joint_max_velocities": _max_velocity,
}
_WRITE: dict[str, Callable[[Joint, float], None]] = {
    "stiffness": _set_stiffness,
    "damping": _set_damping,
    "lower_dof_limits": _set_limit("lower"),
    "upper_dof_limits": _set_limit("upper"),
    "joint_max_velocities": _set_max_velocity,
}
