"""The behavior that makes prims look at a point or at another prim."""

from __future__ import annotations

from typing import ClassVar

from pxr import Gf, Sdf, Usd

from usdsdg.compat.isaacsim.replicator.behavior.base_behavior import INTERVAL, Variable, variable
from usdsdg.compat.isaacsim.replicator.behavior.prims_behavior import INCLUDE_CHILDREN, PrimsBehavior
from usdsdg.compat.isaacsim.replicator.behavior.utils.scene_utils import (
    Rotation,
    calculate_look_at_rotation,
    get_rotation_op_and_value,
    get_world_location,
    set_rotation_op_and_value,
    set_rotation_with_ops,
)

_T = Sdf.ValueTypeNames


class LookAtBehavior(PrimsBehavior):
    """Rotates each prim so that its -Z points at the target, as a camera looks.

    The rotation is written as a local one, which is right where the parents are not rotated.
    """

    BEHAVIOR_NS: ClassVar[str] = "lookAtBehavior"
    VARIABLES_TO_EXPOSE: ClassVar[list[Variable]] = [
        variable("targetLocation", _T.Vector3d, Gf.Vec3d(0.0), "World point to look at."),
        variable("targetPrimPath", _T.String, "", "Path of a prim to look at instead; empty for none."),
        variable("upAxis", _T.Vector3d, Gf.Vec3d(0.0, 0.0, 1.0), "World direction that is up in the view."),
        INCLUDE_CHILDREN,
        INTERVAL,
    ]

    def on_init(self) -> None:
        self._before: dict[Usd.Prim, tuple[str, Rotation]] = {}
        super().on_init()

    def _read_variables(self) -> None:
        self._target_location = self._get_exposed_variable("targetLocation")
        self._up_axis = self._get_exposed_variable("upAxis")

    def _begin(self) -> None:
        self._target = self._prim_at(self._get_exposed_variable("targetPrimPath"))
        super()._begin()

    def _remember(self, prim: Usd.Prim) -> None:
        self._before[prim] = get_rotation_op_and_value(prim)

    def _restore(self, prim: Usd.Prim) -> None:
        if before := self._before.pop(prim, None):
            set_rotation_op_and_value(prim, *before)

    def _apply_behavior(self) -> None:
        target = get_world_location(self._target) if self._target else self._target_location
        for prim in self._valid_prims:
            set_rotation_with_ops(prim, calculate_look_at_rotation(get_world_location(prim), target, self._up_axis))
