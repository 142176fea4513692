"""`Articulation`: several robots, whose joints follow what is set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdPhysics

from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim
from usdsdg.compat.wrappers.arrays import chosen, rows
from usdsdg.compat.wrappers.joints import WHY, JointRows
from usdsdg.compat.wrappers.unsupported import RefusedNames

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Indices, Values


class Articulation(XFormPrim):
    """Robots: poses, links and joints. Forces in joints and between links raise `Unsupported`.

    Joint arrays have a row per robot and a column per joint with a position ("dof"), in rad and stage units.
    """

    __getattr__ = RefusedNames(
        "Articulation", ("get_", "set_", "apply_", "switch_", "pause_", "resume_", "num_shapes", "num_fixed"), WHY
    )

    def __init__(
        self,
        prim_paths_expr: str | Sequence[str],
        name: str = "articulation_prim_view",
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        visibilities: Values | None = None,
        reset_xform_properties: bool = True,
        enable_residual_reports: bool = False,
    ) -> None:
        """Wrap robots; see `XFormPrim`. Residuals of a solver are not reported."""
        super().__init__(
            prim_paths_expr, name, positions, translations, orientations, scales, visibilities, reset_xform_properties
        )
        self._joint_rows: JointRows | None = None

    def post_reset(self) -> None:
        """Place robots and joints as they were when they were wrapped."""
        super().post_reset()
        for robot in self._joints().robots:
            robot.restart()

    # --- what there is ---
    @property
    def num_dof(self) -> int:
        return len(self.dof_names)

    @property
    def dof_names(self) -> list[str]:
        """Return the names of the joints with a position, breadth first from the base."""
        return self._joints().names

    @property
    def body_names(self) -> list[str]:
        """Return the names of the rigid bodies at and below the first prim, in the order of the stage."""
        return [prim.GetName() for prim in Usd.PrimRange(self.prims[0]) if prim.HasAPI(UsdPhysics.RigidBodyAPI)]

    @property
    def num_bodies(self) -> int:
        return len(self.body_names)

    @property
    def joint_names(self) -> list[str]:
        """Return the names of the joints below the first prim, in the order of the stage."""
        return [prim.GetName() for prim in Usd.PrimRange(self.prims[0]) if prim.IsA(UsdPhysics.Joint)]

    @property
    def num_joints(self) -> int:
        return len(self.joint_names)

    def get_dof_index(self, dof_name: str) -> int:
        """Return the column of a joint.

        Raises:
            ValueError: there is no such joint.
        """
        return self.dof_names.index(dof_name)

    # --- positions and velocities ---
    def get_joint_positions(
        self, indices: Indices = None, joint_indices: Indices = None, clone: bool = True
    ) -> np.ndarray:
        """Return (N, D)."""
        return self._part(self._joints().positions(), indices, joint_indices)

    def set_joint_positions(self, positions: Values, indices: Indices = None, joint_indices: Indices = None) -> None:
        """Move joints at once, within their limits: (N, D)."""
        self._set(self._joints().set_positions, positions, indices, joint_indices)

    def get_joint_velocities(
        self, indices: Indices = None, joint_indices: Indices = None, clone: bool = True
    ) -> np.ndarray:
        """Return (N, D)."""
        return self._part(self._joints().velocities(), indices, joint_indices)

    def set_joint_velocities(self, velocities: Values, indices: Indices = None, joint_indices: Indices = None) -> None:
        """Set velocities (N, D), which last until a limit, or as the joint's drive damps them."""
        self._set(self._joints().set_velocities, velocities, indices, joint_indices)

    def set_joint_position_targets(
        self, positions: Values, indices: Indices = None, joint_indices: Indices = None
    ) -> None:
        """Set the targets (N, D) that drives move their joints to.

        Raises:
            BadValue: a joint has no drive.
        """
        self._set(self._joints().set_targets, positions, indices, joint_indices)

    def set_joint_velocity_targets(
        self, velocities: Values, indices: Indices = None, joint_indices: Indices = None
    ) -> None:
        """Set the velocities (N, D) that drives give their joints.

        Raises:
            BadValue: a joint has no drive.
        """
        self._set(self._joints().set_velocity_targets, velocities, indices, joint_indices)

    def set_joint_efforts(self, efforts: Values, indices: Indices = None, joint_indices: Indices = None) -> None:
        """Push joints during the next physics step: torques, and forces of prismatic joints (N, D).

        Raises:
            PhysicsError: physics does not play.
        """
        self._set(self._joints().apply_efforts, efforts, indices, joint_indices)

    def set_gains(
        self,
        kps: Values | None = None,
        kds: Values | None = None,
        indices: Indices = None,
        joint_indices: Indices = None,
        save_to_usd: bool = False,
    ) -> None:
        """Set stiffness and damping (N, D) of the drives, on the stage in any case.

        Raises:
            BadValue: a joint has no drive.
        """
        if kps is not None:
            self._set(self._joints().set_stiffness, kps, indices, joint_indices)
        if kds is not None:
            self._set(self._joints().set_damping, kds, indices, joint_indices)

    def set_max_efforts(self, values: Values, indices: Indices = None, joint_indices: Indices = None) -> None:
        """Set the largest torques, and forces of prismatic joints, (N, D) of the drives.

        Raises:
            BadValue: a joint has no drive.
        """
        self._set(self._joints().set_max_efforts, values, indices, joint_indices)

    def get_max_efforts(self, indices: Indices = None, joint_indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return the largest torques, and forces of prismatic joints, (N, D) of the drives."""
        return self._part(self._joints().max_efforts(), indices, joint_indices)

    def get_dof_limits(self) -> np.ndarray:
        """Return lower and upper limits (N, D, 2)."""
        return self._out(self._joints().limits())[0]

    def get_gains(
        self, indices: Indices = None, joint_indices: Indices = None, clone: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return stiffness and damping (N, D) of the drives."""
        stiffness, damping = self._joints().gains()
        return self._part(stiffness, indices, joint_indices), self._part(damping, indices, joint_indices)

    def _joints(self) -> JointRows:
        if self._joint_rows is None:
            self._joint_rows = JointRows(self.prim_paths)
        return self._joint_rows

    def _part(self, values: np.ndarray, indices: Indices, columns: Indices) -> np.ndarray:
        return self._out(values[chosen(indices, self.count)][:, chosen(columns, values.shape[1])])[0]

    def _set(
        self,
        setter: Callable[[Sequence[int], Sequence[int], np.ndarray], None],
        values: Values,
        indices: Indices,
        columns: Indices,
    ) -> None:
        where, which = chosen(indices, self.count), chosen(columns, self.num_dof)
        setter(where, which, rows(values, len(which), len(where)))
