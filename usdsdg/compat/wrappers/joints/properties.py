"""Limits, friction, armature and greatest velocities of the joints of articulations, in rad and stage units.

What is set is authored on the stage. While physics plays, the next step rebuilds the simulation with it, and stop puts
back what the stage had, as in PhysX.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Sdf, Usd

from usdsdg.compat.used_stage import current_stage
from usdsdg.compat.wrappers.joints.rows import JointRows
from usdsdg.compat.wrappers.runtime_values import keep_joint_until_stop
from usdsdg.stage.physics.joints import Joint
from usdsdg.stage.schemas import physx

# Stands for no limit in USD attributes of type float.
NO_LIMIT = float(np.finfo(np.float32).max)


class JointProperties:
    """Reads and sets PhysxJointAPI, PhysxJointAxisAPI and limits of joints."""

    def __init__(self, joints: JointRows) -> None:
        self._joints = joints

    def set_limits(
        self, rows: Sequence[int], columns: Sequence[int], lower: np.ndarray | None, upper: np.ndarray | None
    ) -> None:
        """Set limits (n, d); None keeps them."""
        for end, values in (("lower", lower), ("upper", upper)):
            for _, _, joint, number in self._joints.chosen(rows, columns, values) if values is not None else ():
                keep_joint_until_stop(_prim(joint), f"physics:{end}Limit")
                _prim(joint).GetAttribute(f"physics:{end}Limit").Set(number / joint.unit)

    def armatures(self) -> np.ndarray:
        """Return what is added to the mass or inertia that a joint moves (N, D) float32."""
        return self._joints.of_joints(lambda joint: _of_axis(joint, "armature") or _own(joint, "armature", 0.0))

    def set_armatures(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set (n, d)."""
        for _, _, joint, number in self._joints.chosen(rows, columns, values):
            keep_joint_until_stop(_prim(joint), "physxJoint:armature")
            _api(joint).CreateArmatureAttr().Set(number)

    def max_velocities(self) -> np.ndarray:
        """Return (N, D) float32 [rad/s, stage units/s]; the greatest float where there is no limit."""

        def read(joint: Joint) -> float:
            found = _of_axis(joint, "maxJointVelocity")
            found = _own(joint, "maxJointVelocity", NO_LIMIT) if found is None else found
            return found * joint.unit if found < NO_LIMIT else found

        return self._joints.of_joints(read)

    def set_max_velocities(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set (n, d)."""
        for _, _, joint, number in self._joints.chosen(rows, columns, values):
            keep_joint_until_stop(_prim(joint), "physxJoint:maxJointVelocity")
            _api(joint).CreateMaxJointVelocityAttr().Set(number / joint.unit if number < NO_LIMIT else NO_LIMIT)

    def friction_coefficients(self) -> np.ndarray:
        """Return the friction per load of the joint (N, D) float32."""
        return self._joints.of_joints(lambda joint: _own(joint, "jointFriction", 0.0))

    def set_friction_coefficients(self, rows: Sequence[int], columns: Sequence[int], values: np.ndarray) -> None:
        """Set (n, d)."""
        for _, _, joint, number in self._joints.chosen(rows, columns, values):
            keep_joint_until_stop(_prim(joint), "physxJoint:jointFriction")
            _api(joint).CreateJointFrictionAttr().Set(number)

    def frictions(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return static and dynamic efforts, and viscous coefficients per rad/s or stage unit/s (N, D) float32."""

        def viscous(joint: Joint) -> float:
            return (_of_axis(joint, "viscousFrictionCoefficient") or 0.0) / joint.unit

        return (
            self._joints.of_joints(lambda joint: _of_axis(joint, "staticFrictionEffort") or 0.0),
            self._joints.of_joints(lambda joint: _of_axis(joint, "dynamicFrictionEffort") or 0.0),
            self._joints.of_joints(viscous),
        )

    def set_frictions(
        self,
        rows: Sequence[int],
        columns: Sequence[int],
        static: np.ndarray | None,
        dynamic: np.ndarray | None,
        viscous: np.ndarray | None,
    ) -> None:
        """Set static and dynamic efforts and viscous coefficients (n, d); None keeps them."""
        names = ("staticFrictionEffort", "dynamicFrictionEffort", "viscousFrictionCoefficient")
        for name, values in zip(names, (static, dynamic, viscous)):
            for _, _, joint, number in self._joints.chosen(rows, columns, values) if values is not None else ():
                prim = _prim(joint)
                # Our PhysxSchema does not have this schema, but physics reads its attributes.
                prim.AddAppliedSchema(f"PhysxJointAxisAPI:{joint.drive}")
                value = number * joint.unit if name.startswith("viscous") else number
                full = f"physxJointAxis:{joint.drive}:{name}"
                keep_joint_until_stop(prim, full)
                prim.CreateAttribute(full, Sdf.ValueTypeNames.Float, custom=False).Set(value)


def _prim(joint: Joint) -> Usd.Prim:
    return current_stage().GetPrimAtPath(joint.path)


def _api(joint: Joint) -> physx.PhysxJointAPI:
    return physx.PhysxJointAPI.Apply(_prim(joint))


def _own(joint: Joint, name: str, default: float) -> float:
    """Return an attribute of PhysxJointAPI."""
    attribute = _prim(joint).GetAttribute(f"physxJoint:{name}")
    return float(attribute.Get()) if attribute and attribute.HasAuthoredValue() else default


def _of_axis(joint: Joint, name: str) -> float | None:
    """Return an authored attribute of PhysxJointAxisAPI; None without one."""
    attribute = _prim(joint).GetAttribute(f"physxJointAxis:{joint.drive}:{name}")
    return float(attribute.Get()) if attribute and attribute.HasAuthoredValue() else None
