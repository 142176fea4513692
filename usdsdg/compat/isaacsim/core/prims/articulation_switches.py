"""`ArticulationSwitches`: settings of several robots' solver, which `Articulation` has."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim
from usdsdg.compat.wrappers import articulation_roots
from usdsdg.compat.wrappers.arrays import column

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Indices, Values


class ArticulationSwitches(XFormPrim):
    """Settings (N,) of PhysxArticulationAPI, on the stage. Of these, collisions between links have an effect."""

    def set_enabled_self_collisions(self, flags: Values, indices: Indices = None) -> None:
        """Let the links of a robot collide with each other, or not."""
        prims = self._chosen(indices)
        switches = [bool(each) for each in column(flags, len(prims))]
        articulation_roots.write(prims, "enabledSelfCollisions", switches)

    def get_enabled_self_collisions(self, indices: Indices = None) -> np.ndarray:
        return self._setting("enabledSelfCollisions", np.uint8, indices)

    def set_solver_position_iteration_counts(self, counts: Values, indices: Indices = None) -> None:
        self._set_setting("solverPositionIterationCount", int, counts, indices)

    def get_solver_position_iteration_counts(self, indices: Indices = None) -> np.ndarray:
        return self._setting("solverPositionIterationCount", np.int32, indices)

    def set_solver_velocity_iteration_counts(self, counts: Values, indices: Indices = None) -> None:
        self._set_setting("solverVelocityIterationCount", int, counts, indices)

    def get_solver_velocity_iteration_counts(self, indices: Indices = None) -> np.ndarray:
        return self._setting("solverVelocityIterationCount", np.int32, indices)

    def set_stabilization_thresholds(self, thresholds: Values, indices: Indices = None) -> None:
        self._set_setting("stabilizationThreshold", float, thresholds, indices)

    def get_stabilization_thresholds(self, indices: Indices = None) -> np.ndarray:
        return self._setting("stabilizationThreshold", np.float32, indices)

    def set_sleep_thresholds(self, thresholds: Values, indices: Indices = None) -> None:
        self._set_setting("sleepThreshold", float, thresholds, indices)

    def get_sleep_thresholds(self, indices: Indices = None) -> np.ndarray:
        return self._setting("sleepThreshold", np.float32, indices)

    def _setting(self, name: str, dtype: type, indices: Indices) -> np.ndarray:
        return self._out(articulation_roots.read(self._chosen(indices), name, dtype))[0]

    def _set_setting(self, name: str, kind: type, values: Values, indices: Indices) -> None:
        prims = self._chosen(indices)
        articulation_roots.write(prims, name, [kind(each) for each in column(values, len(prims))])
