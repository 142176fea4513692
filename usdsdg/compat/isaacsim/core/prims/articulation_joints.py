"""`ArticulationJoints`: joints of several robots, which `Articulation` has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim
from usdsdg.compat.omni.physics.tensors import DofType
from usdsdg.compat.wrappers.arrays import chosen, grid
from usdsdg.compat.wrappers.joints.drives import JointDrives
from usdsdg.compat.wrappers.joints.properties import JointProperties
from usdsdg.compat.wrappers.joints.rows import JointRows

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Indices, Values

    Names = Sequence[str] | None
    Setter = Callable[[Sequence[int], Sequence[int], np.ndarray], None]


class ArticulationJoints(XFormPrim):
    """Joints by `joint_indices` or `joint_names`: arrays have a row per robot and a column per joint ("dof").

    Joints are listed breadth first from the base; units are rad and stage units.
    """

    # --- which joints ---
    @property
    def num_dof(self) -> int:
        return len(self.dof_names)

    @property
    def dof_names(self) -> list[str]:
        """Return the names of the joints with a position, breadth first from the base."""
        return self._joints.names

    @property
    def joint_names(self) -> list[str]:
        """Return the names of all joints between links, breadth first from the base."""
        return [path.rsplit("/", 1)[1] for path in self._joints.branch_paths[0]]

    @property
    def num_joints(self) -> int:
        return len(self.joint_names)

    def get_dof_index(self, dof_name: str) -> int:
        """Return the column of a joint.

        Raises:
            KeyError: there is no such joint.
        """
        return _index(self.dof_names, dof_name, "joint with a position")

    def get_joint_index(self, joint_name: str) -> int:
        """Return the place of a joint among `joint_names`.

        Raises:
            KeyError: there is no such joint.
        """
        return _index(self.joint_names, joint_name, "joint")

    def get_dof_types(self, dof_names: Names = None) -> list[DofType]:
        """Return whether joints turn or slide."""
        kinds = [DofType.Rotation if turns else DofType.Translation for turns in self._joints.is_angular()]
        return kinds if dof_names is None else [kinds[self.get_dof_index(name)] for name in dof_names]

    # --- positions, velocities, efforts ---
    def get_joint_positions(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return (N, D)."""
        return self._part(self._joints.positions(), indices, joint_indices, joint_names)

    def set_joint_positions(
        self, positions: Values | None, indices: Indices = None, joint_indices: Indices = None,
        joint_names: Names = None,
    ) -> None:  # fmt: skip
        """Move joints at once, within their limits: (N, D)."""
        self._set(self._joints.set_positions, positions, indices, joint_indices, joint_names)

    def get_joint_velocities(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return (N, D)."""
        return self._part(self._joints.velocities(), indices, joint_indices, joint_names)

    def set_joint_velocities(
        self, velocities: Values | None, indices: Indices = None, joint_indices: Indices = None,
        joint_names: Names = None,
    ) -> None:  # fmt: skip
        """Set velocities (N, D), which last until a limit, or as the joint's drive damps them."""
        self._set(self._joints.set_velocities, velocities, indices, joint_indices, joint_names)

    def set_joint_efforts(
        self, efforts: Values | None, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None
    ) -> None:
        """Push joints during the next physics step: torques, and forces of prismatic joints (N, D).

        Raises:
            PhysicsError: physics does not play.
        """
        self._set(self._joints.set_efforts, efforts, indices, joint_indices, joint_names)

    def get_applied_joint_efforts(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return the efforts (N, D) that `set_joint_efforts` set last; those of drives are not among them."""
        return self._part(self._joints.efforts.astype(np.float32), indices, joint_indices, joint_names)

    # --- forces in joints ---
    def get_measured_joint_efforts(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return the torques, and forces of prismatic joints, that joints bore in the latest step along their axes.

        These (N, D) are parts of `get_measured_joint_forces`.

        Raises:
            PhysicsError: physics does not play.
        """
        return self._part(self._joints.projected_forces(), indices, joint_indices, joint_names)

    def get_measured_joint_forces(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return forces, then torques (N, 1 + J, 6) that joints bore in the latest step, what drives do included.

        The first row, with index 0, is of the base and zero, as PhysX has it; then come `joint_names`. It is what body
        0 exerts on body 1, along the joint's frame at body 1.

        Raises:
            PhysicsError: physics does not play.
        """
        rows = chosen(joint_indices, 1 + self.num_joints)
        if joint_names is not None:
            rows = [1 + self.get_joint_index(name) for name in joint_names]
        return self._out(self._joints.forces()[chosen(indices, self.count)][:, rows])[0]

    # --- targets ---
    def set_joint_position_targets(
        self, positions: Values | None, indices: Indices = None, joint_indices: Indices = None,
        joint_names: Names = None,
    ) -> None:  # fmt: skip
        """Set the targets (N, D) that drives move their joints to; they have no effect on joints without a drive."""
        self._set(self._drives.set_targets, positions, indices, joint_indices, joint_names)

    def set_joint_velocity_targets(
        self, velocities: Values | None, indices: Indices = None, joint_indices: Indices = None,
        joint_names: Names = None,
    ) -> None:  # fmt: skip
        """Set the velocities (N, D) that drives give their joints; see `set_joint_position_targets`."""
        self._set(self._drives.set_velocity_targets, velocities, indices, joint_indices, joint_names)

    # --- limits, friction, armature ---
    def get_dof_limits(self) -> np.ndarray:
        """Return lower and upper limits (N, D, 2)."""
        return self._out(self._joints.limits())[0]

    def set_friction_coefficients(
        self, values: Values, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None
    ) -> None:
        """Set the friction per load (N, D)."""
        self._set(self._properties.set_friction_coefficients, values, indices, joint_indices, joint_names)

    def get_friction_coefficients(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return the friction per load (N, D)."""
        return self._part(self._properties.friction_coefficients(), indices, joint_indices, joint_names)

    def set_armatures(
        self, values: Values, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None
    ) -> None:
        """Set what is added to the mass or inertia that joints move (N, D)."""
        self._set(self._properties.set_armatures, values, indices, joint_indices, joint_names)

    def get_armatures(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return what is added to the mass or inertia that joints move (N, D)."""
        return self._part(self._properties.armatures(), indices, joint_indices, joint_names)

    def set_max_joint_velocities(
        self, values: Values, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None
    ) -> None:
        """Set the greatest velocities (N, D)."""
        self._set(self._properties.set_max_velocities, values, indices, joint_indices, joint_names)

    def get_joint_max_velocities(
        self, indices: Indices = None, joint_indices: Indices = None, joint_names: Names = None, clone: bool = True
    ) -> np.ndarray:
        """Return the greatest velocities (N, D); the greatest float where there is no limit."""
        return self._part(self._properties.max_velocities(), indices, joint_indices, joint_names)

    # --- rows and columns ---
    @cached_property
    def _joints(self) -> JointRows:
        return JointRows(self.prim_paths)

    @cached_property
    def _drives(self) -> JointDrives:
        return JointDrives(self._joints)

    @cached_property
    def _properties(self) -> JointProperties:
        return JointProperties(self._joints)

    def _columns(self, joint_indices: Indices, joint_names: Names = None) -> list[int]:
        """Return the columns of joints.

        Raises:
            ValueError: both indices and names are given.
        """
        if joint_names is not None and joint_indices is not None:
            raise ValueError(f"{self.name}: give either joint_indices or joint_names, not both")
        if joint_names is not None:
            return [self.get_dof_index(name) for name in joint_names]
        return chosen(joint_indices, self.num_dof)

    def _part(self, values: np.ndarray, indices: Indices, columns: Indices, names: Names = None) -> np.ndarray:
        return self._out(values[chosen(indices, self.count)][:, self._columns(columns, names)])[0]

    def _set(
        self, setter: Setter, values: Values | None, indices: Indices, columns: Indices, names: Names = None
    ) -> None:
        if values is not None:
            where, which = chosen(indices, self.count), self._columns(columns, names)
            setter(where, which, grid(values, (len(where), len(which))))


def _index(names: Sequence[str], name: str, kind: str) -> int:
    if name not in names:
        raise KeyError(f"there is no {kind} {name!r}; there are {', '.join(names)}")
    return names.index(name)
