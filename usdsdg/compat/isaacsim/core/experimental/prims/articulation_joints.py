"""`ArticulationJoints`: joints of robots, which `Articulation` has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.experimental.prims.xform_prim import XformPrim
from usdsdg.compat.omni.physics.tensors import DofType, JointType
from usdsdg.compat.wrappers.arrays import chosen, grid
from usdsdg.compat.wrappers.joints.drives import JointDrives
from usdsdg.compat.wrappers.joints.properties import JointProperties
from usdsdg.compat.wrappers.joints.rows import JointRows

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values

    Setter = Callable[[Sequence[int], Sequence[int], np.ndarray], None]


class ArticulationJoints(XformPrim):
    """Joints: arrays have a row per robot and a column per joint with a position ("dof"), in rad and stage units."""

    # --- which joints ---
    @property
    def joint_names(self) -> list[str]:
        """Return the names of all joints between links, breadth first from the base."""
        return [path.rsplit("/", 1)[1] for path in self.joint_paths[0]]

    @property
    def joint_paths(self) -> list[list[str]]:
        """Return the paths of all joints between links, of each robot."""
        return self._joints.branch_paths

    @property
    def joint_types(self) -> list[JointType]:
        """Return what the joints between links are; those with several axes are `Invalid`."""
        kinds = [branch.joint.kind for branch in self._joints.robots[0].tree.branches]
        return [JointType[kind] if kind in JointType.__members__ else JointType.Invalid for kind in kinds]

    @property
    def num_joints(self) -> int:
        return len(self.joint_names)

    @property
    def num_dofs(self) -> int:
        return len(self.dof_names)

    @property
    def dof_names(self) -> list[str]:
        """Return the names of the joints with a position, breadth first from the base."""
        return self._joints.names

    @property
    def dof_paths(self) -> list[list[str]]:
        """Return the paths of the joints with a position, of each robot."""
        return [[joint.path for joint in robot.dofs] for robot in self._joints.robots]

    @property
    def dof_types(self) -> list[DofType]:
        """Return whether joints with a position turn or slide."""
        return [DofType.Rotation if turns else DofType.Translation for turns in self._joints.is_angular()]

    def get_dof_indices(self, names: str | Sequence[str]) -> wp.array:
        """Return the columns of joints by name.

        Raises:
            AssertionError: there is no such joint.
        """
        return self._places(self.dof_names, names, "joint")

    def get_joint_indices(self, names: str | Sequence[str]) -> wp.array:
        """Return the places of joints among `joint_names`.

        Raises:
            AssertionError: there is no such joint.
        """
        return self._places(self.joint_names, names, "joint")

    # --- positions, velocities, efforts ---
    def get_dof_positions(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return (N, D)."""
        return self._part(self._joints.positions(), indices, dof_indices)

    def set_dof_positions(self, positions: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Move joints at once, within their limits: (N, D)."""
        self._set(self._joints.set_positions, positions, indices, dof_indices)

    def get_dof_velocities(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return (N, D)."""
        return self._part(self._joints.velocities(), indices, dof_indices)

    def set_dof_velocities(self, velocities: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Set velocities (N, D), which last until a limit, or as the joint's drive damps them."""
        self._set(self._joints.set_velocities, velocities, indices, dof_indices)

    def set_dof_efforts(self, efforts: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Push joints during the next physics step: torques, and forces of prismatic joints (N, D).

        Raises:
            PhysicsError: physics does not play.
        """
        self._set(self._joints.set_efforts, efforts, indices, dof_indices)

    def get_dof_efforts(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the efforts (N, D) that `set_dof_efforts` set last; those of drives are not among them."""
        return self._part(self._joints.efforts.astype(np.float32), indices, dof_indices)

    def get_dof_projected_joint_forces(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return what joints bore along their axes in the latest step (N, D): torques, and forces of prismatic joints.

        Raises:
            PhysicsError: physics does not play.
        """
        return self._part(self._joints.projected_forces(), indices, dof_indices)

    # --- limits, friction, armature ---
    def get_dof_limits(self, *, indices: Indices = None, dof_indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return lower and upper limits (N, D)."""
        limits = self._joints.limits()
        return self._part(limits[..., 0], indices, dof_indices), self._part(limits[..., 1], indices, dof_indices)

    def set_dof_limits(
        self,
        lower: Values | None = None,
        upper: Values | None = None,
        *,
        indices: Indices = None,
        dof_indices: Indices = None,
    ) -> None:
        """Set lower and upper limits (N, D) on the stage; what is not given stays.

        Raises:
            AssertionError: neither is given.
        """
        if lower is None and upper is None:
            raise AssertionError("give lower or upper")
        where, columns, (low, high) = self._given((lower, upper), indices, dof_indices)
        self._properties.set_limits(where, columns, low, high)

    def get_dof_friction_properties(
        self, *, indices: Indices = None, dof_indices: Indices = None
    ) -> tuple[wp.array, wp.array, wp.array]:
        """Return static and dynamic friction efforts, and viscous friction coefficients (N, D)."""
        static, dynamic, viscous = (self._part(each, indices, dof_indices) for each in self._properties.frictions())
        return static, dynamic, viscous

    def set_dof_friction_properties(
        self,
        static_frictions: Values | None = None,
        dynamic_frictions: Values | None = None,
        viscous_frictions: Values | None = None,
        *,
        indices: Indices = None,
        dof_indices: Indices = None,
    ) -> None:
        """Set friction (N, D) on the stage; what is not given stays. Dynamic friction has no effect.

        Raises:
            AssertionError: nothing is given.
        """
        frictions = static_frictions, dynamic_frictions, viscous_frictions
        if all(each is None for each in frictions):
            raise AssertionError("give static_frictions, dynamic_frictions or viscous_frictions")
        where, columns, (static, dynamic, viscous) = self._given(frictions, indices, dof_indices)
        self._properties.set_frictions(where, columns, static, dynamic, viscous)

    def get_dof_armatures(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return what is added to the mass or inertia that joints move (N, D)."""
        return self._part(self._properties.armatures(), indices, dof_indices)

    def set_dof_armatures(self, armatures: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Set what is added to the mass or inertia that joints move (N, D), on the stage."""
        self._set(self._properties.set_armatures, armatures, indices, dof_indices)

    def get_dof_max_velocities(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the greatest velocities (N, D); the greatest float where there is no limit."""
        return self._part(self._properties.max_velocities(), indices, dof_indices)

    def set_dof_max_velocities(
        self, max_velocities: Values, *, indices: Indices = None, dof_indices: Indices = None
    ) -> None:
        """Set the greatest velocities (N, D) on the stage."""
        self._set(self._properties.set_max_velocities, max_velocities, indices, dof_indices)

    # --- rows and columns ---
    @cached_property
    def _joints(self) -> JointRows:
        return JointRows(self.paths)

    @cached_property
    def _drives(self) -> JointDrives:
        return JointDrives(self._joints)

    @cached_property
    def _properties(self) -> JointProperties:
        return JointProperties(self._joints)

    def _places(self, known: Sequence[str], names: str | Sequence[str], kind: str) -> wp.array:
        """Return the places of names among those that are known, (n,) int32."""
        wanted = [names] if isinstance(names, str) else list(names)
        if missing := [name for name in wanted if name not in known]:
            raise AssertionError(f"{self.paths[0]} has no {kind} {missing[0]!r}; it has {', '.join(known)}")
        return self._warp(np.array([known.index(name) for name in wanted], np.int32))

    def _part(self, values: np.ndarray, indices: Indices, dof_indices: Indices) -> wp.array:
        return self._warp(values[chosen(indices, len(self))][:, chosen(dof_indices, values.shape[1])])

    def _set(self, setter: Setter, values: Values, indices: Indices, dof_indices: Indices) -> None:
        where, columns = chosen(indices, len(self)), chosen(dof_indices, self.num_dofs)
        setter(where, columns, grid(values, (len(where), len(columns))))

    def _given(
        self, values: Sequence[Values | None], indices: Indices, dof_indices: Indices
    ) -> tuple[list[int], list[int], list[np.ndarray | None]]:
        """Return rows, columns and the values (n, d) that are given, None for those that are not."""
        where, columns = chosen(indices, len(self)), chosen(dof_indices, self.num_dofs)
        return where, columns, [None if each is None else grid(each, (len(where), len(columns))) for each in values]
