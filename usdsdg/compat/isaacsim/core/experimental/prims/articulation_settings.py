"""`ArticulationSettings`: settings of robots' solver, which `Articulation` has."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.experimental.prims.xform_prim import XformPrim
from usdsdg.compat.wrappers import articulation_roots
from usdsdg.compat.wrappers.arrays import column

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


class ArticulationSettings(XformPrim):
    """Settings (N, 1) of PhysxArticulationAPI, on the stage. Of these, collisions between links have an effect."""

    def set_enabled_self_collisions(self, enabled: Values, *, indices: Indices = None) -> None:
        """Let the links of a robot collide with each other, or not."""
        self._set_setting("enabledSelfCollisions", bool, enabled, indices)

    def get_enabled_self_collisions(self, *, indices: Indices = None) -> wp.array:
        return self._setting("enabledSelfCollisions", bool, indices)

    def set_solver_iteration_counts(
        self,
        position_counts: Values | None = None,
        velocity_counts: Values | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set iterations of PhysX's solver.

        Raises:
            AssertionError: neither is given.
        """
        if position_counts is None and velocity_counts is None:
            raise AssertionError("give position_counts or velocity_counts")
        for name, counts in (("Position", position_counts), ("Velocity", velocity_counts)):
            if counts is not None:
                self._set_setting(f"solver{name}IterationCount", int, counts, indices)

    def get_solver_iteration_counts(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return iterations of PhysX's solver for positions and velocities."""
        names = "solverPositionIterationCount", "solverVelocityIterationCount"
        position, velocity = (self._setting(name, np.int32, indices) for name in names)
        return position, velocity

    def set_stabilization_thresholds(self, thresholds: Values, *, indices: Indices = None) -> None:
        self._set_setting("stabilizationThreshold", float, thresholds, indices)

    def get_stabilization_thresholds(self, *, indices: Indices = None) -> wp.array:
        return self._setting("stabilizationThreshold", np.float32, indices)

    def set_sleep_thresholds(self, thresholds: Values, *, indices: Indices = None) -> None:
        self._set_setting("sleepThreshold", float, thresholds, indices)

    def get_sleep_thresholds(self, *, indices: Indices = None) -> wp.array:
        return self._setting("sleepThreshold", np.float32, indices)

    def _setting(self, name: str, dtype: type, indices: Indices) -> wp.array:
        return self._warp(articulation_roots.read(self._chosen(indices), name, dtype)[:, None])

    def _set_setting(self, name: str, kind: type, values: Values, indices: Indices) -> None:
        prims = self._chosen(indices)
        articulation_roots.write(prims, name, [kind(each) for each in column(values, len(prims))])
