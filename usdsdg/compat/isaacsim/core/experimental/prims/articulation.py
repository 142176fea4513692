"""`Articulation`: robots, whose joints follow what is set."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pxr import Usd, UsdPhysics

from usdsdg.compat.isaacsim.core.experimental.prims.xform_prim import XformPrim
from usdsdg.compat.wrappers.arrays import chosen, rows
from usdsdg.compat.wrappers.joints import WHY, JointRows
from usdsdg.compat.wrappers.unsupported import RefusedNames

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


class Articulation(XformPrim):
    """Robots: poses, links and joints. Forces in joints and between links raise `Unsupported`.

    Joint arrays have a row per robot and a column per joint with a position ("dof"), in rad and stage units.
    """

    __getattr__ = RefusedNames(
        "Articulation",
        ("get_", "set_", "apply_", "switch_", "num_shapes", "is_physics", "jacobian", "mass_matrix"),
        WHY,
    )

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        resolve_paths: bool = True,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = False,
        enable_residual_reports: bool = False,
    ) -> None:
        """Wrap robots; see `XformPrim`. Residuals of a solver are not reported."""
        super().__init__(
            paths, resolve_paths=resolve_paths, positions=positions, translations=translations,
            orientations=orientations, scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        self._joint_rows: JointRows | None = None

    # --- what there is ---
    @property
    def joint_names(self) -> list[str]:
        """Return the names of the joints below the first prim, in the order of the stage."""
        return [joint.GetName() for joint in self._below(UsdPhysics.Joint)]

    @property
    def link_names(self) -> list[str]:
        """Return the names of the rigid bodies at and below the first prim, in the order of the stage."""
        return [prim.GetName() for prim in Usd.PrimRange(self.prims[0]) if prim.HasAPI(UsdPhysics.RigidBodyAPI)]

    @property
    def num_joints(self) -> int:
        return len(self.joint_names)

    @property
    def num_links(self) -> int:
        return len(self.link_names)

    @property
    def num_dofs(self) -> int:
        return len(self.dof_names)

    @property
    def dof_names(self) -> list[str]:
        """Return the names of the joints with a position, breadth first from the base."""
        return self._joints().names

    @property
    def dof_paths(self) -> list[list[str]]:
        """Return the paths of the joints with a position, of each robot."""
        return [[joint.path for joint in robot.dofs] for robot in self._joints().robots]

    def get_dof_indices(self, names: str | Sequence[str]) -> wp.array:
        """Return the columns of joints by name.

        Raises:
            AssertionError: there is no such joint.
        """
        import numpy as np

        known = self.dof_names
        wanted = [names] if isinstance(names, str) else list(names)
        if missing := [name for name in wanted if name not in known]:
            raise AssertionError(f"{self.paths[0]} has no joint {missing[0]!r}; it has {', '.join(known)}")
        return self._warp(np.array([known.index(name) for name in wanted], np.int32))

    # --- positions and velocities ---
    def get_dof_positions(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return (N, D)."""
        return self._part(self._joints().positions(), indices, dof_indices)

    def set_dof_positions(self, positions: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Move joints at once, within their limits: (N, D)."""
        self._set(self._joints().set_positions, positions, indices, dof_indices)

    def get_dof_velocities(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return (N, D)."""
        return self._part(self._joints().velocities(), indices, dof_indices)

    def set_dof_velocities(self, velocities: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Set velocities (N, D), which last until a limit, or as the joint's drive damps them."""
        self._set(self._joints().set_velocities, velocities, indices, dof_indices)

    def get_dof_position_targets(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the targets (N, D) of the drives."""
        return self._part(self._joints().targets(), indices, dof_indices)

    def set_dof_position_targets(
        self, positions: Values, *, indices: Indices = None, dof_indices: Indices = None
    ) -> None:
        """Set the targets (N, D) that drives move their joints to.

        Raises:
            BadValue: a joint has no drive.
        """
        self._set(self._joints().set_targets, positions, indices, dof_indices)

    def get_dof_velocity_targets(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the target velocities (N, D) of the drives."""
        return self._part(self._joints().velocity_targets(), indices, dof_indices)

    def set_dof_velocity_targets(
        self, velocities: Values, *, indices: Indices = None, dof_indices: Indices = None
    ) -> None:
        """Set the velocities (N, D) that drives give their joints.

        Raises:
            BadValue: a joint has no drive.
        """
        self._set(self._joints().set_velocity_targets, velocities, indices, dof_indices)

    def set_dof_efforts(self, efforts: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Push joints during the next physics step: torques, and forces of prismatic joints (N, D).

        Raises:
            PhysicsError: physics does not play.
        """
        self._set(self._joints().apply_efforts, efforts, indices, dof_indices)

    def set_dof_gains(
        self,
        stiffnesses: Values | None = None,
        dampings: Values | None = None,
        *,
        indices: Indices = None,
        dof_indices: Indices = None,
        update_default_gains: bool = True,
    ) -> None:
        """Set stiffness and damping (N, D) of the drives on the stage, which keeps no others as default.

        Raises:
            BadValue: a joint has no drive.
        """
        if stiffnesses is not None:
            self._set(self._joints().set_stiffness, stiffnesses, indices, dof_indices)
        if dampings is not None:
            self._set(self._joints().set_damping, dampings, indices, dof_indices)

    def get_dof_max_efforts(self, *, indices: Indices = None, dof_indices: Indices = None) -> wp.array:
        """Return the largest torques, and forces of prismatic joints, (N, D) of the drives."""
        return self._part(self._joints().max_efforts(), indices, dof_indices)

    def set_dof_max_efforts(self, max_efforts: Values, *, indices: Indices = None, dof_indices: Indices = None) -> None:
        """Set the largest torques, and forces of prismatic joints, (N, D) of the drives.

        Raises:
            BadValue: a joint has no drive.
        """
        self._set(self._joints().set_max_efforts, max_efforts, indices, dof_indices)

    def get_dof_limits(self, *, indices: Indices = None, dof_indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return lower and upper limits (N, D)."""
        limits = self._joints().limits()
        return self._part(limits[..., 0], indices, dof_indices), self._part(limits[..., 1], indices, dof_indices)

    def get_dof_gains(self, *, indices: Indices = None, dof_indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return stiffness and damping (N, D) of the drives."""
        stiffness, damping = self._joints().gains()
        return self._part(stiffness, indices, dof_indices), self._part(damping, indices, dof_indices)

    def _joints(self) -> JointRows:
        if self._joint_rows is None:
            self._joint_rows = JointRows(self.paths)
        return self._joint_rows

    def _part(self, values, indices: Indices, dof_indices: Indices) -> wp.array:
        return self._warp(values[chosen(indices, len(self))][:, chosen(dof_indices, values.shape[1])])

    def _set(self, setter, values: Values, indices: Indices, dof_indices: Indices) -> None:
        where, columns = chosen(indices, len(self)), chosen(dof_indices, self.num_dofs)
        setter(where, columns, rows(values, len(columns), len(where)))

    def _below(self, schema: type) -> list[Usd.Prim]:
        return [prim for prim in Usd.PrimRange(self.prims[0]) if prim.IsA(schema)]
